//! The arrangement of points.

use crate::invalid::Axis;

/// The arrangement of points: a curve has one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Grid {
    /// Number of points in the u direction.
    pub rows: usize,
    /// Number of points in the v direction.
    pub columns: usize,
}

impl Grid {
    /// Number of points.
    pub fn count(self) -> usize {
        self.rows * self.columns
    }

    /// Returns true if there are rows of points: a curve and scattered points have one column, and surfaces of
    /// rows have two at least.
    pub fn is_rows(self) -> bool {
        self.columns != 1
    }

    /// Number of points along a direction.
    pub fn along(self, axis: Axis) -> usize {
        match axis {
            Axis::U => self.rows,
            Axis::V => self.columns,
        }
    }
}
