//! The equations `B X = P` of a fit, and what a method makes of them.
//!
//! B has a row for each data point and a column for each free control point; P and X have d
//! columns, one for each coordinate. In a least-squares fit B is A, with more rows than columns.

use std::sync::Arc;

use crate::data::points::Points;
use crate::matrix::forecast::Forecast;
use crate::matrix::operator::Operator;
use crate::matrix::transform::Transform;
use crate::setup::Setup;

/// What does not change from level to level: data P, collocation matrix B, transform U, and the
/// forecast of the convergence.
#[derive(Debug)]
pub(crate) struct Equations {
    /// The data and the bases.
    pub setup: Arc<Setup>,
    /// The collocation matrix B.
    pub collocation: Operator,
    /// The transform U.
    pub transform: Transform,
    /// The forecast of the convergence.
    pub forecast: Forecast,
}

impl Equations {
    /// Numbers of scratch space that the transform and the maps of the matrix need.
    pub(crate) fn scratch(&self) -> usize {
        let count = self.setup.data().len();
        self.transform.scratch(&self.collocation, count)
    }

    /// Applies the transform in place: `points ← U points`.
    pub(crate) fn transform(&self, points: &mut Points, scratch: &mut [f64]) {
        self.transform.apply(&self.collocation, points, scratch);
    }

    /// Applies the transform in place and adds other points: `points ← U points + others`.
    pub(crate) fn transform_onto(&self, points: &mut Points, others: &Points, scratch: &mut [f64]) {
        self.transform
            .apply_onto(&self.collocation, points, others, scratch);
    }
}
