//! What can be wrong with a fitting problem.

use thiserror::Error;

pub use super::admission::TooMuch;
pub use super::ends::mistake::EndsMistake;
pub use super::method::{ConstraintsMistake, LeastSquaresMistake};
pub use super::place::{Axis, Place, Setting, Side};
pub use super::scattered::ScatteredMistake;

/// Why a problem is refused. The text names the index, the value and the rule; fields have the
/// values that it names: `axis` the direction, `given` and `expected` numbers of values.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "fields are the values that the messages name")]
pub enum Invalid {
    /// The fit takes more than it may.
    #[error(transparent)]
    TooMuch(#[from] TooMuch),
    /// A curve, or a line of a surface, has fewer than 2 data points.
    #[error("at least 2 points are needed in each direction, {count} given")]
    TooFewPoints { count: usize },
    /// A data point is missing, and the method is not a least-squares one.
    #[error("a point is missing; only least-squares fits of surfaces leave points out")]
    MissingPoint { index: usize },
    /// All data points are missing.
    #[error("no point is given")]
    NoPoints,
    /// All distances between two neighbouring lines of points are unknown, as points are missing.
    #[error(
        "no two neighbours of lines {previous} and {index} are given, so that {rule} parameters are unknown: use uniform or explicit parameters"
    )]
    NoNeighbours {
        axis: Axis,
        previous: usize,
        index: usize,
        rule: &'static str,
    },
    /// The bounding box of the data, or the length of a line, overflows.
    #[error("the points span more than the range of 64-bit numbers: scale the data down")]
    TooLarge,
    /// A coordinate is infinite or NaN.
    #[error("coordinate {coordinate} is {value}, which is not a finite number")]
    NotFinite {
        index: usize,
        coordinate: usize,
        value: f64,
    },
    /// Neighbouring points of a curve are equal: their parameters by distance would be equal, too.
    #[error(
        "point {index} equals point {previous} (or is too close to it), so that {rule} parameters do not increase: \
         drop one of them or use uniform or explicit parameters", previous = index - 1
    )]
    EqualPoints {
        axis: Axis,
        index: usize,
        rule: &'static str,
    },
    /// Neighbouring lines of a surface are equal point by point.
    #[error(
        "all points of line {index} equal those of line {previous} (or are too close to them), so that {rule} parameters \
         do not increase: drop one of the lines or use uniform or explicit parameters", previous = index - 1
    )]
    EqualLines {
        axis: Axis,
        index: usize,
        rule: &'static str,
    },
    /// Mistakes of which none follows from another.
    #[error("{first}")]
    Several { first: Box<Self>, rest: Vec<Self> },
    /// The last point of a closed curve repeats the first one, or the last line the first line.
    #[error(
        "the last point equals the first: a closed curve returns to its first point by itself, leave the last one out"
    )]
    FirstRepeated { axis: Axis, index: usize },
    /// A polynomial basis is to be closed.
    #[error("a closed curve is a periodic B-spline: polynomials cannot be closed")]
    ClosedPolynomial { axis: Axis },
    /// Knots of open directions are asked for of a closed one.
    #[error(
        "a closed B-spline has its knots at the data: other rules and explicit knots are for open ones"
    )]
    ClosedKnots { axis: Axis },
    /// A closed direction has no more control points than its degree.
    #[error("degree {degree} needs at least {needed} control points on a closed curve, {count} given", needed = degree + 1)]
    ClosedDegree {
        axis: Axis,
        degree: usize,
        count: usize,
    },
    /// The ends of a direction cannot be as they are asked for.
    #[error(transparent)]
    Ends(#[from] EndsMistake),
    /// The number of explicit parameters of a closed direction is not points + 1.
    #[error(
        "{given} parameters given, {expected} needed: one for each point, and the one at which the closed curve is back at the first"
    )]
    ClosedParameterCount {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    /// A least-squares fit asks for fewer than 2 control points, or for more than data points.
    #[error(
        "{free} control points for {count} data points: give at least 2 and at most {count}, or up to {twice} together with \"fairness\"",
        twice = 2 * count
    )]
    ControlPointCount {
        axis: Axis,
        free: usize,
        count: usize,
    },
    /// An explicit parameter lies outside of the explicit knots.
    #[error("parameter {index} is {value}, outside the range of the knots, {low} to {high}")]
    ParameterOutside {
        axis: Axis,
        index: usize,
        value: f64,
        low: f64,
        high: f64,
    },
    /// Something about scattered points.
    #[error(transparent)]
    Scattered(#[from] ScatteredMistake),
    /// The number of weights is not that of the data points.
    #[error("{given} weights for {expected} points")]
    WeightCount { given: usize, expected: usize },
    /// The weight of a data point is not a finite number greater than 0.
    #[error("weight {index} is {value}; weights are finite and greater than 0")]
    Weight { index: usize, value: f64 },
    /// Homogeneous coordinates `w P` overflow.
    #[error(
        "the products of weights and coordinates exceed the range of 64-bit numbers: scale them down"
    )]
    WeightsTooLarge,
    /// Homogeneous coordinates `w P` underflow.
    #[error(
        "weight {index} is {value}, so small that its products with coordinates lose their digits: scale the weights up"
    )]
    WeightTooSmall { index: usize, value: f64 },
    /// A fixed weight of a direction is not a finite number greater than 0.
    #[error("weight {index} is {value}; weights are finite and greater than 0")]
    AxisWeight {
        axis: Axis,
        index: usize,
        value: f64,
    },
    /// The number of fixed weights of a direction is neither that of its free control points nor
    /// that of its basis functions.
    #[error(
        "{given} weights given; {free} are needed (one for each free control point) or {functions} (end copies included)"
    )]
    AxisWeightCount {
        axis: Axis,
        given: usize,
        free: usize,
        functions: usize,
    },
    /// A grid of fixed weights is not a product of weights of both directions (LBW05 (3.8)).
    #[error(
        "the grid of fixed weights is not a product of weights of the rows and of the columns, as the rational basis of a surface needs: use homogeneous weights, or give those of both directions"
    )]
    NotSeparable,
    /// The relaxation ω does not lie between 0 and 2 (Deng13, Corollary 2.3).
    #[error("omega is {value}; PIA converges for omega between 0 and 2 only")]
    Omega { value: f64 },
    /// A setting is not a finite number greater than 0.
    #[error("{name} is {value}; it must be a finite number greater than 0", name = setting.name())]
    NotPositive { setting: Setting, value: f64 },
    /// The tolerance of the bisection for a step is not a part of it.
    #[error("step_tolerance is {value}; it is a part of a step, greater than 0 and less than 1")]
    PartOfStep { value: f64 },
    /// The number of thresholds is not that of the data points.
    #[error("{given} thresholds for {expected} points")]
    ThresholdCount { given: usize, expected: usize },
    /// The threshold of a point is not a finite number greater than 0.
    #[error("threshold {index} is {value}; thresholds are finite and greater than 0")]
    Threshold { index: usize, value: f64 },
    /// A local fit selects no point.
    #[error("there is no index to adjust")]
    NoIndices,
    /// A local fit selects a point that there is not.
    #[error("index {index} is {value}, but there are {count} points")]
    IndexOutside {
        index: usize,
        value: usize,
        count: usize,
    },
    /// A local fit selects a point twice.
    #[error("index {index} repeats an earlier one")]
    IndexRepeated { index: usize },
    /// A curve is to be fitted row by row, or column by column.
    #[error("sweeps are for surfaces; a curve has no rows and no columns")]
    SweepsOfCurve { setting: Setting },
    /// A method for planar curves is asked for a surface, or for points with other coordinates.
    #[error("{method} fits only planar curves (two coordinates, not homogeneous): {found}")]
    NotPlanar {
        method: &'static str,
        found: &'static str,
    },
    /// A relaxation `U = ω I` diverges with this basis: some eigenvalue of `I − ω B` is larger than
    /// one.
    #[error(
        "{method} PIA diverges: with this basis and these parameters the error grows by {rate:.3} per iteration; use extended or direct"
    )]
    Diverges { method: &'static str, rate: f64 },
    /// A method that chooses its steps by λ_min has eigenvalues that are not real and positive.
    #[error(
        "{method} needs a collocation matrix with positive real eigenvalues, and this one, of a basis that is not totally positive, has others; use extended or direct"
    )]
    ComplexSpectrum { method: &'static str },
    /// A given transform has more rows than are accepted.
    #[error("the transform has {given} rows; it is limited to {limit}")]
    TransformTooLarge {
        axis: Axis,
        given: usize,
        limit: usize,
    },
    /// A given transform has not one row for each control point of the direction.
    #[error(
        "the transform has {given} rows, but there are {expected} control points: it needs a row and a column for each"
    )]
    TransformRows {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    /// A row of a given transform has not one entry for each data point of the direction.
    #[error(
        "row {row} of the transform has {given} entries; it needs {expected}, one for each data point"
    )]
    TransformColumns {
        axis: Axis,
        row: usize,
        given: usize,
        expected: usize,
    },
    /// An entry of a given transform is infinite or NaN.
    #[error("entry {column} of row {row} is {value}, which is not a finite number")]
    TransformEntry {
        axis: Axis,
        row: usize,
        column: usize,
        value: f64,
    },
    /// A second matrix is given for a curve.
    #[error("a curve has one direction, and its transform one matrix")]
    TransformOfCurve,
    /// A given transform has a spectral radius `ρ(I − U B) ≥ 1` (Deng13, Theorem 2.1).
    #[error(
        "the transform U diverges: with this basis and these parameters the spectral radius of I − U B is {rate:.3}, and it must be below 1"
    )]
    TransformDiverges { rate: f64 },
    /// A setting of a least-squares fit is wrong.
    #[error(transparent)]
    LeastSquares(#[from] LeastSquaresMistake),
    /// What a least-squares fit is to obey is wrong.
    #[error(transparent)]
    Constraints(#[from] ConstraintsMistake),
    /// The number of explicit parameters is not that of the data points.
    #[error("{given} parameters for {expected} points")]
    ParameterCount {
        axis: Axis,
        given: usize,
        expected: usize,
    },
    /// Explicit parameters do not strictly increase.
    #[error(
        "parameter {index} is {value}, not greater than the one before, {previous}: parameters must strictly increase"
    )]
    ParameterOrder {
        axis: Axis,
        index: usize,
        value: f64,
        previous: f64,
    },
    /// An explicit parameter is infinite or NaN.
    #[error("parameter {index} is {value}, which is not a finite number")]
    ParameterNotFinite {
        axis: Axis,
        index: usize,
        value: f64,
    },
    /// Parameters overflow, or fall together by rounding when they are scaled.
    #[error(
        "the parameters span more than the range of 64-bit numbers, or too little to be told apart"
    )]
    ParameterRange { axis: Axis },
    /// The degree of a B-spline is 0.
    #[error("degree {degree} is below 1")]
    DegreeTooLow { axis: Axis, degree: usize },
    /// A degree is above [`MAX_DEGREE`](super::basis::MAX_DEGREE). It was `chosen`, or follows from
    /// the number of control points.
    #[error("degree {degree} is above {limit}, the highest that is evaluated to full accuracy")]
    DegreeAboveLimit {
        axis: Axis,
        degree: usize,
        limit: usize,
        chosen: bool,
    },
    /// Explicit knots overflow, or all of them are equal.
    #[error("the knots span more than the range of 64-bit numbers, or nothing")]
    KnotRange { axis: Axis },
    /// Knots at the data or averaged ones are asked for in a least-squares fit.
    #[error(
        "least squares spreads its knots by itself: leave them out, or for open curves name \"spread\", or give numbers"
    )]
    LeastSquaresKnots { axis: Axis },
    /// Knots of least-squares fits are asked for in a fit of another kind.
    #[error("\"spread\" places knots for fewer control points than data: it is for least squares")]
    SpreadKnots { axis: Axis },
    /// A least-squares fit has no more control points than the degree.
    #[error("{free} control points are too few for degree {degree}, which needs {needed}", needed = degree + 1)]
    TooFewControlPoints {
        axis: Axis,
        free: usize,
        degree: usize,
    },
    /// Averaged knots are asked for with no more points than the degree.
    #[error(
        "degree {degree} needs at least {needed} points with averaged knots, {count} given", needed = degree + 1
    )]
    DegreeTooHigh {
        axis: Axis,
        degree: usize,
        count: usize,
    },
    /// The number of explicit knots is not control points + degree + 1.
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
    /// Explicit knots decrease.
    #[error(
        "knot {index} is {value}, less than the one before, {previous}: knots must not decrease"
    )]
    KnotOrder {
        axis: Axis,
        index: usize,
        value: f64,
        previous: f64,
    },
    /// An explicit knot is infinite or NaN.
    #[error("knot {index} is {value}, which is not a finite number")]
    KnotNotFinite {
        axis: Axis,
        index: usize,
        value: f64,
    },
    /// The first or the last degree + 1 explicit knots are not equal.
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
    /// An explicit knot between the ends occurs more than degree times.
    #[error(
        "knot {index} repeats the value {value} more than degree = {degree} times, which breaks the curve"
    )]
    KnotMultiplicity {
        axis: Axis,
        index: usize,
        value: f64,
        degree: usize,
    },
    /// A parameter lies outside of the support of its B-spline, so that the collocation matrix is
    /// singular (Schoenberg, Whitney 1953).
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
    /// The given control points of level 0 are not as many as the fit has, or have other
    /// coordinates.
    #[error(
        "the fit starts from {given} control points, but this one has {expected}, or in other coordinates"
    )]
    StartCount { given: usize, expected: usize },
    /// The tolerance is negative, infinite or NaN.
    #[error("the tolerance is {value}; it must be a finite number, zero or greater")]
    Tolerance { value: f64, relative: bool },
    /// A relative tolerance times the diagonal of the bounding box overflows.
    #[error(
        "the tolerance is {value} times {diagonal}, the diagonal of the bounding box, which exceeds the range of 64-bit numbers"
    )]
    ToleranceTooLarge { value: f64, diagonal: f64 },
}

impl Invalid {
    /// Several mistakes as one; none of none.
    pub(super) fn of_all(mut all: Vec<Self>) -> Option<Self> {
        if all.len() < 2 {
            return all.pop();
        }
        let rest = all.split_off(1);
        let first = Box::new(all.pop()?);
        Some(Self::Several { first, rest })
    }

    /// Each of several mistakes by itself.
    pub fn each(self) -> Vec<Self> {
        match self {
            Self::Several { first, mut rest } => {
                rest.insert(0, *first);
                rest
            }
            mistake => vec![mistake],
        }
    }

    /// Refuses a setting that is not a finite number greater than 0.
    pub(super) fn unless_positive(setting: Setting, value: f64) -> Result<(), Self> {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(Self::NotPositive { setting, value })
        }
    }
}
