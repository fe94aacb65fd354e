//! What can be wrong with the settings of least squares.

use thiserror::Error;

use crate::fit::invalid::{Axis, Place, Setting};

/// Why settings are refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "fields are the values that the messages name")]
pub enum LeastSquaresMistake {
    /// There is no number of control points, and no knots that imply it.
    #[error(
        "least_squares needs control_points: their number, on surfaces also {{\"u\": …, \"v\": …}}, or \"auto\"; only explicit knots imply it"
    )]
    Count,
    /// The number of weights of data is not that of the data points.
    #[error("{given} weights of data for {expected} points")]
    DataWeightCount { given: usize, expected: usize },
    /// The weight of a data point is negative, infinite or NaN.
    #[error("data weight {index} is {value}; weights of data are finite and not negative")]
    DataWeight { index: usize, value: f64 },
    /// No data point counts.
    #[error("all weights of data are zero, so that no data point counts")]
    NoDataWeight,
    /// Fairness is negative, infinite or NaN.
    #[error("fairness is {value}; it is a finite number, zero or greater")]
    Fairness { value: f64 },
    /// Fairness by a derivative of another order than 2 or 3.
    #[error("fairness is by the second or the third derivative, and order {order} is asked for")]
    FairnessOrder { order: usize },
    /// Fairness of a rational curve.
    #[error("fairness is that of polynomial curves and surfaces: this one has weights")]
    FairnessOfRational,
    /// Fairness in a basis whose derivatives are not known.
    #[error("fairness needs derivatives, which B-splines and Bernstein polynomials have here")]
    FairnessOfBasis,
    /// The factorization of the normal equations of a whole surface would take too long.
    #[error(
        "direct has to factorize the normal equations of the whole surface here, and there are too many control points for that: use cg"
    )]
    NormalEquations,
    /// An automatic fit with a variant.
    #[error(
        "with control_points \"auto\" the fit takes steps of conjugate gradients and minima in turn: variant is left out, or cg"
    )]
    AutomaticVariant,
    /// An automatic rational fit.
    #[error("with control_points \"auto\" curves and surfaces have no weights")]
    AutomaticRational,
    /// Knots of an automatic fit.
    #[error(
        "with control_points \"auto\" the fit chooses the knots of a B-spline by itself: the basis is bspline, and knots are left out"
    )]
    AutomaticKnots {
        /// The direction.
        axis: Axis,
    },
    /// Corrected parameters of a surface, or of a curve that obeys or weighs more than distances.
    #[error(
        "correct_parameters is for curves without constraints and fairness whose ends are interpolated"
    )]
    AutomaticCorrection,
    /// An automatic fit of a grid with holes.
    #[error(
        "with control_points \"auto\" no point of a grid is missing: give those that are there as scattered points"
    )]
    AutomaticMissing {
        /// The first that is.
        index: usize,
    },
    /// A boundary of an automatic surface with given control points.
    #[error(
        "with control_points \"auto\" the knots along a boundary change from level to level: one with given control points needs a number of them"
    )]
    AutomaticBoundary {
        /// The constraint.
        index: usize,
    },
}

impl LeastSquaresMistake {
    /// The part of the problem that is wrong.
    pub(in crate::fit) fn place(&self) -> Place {
        match *self {
            Self::DataWeightCount { .. } | Self::NoDataWeight => {
                Place::Setting(Setting::DataWeights)
            }
            Self::DataWeight { index, .. } => Place::DataWeight(index),
            Self::Fairness { .. } | Self::FairnessOfRational | Self::FairnessOfBasis => {
                Place::Setting(Setting::Fairness)
            }
            Self::FairnessOrder { .. } => Place::Setting(Setting::FairnessOrder),
            Self::Count | Self::NormalEquations => Place::Method,
            Self::AutomaticVariant => Place::Setting(Setting::Variant),
            Self::AutomaticCorrection => Place::Setting(Setting::CorrectParameters),
            Self::AutomaticRational => Place::Weights,
            Self::AutomaticKnots { axis } => Place::Basis(axis),
            Self::AutomaticMissing { index } => Place::Point(index),
            Self::AutomaticBoundary { index } => Place::Constraint(index),
        }
    }
}
