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
    /// The number of control points of a least-squares fit in a direction.
    ControlPoints(Axis),
    /// Whether a direction is closed.
    Closed(Axis),
    /// All weights.
    Weights,
    /// The weight of the data point with this index.
    Weight(usize),
    /// The fixed weights of a direction.
    AxisWeights(Axis),
    /// One fixed weight of a direction.
    AxisWeight(Axis, usize),
    /// The method.
    Method,
    /// A setting of the method.
    Setting(Setting),
    /// The matrix of a custom transform in a direction.
    Transform(Axis),
    /// One row of it.
    TransformRow(Axis, usize),
    /// One entry of it: row and column.
    TransformEntry(Axis, usize, usize),
    /// One of the indices of a local fit.
    Index(usize),
    /// The absolute tolerance.
    Tolerance,
    /// The tolerance relative to the bounding box.
    RelativeTolerance,
}

/// A setting of a method that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The relaxation ω of weighted PIA.
    Omega,
    /// The threshold of adaptive PIA.
    Threshold,
    /// The step μ of least-squares PIA.
    Mu,
    /// The indices of local PIA.
    Indices,
    /// Whether local PIA goes row by row.
    RowByRow,
}

impl Setting {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Omega => "omega",
            Self::Threshold => "threshold",
            Self::Mu => "mu",
            Self::Indices => "indices",
            Self::RowByRow => "row_by_row",
        }
    }
}

/// Why a problem is refused. The text names the index, the value and the rule.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "the messages are the documentation")]
pub enum Invalid {
    #[error("at least 2 points are needed in each direction, {count} given")]
    TooFewPoints { count: usize },
    #[error("a point is missing; only least-squares fits of surfaces leave points out")]
    MissingPoint { index: usize },
    #[error("no point is given")]
    NoPoints,
    #[error(
        "no two neighbours of lines {previous} and {index} are given, so that {rule} parameters are unknown: use uniform or explicit parameters", previous = index - 1
    )]
    NoNeighbours {
        axis: Axis,
        index: usize,
        rule: &'static str,
    },
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
    #[error(
        "the last point equals the first: a closed curve returns to its first point by itself, leave the last one out"
    )]
    FirstRepeated { axis: Axis, index: usize },
    #[error("a closed curve is a periodic B-spline: polynomials cannot be closed")]
    ClosedPolynomial { axis: Axis },
    #[error(
        "a closed B-spline has its knots at the data: \"averaged\" and explicit knots are for open ones"
    )]
    ClosedKnots { axis: Axis },
    #[error("degree {degree} needs at least {needed} control points on a closed curve, {count} given", needed = degree + 1)]
    ClosedDegree {
        axis: Axis,
        degree: usize,
        count: usize,
    },
    #[error(
        "{given} parameters given, {expected} needed: one for each point, and the one at which the closed curve is back at the first"
    )]
    ClosedParameterCount {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    #[error(
        "{free} control points for {count} data points: there must be at least 2 and not more than data points"
    )]
    ControlPointCount {
        axis: Axis,
        free: usize,
        count: usize,
    },
    #[error("parameter {index} is {value}, outside the range of the knots, {low} to {high}")]
    ParameterOutside {
        axis: Axis,
        index: usize,
        value: f64,
        low: f64,
        high: f64,
    },
    #[error("{given} weights for {expected} points")]
    WeightCount { given: usize, expected: usize },
    #[error("weight {index} is {value}; weights are finite and greater than 0")]
    Weight { index: usize, value: f64 },
    #[error(
        "the products of weights and coordinates exceed the range of 64-bit numbers: scale them down"
    )]
    WeightsTooLarge,
    #[error(
        "weight {index} is {value}, so small that its products with coordinates lose their digits: scale the weights up"
    )]
    WeightTooSmall { index: usize, value: f64 },
    #[error("weight {index} is {value}; weights are finite and greater than 0")]
    AxisWeight {
        axis: Axis,
        index: usize,
        value: f64,
    },
    #[error(
        "{given} weights given; {free} are needed (one for each free control point) or {functions} (end copies included)"
    )]
    AxisWeightCount {
        axis: Axis,
        given: usize,
        free: usize,
        functions: usize,
    },
    #[error(
        "the grid of fixed weights is not a product of weights of the rows and of the columns, as the rational basis of a surface needs: use \"homogeneous\", or {{\"u\": […], \"v\": […]}}"
    )]
    NotSeparable,
    #[error("omega is {value}; weighted PIA converges for omega between 0 and 2 only")]
    Omega { value: f64 },
    #[error("{name} is {value}; it must be a finite number greater than 0", name = setting.name())]
    NotPositive { setting: Setting, value: f64 },
    #[error("there is no index to adjust")]
    NoIndices,
    #[error("index {index} is {value}, but there are {count} points")]
    IndexOutside {
        index: usize,
        value: usize,
        count: usize,
    },
    #[error("index {index} repeats an earlier one")]
    IndexRepeated { index: usize },
    #[error("row_by_row is for surfaces; a curve has no rows")]
    RowsOfCurve,
    #[error("{method} fits only planar curves (two coordinates, not homogeneous): {found}")]
    NotPlanar {
        method: &'static str,
        found: &'static str,
    },
    #[error(
        "{method} PIA diverges: with this basis and these parameters the error grows by {rate:.3} per iteration; use extended or direct"
    )]
    Diverges { method: &'static str, rate: f64 },
    #[error(
        "{method} needs a collocation matrix with positive real eigenvalues, and this one, of a basis that is not totally positive, has others; use extended or direct"
    )]
    ComplexSpectrum { method: &'static str },
    #[error("the transform has {given} rows; it is limited to {limit}")]
    TransformTooLarge {
        axis: Axis,
        given: usize,
        limit: usize,
    },
    #[error(
        "the transform has {given} rows, but there are {expected} control points: it needs a row and a column for each"
    )]
    TransformRows {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    #[error(
        "row {row} of the transform has {given} entries; it needs {expected}, one for each data point"
    )]
    TransformColumns {
        axis: Axis,
        row: usize,
        given: usize,
        expected: usize,
    },
    #[error("entry {column} of row {row} is {value}, which is not a finite number")]
    TransformEntry {
        axis: Axis,
        row: usize,
        column: usize,
        value: f64,
    },
    #[error("a curve has one direction, and its transform one matrix")]
    TransformOfCurve,
    #[error(
        "the transform U diverges: with this basis and these parameters the spectral radius of I − U B is {rate:.3}, and it must be below 1"
    )]
    TransformDiverges { rate: f64 },
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
        chosen: bool,
    },
    #[error("the knots span more than the range of 64-bit numbers, or nothing")]
    KnotRange { axis: Axis },
    #[error(
        "least squares places its knots by itself (Piegl & Tiller (9.68)): leave them out, or give numbers for open curves"
    )]
    LeastSquaresKnots { axis: Axis },
    #[error("{free} control points are too few for degree {degree}, which needs {needed}", needed = degree + 1)]
    TooFewControlPoints {
        axis: Axis,
        free: usize,
        degree: usize,
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
    #[error(
        "the fit starts from {given} control points, but this one has {expected}, or in other coordinates"
    )]
    StartCount { given: usize, expected: usize },
    #[error("the tolerance is {value}; it must be a finite number, zero or greater")]
    Tolerance { value: f64, relative: bool },
    #[error(
        "the tolerance is {value} times {diagonal}, the diagonal of the bounding box, which exceeds the range of 64-bit numbers"
    )]
    ToleranceTooLarge { value: f64, diagonal: f64 },
}

impl Invalid {
    /// Refuses a setting that is not a finite number greater than 0.
    pub(super) fn unless_positive(setting: Setting, value: f64) -> Result<(), Self> {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(Self::NotPositive { setting, value })
        }
    }

    /// The part of the problem that is wrong.
    pub fn place(&self) -> Place {
        match *self {
            Self::TooFewPoints { .. } | Self::TooLarge | Self::NoPoints => Place::Points,
            Self::MissingPoint { index } => Place::Point(index),
            Self::NoNeighbours { axis, index, .. } => Place::Line(axis, index),
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
            Self::DegreeAboveLimit {
                axis, chosen: true, ..
            } => Place::Degree(axis),
            Self::DegreeAboveLimit { axis, .. } => Place::Basis(axis),
            Self::KnotRange { axis } | Self::LeastSquaresKnots { axis } => Place::Knots(axis),
            Self::TooFewControlPoints { axis, .. } => Place::ControlPoints(axis),
            Self::KnotCount { axis, .. } | Self::SchoenbergWhitney { axis, .. } => {
                Place::Knots(axis)
            }
            Self::KnotOrder { axis, index, .. }
            | Self::KnotNotFinite { axis, index, .. }
            | Self::KnotsNotClamped { axis, index, .. }
            | Self::KnotMultiplicity { axis, index, .. } => Place::Knot(axis, index),
            Self::FirstRepeated { axis, index } => Place::Line(axis, index),
            Self::ClosedPolynomial { axis } => Place::Closed(axis),
            Self::ClosedKnots { axis } => Place::Knots(axis),
            Self::ClosedDegree { axis, .. } => Place::Degree(axis),
            Self::ClosedParameterCount { axis, .. } => Place::Parameters(axis),
            Self::ControlPointCount { axis, .. } => Place::ControlPoints(axis),
            Self::ParameterOutside { axis, index, .. } => Place::Parameter(axis, index),
            Self::WeightCount { .. } | Self::NotSeparable | Self::WeightsTooLarge => Place::Weights,
            Self::Weight { index, .. } | Self::WeightTooSmall { index, .. } => Place::Weight(index),
            Self::AxisWeight { axis, index, .. } => Place::AxisWeight(axis, index),
            Self::AxisWeightCount { axis, .. } => Place::AxisWeights(axis),
            Self::Omega { .. } => Place::Setting(Setting::Omega),
            Self::NotPositive { setting, .. } => Place::Setting(setting),
            Self::NoIndices => Place::Setting(Setting::Indices),
            Self::IndexOutside { index, .. } | Self::IndexRepeated { index } => Place::Index(index),
            Self::RowsOfCurve => Place::Setting(Setting::RowByRow),
            Self::TransformTooLarge { axis, .. } | Self::TransformRows { axis, .. } => {
                Place::Transform(axis)
            }
            Self::TransformColumns { axis, row, .. } => Place::TransformRow(axis, row),
            Self::TransformEntry {
                axis, row, column, ..
            } => Place::TransformEntry(axis, row, column),
            Self::TransformOfCurve => Place::Transform(Axis::V),
            Self::StartCount { .. } | Self::TransformDiverges { .. } => Place::Method,
            Self::NotPlanar { .. } | Self::Diverges { .. } | Self::ComplexSpectrum { .. } => {
                Place::Method
            }
            Self::Tolerance {
                relative: false, ..
            } => Place::Tolerance,
            Self::Tolerance { relative: true, .. } | Self::ToleranceTooLarge { .. } => {
                Place::RelativeTolerance
            }
        }
    }
}
