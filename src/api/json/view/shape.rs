//! The shapes of arrays of numbers, as nested lists.

/// The shape of an array: up to three levels of nested lists; the last index runs fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NestedShape {
    /// How many numbers a list of each level has, the innermost first.
    sizes: [usize; 3],
    depth: usize,
}

impl From<&[usize]> for NestedShape {
    /// Of at most three numbers.
    fn from(counts: &[usize]) -> Self {
        let mut shape = Self {
            sizes: [1; 3],
            depth: counts.len().min(3),
        };
        let mut size = 1;
        for (level, count) in counts.iter().rev().take(3).enumerate() {
            size *= count;
            shape.sizes[level] = size;
        }
        shape
    }
}

impl NestedShape {
    /// How many numbers there are.
    pub(super) fn count(self) -> usize {
        self.lists().last().copied().unwrap_or(1)
    }

    /// How many numbers an innermost list has.
    pub(super) fn innermost(&self) -> usize {
        self.sizes[0]
    }

    /// How many levels of lists there are.
    pub(super) fn depth(&self) -> usize {
        self.depth
    }

    /// The sizes of the lists of each level, the innermost first.
    fn lists(&self) -> &[usize] {
        &self.sizes[..self.depth]
    }

    /// How many lists end before number `at`; as many begin there. Each size is a multiple of the
    /// one before.
    pub(super) fn edges(&self, at: usize) -> usize {
        let ends = |size: &&usize| at.is_multiple_of(**size);
        self.lists().iter().take_while(ends).count()
    }
}
