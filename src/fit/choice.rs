//! What is asked for in one direction of the parameter domain.
//!
//! A curve has one direction, a surface two, whose bases, parameters and closedness are independent
//! of each other.

use super::basis::Polynomial;
use super::basis::knots::Knots;
use super::parameters::Parametrization;

/// The basis asked for in one direction.
#[derive(Clone, Debug, PartialEq)]
pub enum BasisChoice {
    /// Polynomials of degree control points − 1.
    Polynomial(Polynomial),
    /// B-splines.
    BSpline {
        /// The degree p ≥ 1.
        degree: usize,
        /// How the knots are chosen.
        knots: Knots,
    },
}

/// What is asked for in one direction of the parameter domain.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionChoice {
    /// The basis.
    pub basis: BasisChoice,
    /// The parameters of the data points.
    pub parameters: Parametrization,
    /// The last point is followed by the first.
    pub closed: bool,
    /// The number of control points of a least-squares fit; otherwise one for each data point.
    pub control_points: Option<usize>,
    /// Fixed weights: one for each control point, end copies included, or one for each data point.
    pub weights: Option<Vec<f64>>,
}

impl DirectionChoice {
    /// Whether eigenvalues of the collocation matrix may nearly coincide, so that its eigenvectors
    /// are nearly parallel and eigenvalues say little of single levels.
    pub(super) fn is_clustered(&self) -> bool {
        let BasisChoice::BSpline { degree, knots } = &self.basis else {
            return true;
        };
        let averaged = matches!(knots, Knots::Averaged) || self.closed;
        degree % 2 == 0 && !averaged
    }
}
