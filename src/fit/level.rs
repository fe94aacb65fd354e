//! What is known of a level of an iteration.
//!
//! It is small, and is told for every level, whether somebody looks at the control points or not.
//! Errors are in data units; rates have no unit.

use serde::{Deserialize, Serialize};

use super::norms::FitError;

/// A level of the iteration: how far the curve of these control points is from the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The number of updates so far.
    pub iteration: usize,
    /// The distances from the data.
    pub error: FitError,
    /// The largest distance as a multiple of that of the level before.
    pub rate: Option<f64>,
    /// How many control points the last update moved.
    pub moved: usize,
    /// Homogeneous fits: the first control point whose weight is not positive, and that weight.
    pub bad_weight: Option<(usize, f64)>,
    /// The level at which the fit will end, by what is known at this level.
    pub predicted: Option<usize>,
}
