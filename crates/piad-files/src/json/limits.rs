//! Limits on the length of the lists of a JSON text while it is read.

/// Shorter lists grow without limits.
#[doc(hidden)]
pub const LIMITED_LENGTH: usize = 1024;

/// The limits of the lists in a text.
#[derive(Clone, Copy, Debug)]
pub struct ListLimits {
    /// The most data points.
    pub points: usize,
    /// An upper bound of the number of elements of all lists; 0 if it is not known.
    elements: usize,
}

impl ListLimits {
    /// No limits.
    pub const NONE: Self = Self {
        points: usize::MAX,
        elements: 0,
    };

    /// The limits of lists in this JSON, which has at most `points` data points.
    pub fn new(text: &[u8], points: usize) -> Self {
        let commas = memchr::memchr_iter(b',', text).count();
        Self {
            points,
            elements: commas + 1,
        }
    }

    /// Reserves memory for all elements that can follow in a list that has become long, of which `most` are allowed.
    /// Growth by doubling would need three times the memory during the move; memory that is not written to costs
    /// nothing.
    pub fn make_room<T>(self, list: &mut Vec<T>, most: usize) {
        if list.len() == list.capacity() && list.len() >= LIMITED_LENGTH {
            let more = most.min(self.elements).saturating_sub(list.len());
            // If this much memory is not available, the capacity doubles.
            let _ = list.try_reserve_exact(more);
        }
    }

    /// The largest number of points with this many coordinates that can follow in the text.
    pub(super) fn points_of(self, dimension: usize) -> usize {
        (self.elements / dimension).min(self.points)
    }
}
