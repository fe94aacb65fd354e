//! What can be wrong with a fitting problem.

use thiserror::Error;

/// A direction of the parameter domain. Curves have only [`Axis::U`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The direction of a curve; the rows of a surface.
    U,
    /// The columns of a surface.
    V,
}

/// The part of a problem that an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// All data points.
    Points,
    /// The data point with this index; on surfaces `row · columns + column`.
    Point(usize),
    /// A row (u) or a column (v) of the data of a surface; a data point of a curve.
    Line(Axis, usize),
    /// The degree of a direction.
    Degree(Axis),
    /// The basis of a direction.
    Basis(Axis),
    /// The explicit knots of a direction.
    Knots(Axis),
    /// One explicit knot.
    Knot(Axis, usize),
    /// The parameters of a direction.
    Parameters(Axis),
    /// One explicit parameter.
    Parameter(Axis, usize),
    /// The absolute tolerance.
    Tolerance,
    /// The tolerance relative to the bounding box.
    RelativeTolerance,
}

/// Why a problem is refused. The text names the index, the value and the rule.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages are the documentation")]
pub enum Invalid {
    #[error("at least 2 points are needed in each direction, {count} given")]
    TooFewPoints { count: usize },
    #[error("the points span more than the range of 64-bit numbers: scale the data down")]
    TooLarge,
    #[error("coordinate {coordinate} is {value}, which is not a finite number")]
    NotFinite {
        index: usize,
        coordinate: usize,
        value: f64,
    },
    #[error(
        "point {index} equals point {previous} (or is too close to it), so that {rule} parameters do not increase: \
         drop one of them or use uniform or explicit parameters", previous = index - 1
    )]
    EqualPoints {
        axis: Axis,
        index: usize,
        rule: &'static str,
    },
    #[error(
        "all points of line {index} equal those of line {previous} (or are too close to them), so that {rule} parameters \
         do not increase: drop one of the lines or use uniform or explicit parameters", previous = index - 1
    )]
    EqualLines {
        axis: Axis,
        index: usize,
        rule: &'static str,
    },
    #[error("{given} parameters for {expected} points")]
    ParameterCount {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    #[error(
        "parameter {index} is {value}, not greater than the one before, {previous}: parameters must strictly increase"
    )]
    ParameterOrder {
        axis: Axis,
        index: usize,
        value: f64,
        previous: f64,
    },
    #[error("parameter {index} is {value}, which is not a finite number")]
    ParameterNotFinite {
        axis: Axis,
        index: usize,
        value: f64,
    },
    #[error(
        "the parameters span more than the range of 64-bit numbers, or too little to be told apart"
    )]
    ParameterRange { axis: Axis },
    #[error("degree {degree} is below 1")]
    DegreeTooLow { axis: Axis, degree: usize },
    #[error("degree {degree} is above {limit}, the highest that is evaluated to full accuracy")]
    DegreeAboveLimit {
        axis: Axis,
        degree: usize,
        limit: usize,
    },
    #[error(
        "degree {degree} needs at least {needed} points with averaged knots, {count} given", needed = degree + 1
    )]
    DegreeTooHigh {
        axis: Axis,
        degree: usize,
        count: usize,
    },
    #[error(
        "{given} knots given; degree {degree} and {count} points (one control point each) need {expected} = points + degree + 1"
    )]
    KnotCount {
        axis: Axis,
        given: usize,
        expected: usize,
        degree: usize,
        count: usize,
    },
    #[error(
        "knot {index} is {value}, less than the one before, {previous}: knots must not decrease"
    )]
    KnotOrder {
        axis: Axis,
        index: usize,
        value: f64,
        previous: f64,
    },
    #[error("knot {index} is {value}, which is not a finite number")]
    KnotNotFinite {
        axis: Axis,
        index: usize,
        value: f64,
    },
    #[error(
        "knot {index} is {value}, but the knots must be clamped: the first and the last {needed} equal (the end is {end})"
    )]
    KnotsNotClamped {
        axis: Axis,
        index: usize,
        value: f64,
        end: f64,
        needed: usize,
    },
    #[error(
        "knot {index} repeats the value {value} more than degree = {degree} times, which breaks the curve"
    )]
    KnotMultiplicity {
        axis: Axis,
        index: usize,
        value: f64,
        degree: usize,
    },
    #[error(
        "Schoenberg–Whitney: parameter {index} is {parameter}, outside the support ({low}, {high}) of B-spline {index}, \
         so that the interpolation problem is singular: move knots {index} or {upper}, or the parameter",
        upper = index + degree + 1
    )]
    SchoenbergWhitney {
        axis: Axis,
        index: usize,
        parameter: f64,
        low: f64,
        high: f64,
        degree: usize,
    },
    #[error("the tolerance is {value}; it must be a finite number, zero or greater")]
    Tolerance { value: f64, relative: bool },
}

impl Invalid {
    /// The part of the problem that is wrong.
    pub fn place(&self) -> Place {
        match *self {
            Self::TooFewPoints { .. } | Self::TooLarge => Place::Points,
            Self::NotFinite { index, .. } => Place::Point(index),
            Self::EqualPoints { axis, index, .. } | Self::EqualLines { axis, index, .. } => {
                Place::Line(axis, index)
            }
            Self::ParameterCount { axis, .. } | Self::ParameterRange { axis } => {
                Place::Parameters(axis)
            }
            Self::ParameterOrder { axis, index, .. }
            | Self::ParameterNotFinite { axis, index, .. } => Place::Parameter(axis, index),
            Self::DegreeTooLow { axis, .. } | Self::DegreeTooHigh { axis, .. } => {
                Place::Degree(axis)
            }
            Self::DegreeAboveLimit { axis, .. } => Place::Basis(axis),
            Self::KnotCount { axis, .. } | Self::SchoenbergWhitney { axis, .. } => {
                Place::Knots(axis)
            }
            Self::KnotOrder { axis, index, .. }
            | Self::KnotNotFinite { axis, index, .. }
            | Self::KnotsNotClamped { axis, index, .. }
            | Self::KnotMultiplicity { axis, index, .. } => Place::Knot(axis, index),
            Self::Tolerance {
                relative: false, ..
            } => Place::Tolerance,
            Self::Tolerance { relative: true, .. } => Place::RelativeTolerance,
        }
    }
}
