//! How far the data are from what is drawn.

use crate::export::deviation::Deviations;

/// Distances of the data, and the largest of them.
pub(super) struct Measured {
    pub(super) deviations: Deviations,
    pub(super) most: f64,
}
