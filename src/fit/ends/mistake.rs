//! What can be wrong with the ends that are asked for.

use thiserror::Error;

use crate::fit::place::{Axis, Place, Side};

/// The highest degree whose ends are estimated: polynomials through more points lose all digits.
pub const MOST_ESTIMATED: usize = 31;

/// Why ends are refused. The text names the value and the rule; fields have the values that it names.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "fields are the values that the messages name")]
pub enum EndsMistake {
    /// Ends are chosen of a direction that has none to choose.
    #[error("ends are chosen for open B-splines with knots at the data: {found}")]
    NoEnds { axis: Axis, found: &'static str },
    /// Natural ends of another degree than 3.
    #[error("natural ends are those of cubic B-splines; this one has degree {degree}")]
    NaturalDegree {
        axis: Axis,
        side: Side,
        degree: usize,
    },
    /// Natural ends with fixed weights for which the control point beside the end would leave the
    /// segment between its neighbours.
    #[error(
        "with these fixed weights the {side} has no natural form, as its control point would leave the segment between its neighbours: use estimated ends",
        side = side.name()
    )]
    NaturalWeights { axis: Axis, side: Side },
    /// Estimated derivatives of a high degree.
    #[error(
        "derivatives are estimated up to degree {limit}, and this B-spline has degree {degree}: use repeated ends",
        limit = MOST_ESTIMATED
    )]
    EstimatedDegree {
        axis: Axis,
        side: Side,
        degree: usize,
    },
    /// More derivatives are given at an end than there are control points to choose.
    #[error("{given} derivatives given; degree {degree} has room for {most} at the {side}", side = side.name())]
    EndOrders {
        axis: Axis,
        side: Side,
        given: usize,
        most: usize,
        degree: usize,
    },
    /// The vectors of an end are not one for each data point of the boundary.
    #[error(
        "{given} vectors given; {expected} are needed, one for each data point of this boundary"
    )]
    EndVectorCount {
        axis: Axis,
        side: Side,
        order: usize,
        given: usize,
        expected: usize,
    },
    /// The vectors of an end have not as many coordinates as the points.
    #[error("this vector has {given} coordinates; the points have {expected}")]
    EndVectorDimension {
        axis: Axis,
        side: Side,
        order: usize,
        given: usize,
        expected: usize,
    },
    /// A coordinate of a vector of an end is infinite or NaN.
    #[error("coordinate {coordinate} is {value}, which is not a finite number")]
    EndVectorNotFinite {
        axis: Axis,
        side: Side,
        order: usize,
        index: usize,
        coordinate: usize,
        value: f64,
    },
    /// A tangent is the zero vector.
    #[error("the zero vector has no direction, so that it is no tangent")]
    ZeroTangent {
        axis: Axis,
        side: Side,
        index: usize,
    },
    /// Control points at the ends leave the range of numbers.
    #[error(
        "the derivatives at the ends exceed the range of 64-bit numbers: scale the data down, or use repeated ends"
    )]
    EndsTooLarge { axis: Axis },
}

impl EndsMistake {
    /// The part of the problem that is wrong.
    pub(in crate::fit) fn place(&self) -> Place {
        match *self {
            Self::NoEnds { axis, .. } | Self::EndsTooLarge { axis } => Place::Ends(axis),
            Self::NaturalDegree { axis, side, .. }
            | Self::NaturalWeights { axis, side }
            | Self::EstimatedDegree { axis, side, .. } => Place::End(axis, side),
            Self::EndOrders {
                axis, side, most, ..
            } => Place::EndOrder(axis, side, most),
            Self::EndVectorCount {
                axis, side, order, ..
            }
            | Self::EndVectorDimension {
                axis, side, order, ..
            } => Place::EndOrder(axis, side, order),
            Self::EndVectorNotFinite {
                axis,
                side,
                order,
                index,
                ..
            } => Place::EndVector(axis, side, order, index),
            Self::ZeroTangent { axis, side, index } => Place::EndVector(axis, side, 0, index),
        }
    }
}
