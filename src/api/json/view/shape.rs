//! The shapes of arrays of numbers, as nested lists.

/// The shape of an array: up to [`NestedShape::DEEPEST`] levels of nested lists; the last index runs fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NestedShape {
    /// The number of numbers in a list of each level, the innermost first.
    sizes: [usize; NestedShape::DEEPEST],
    depth: usize,
}

impl From<&[usize]> for NestedShape {
    /// Of at most [`NestedShape::DEEPEST`] numbers.
    fn from(counts: &[usize]) -> Self {
        let mut shape = Self {
            sizes: [1; Self::DEEPEST],
            depth: counts.len().min(Self::DEEPEST),
        };
        let mut size = 1;
        for (level, count) in counts.iter().rev().take(Self::DEEPEST).enumerate() {
            size *= count;
            shape.sizes[level] = size;
        }
        shape
    }
}

impl NestedShape {
    /// The most levels of lists.
    pub(super) const DEEPEST: usize = 3;

    /// The number of numbers.
    pub(crate) fn count(self) -> usize {
        self.lists().last().copied().unwrap_or(1)
    }

    /// The number of numbers in an innermost list.
    pub(super) fn innermost(&self) -> usize {
        self.sizes[0]
    }

    /// The sizes of the lists of each level, the innermost first.
    fn lists(&self) -> &[usize] {
        &self.sizes[..self.depth]
    }

    /// The number of lists that end before number `at`; the same number begin there. Each size is a multiple of the one
    /// before.
    pub(super) fn edges(&self, at: usize) -> usize {
        let ends = |size: &&usize| at.is_multiple_of(**size);
        self.lists().iter().take_while(ends).count()
    }
}
