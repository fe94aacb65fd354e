//! Validation errors of a fitting problem, with their locations.

use thiserror::Error;

/// Why a problem is refused. The text names the index, the value and the rule.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{detail}")]
pub struct Invalid {
    /// The part of the problem that is wrong.
    pub place: Place,
    detail: String,
    /// Independent further errors.
    others: Vec<Self>,
}

/// The number of things differs from that of the points that have one each.
#[doc(hidden)]
pub fn one_for_each(given: usize, things: &str, points: usize) -> String {
    format!("{given} {things} for {points} points: one for each is needed")
}

impl Invalid {
    /// A validation error in a part of the problem.
    pub(super) fn at(place: Place, detail: impl Into<String>) -> Self {
        Self {
            place,
            detail: detail.into(),
            others: Vec::new(),
        }
    }

    /// Combines several errors into one; `None` if there are none.
    pub(super) fn of_all(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut all = all.into_iter();
        let first = all.next()?;
        let others = all.collect();
        Some(Self { others, ..first })
    }

    /// The combined errors, one by one.
    pub fn each(mut self) -> Vec<Self> {
        let mut all = std::mem::take(&mut self.others);
        all.insert(0, self);
        all
    }

    /// Refuses a setting that is not a finite number greater than 0.
    pub(super) fn unless_positive(setting: Setting, value: f64) -> Result<(), Self> {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        let name = setting.name();
        let detail = format!("{name} is {value}; it must be a finite number greater than 0");
        Err(Self::at(Place::Setting(setting), detail))
    }

    /// A curve, or a line of a surface, has fewer than 2 data points.
    pub(super) fn too_few_points(count: usize) -> Self {
        Self::at(
            Place::Points,
            format!("at least 2 points are needed in each direction, {count} given"),
        )
    }

    /// The bounding box of the data, or the length of a line, overflows.
    pub(super) fn too_large() -> Self {
        Self::at(
            Place::Points,
            "the points span more than the range of 64-bit numbers: scale the data down",
        )
    }

    /// The number of explicit parameters is not that of the data points.
    pub(super) fn parameter_count(axis: Axis, given: usize, expected: usize) -> Self {
        Self::at(
            Place::Parameters(axis),
            one_for_each(given, "parameters", expected),
        )
    }

    /// An explicit parameter is infinite or NaN.
    pub(super) fn parameter_not_finite(axis: Axis, index: usize, value: f64) -> Self {
        Self::at(
            Place::Parameter(axis, index),
            format!("parameter {index} is {value}, which is not a finite number"),
        )
    }

    /// An explicit parameter lies outside of the explicit knots.
    pub(super) fn parameter_outside(
        axis: Axis,
        index: usize,
        value: f64,
        range: (f64, f64),
    ) -> Self {
        let (low, high) = range;
        let detail = format!(
            "parameter {index} is {value}, outside the range of the knots, {low} to {high}"
        );
        Self::at(Place::Parameter(axis, index), detail)
    }

    /// Parameters overflow, or coincide by rounding when they are scaled.
    pub(super) fn parameter_range(axis: Axis) -> Self {
        Self::at(
            Place::Parameters(axis),
            "the parameters span more than the range of 64-bit numbers, or too little to be distinct",
        )
    }

    /// A least-squares fit has too few control points for the degree.
    pub(super) fn too_few_control_points(axis: Axis, free: usize, degree: usize) -> Self {
        let needed = degree + 1;
        let detail =
            format!("{free} control points are too few for degree {degree}, which needs {needed}");
        Self::at(Place::ControlPoints(axis), detail)
    }

    /// The basis or the knots are given for a fit that chooses its knots.
    pub(super) fn automatic_knots(axis: Axis) -> Self {
        Self::at(
            Place::Basis(axis),
            "a fit that chooses the number of its control points chooses the knots of a B-spline, too: no other basis and no knots can be given",
        )
    }

    /// The number of weights is not that of the data points.
    pub fn weight_count(given: usize, expected: usize) -> Self {
        Self::at(Place::Weights, one_for_each(given, "weights", expected))
    }

    /// A fixed weight of a direction is not a finite number greater than 0.
    pub fn axis_weight(axis: Axis, index: usize, value: f64) -> Self {
        let detail = format!("weight {index} is {value}; weights are finite and greater than 0");
        Self::at(Place::AxisWeight(axis, index), detail)
    }

    /// The relaxation ω does not lie between 0 and 2 (Deng13, Corollary 2.3).
    pub(super) fn omega(value: f64) -> Self {
        Self::at(
            Place::Setting(Setting::Omega),
            format!("omega is {value}; PIA converges for omega between 0 and 2 only"),
        )
    }

    /// A direction has no ends to choose.
    pub(super) fn no_ends(axis: Axis, found: &str) -> Self {
        Self::at(
            Place::Ends(axis),
            format!("ends are chosen for open B-splines with knots at the data: {found}"),
        )
    }
}

/// A direction of the parameter domain. Curves have only [`Axis::U`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Axis {
    /// The direction of a curve; the rows of a surface.
    U,
    /// The columns of a surface.
    V,
}

impl Axis {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::U => "u",
            Self::V => "v",
        }
    }
}

/// A side of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Side {
    /// The first parameter.
    Start,
    /// The last parameter.
    End,
}

impl Side {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::End => "end",
        }
    }
}

/// The location of an error. Each encoding of problems maps it to a path or line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The whole problem.
    Whole,
    /// All data points.
    Points,
    /// The data point with this index; on surfaces `row · columns + column`.
    Point(usize),
    /// One of the sections of a surface.
    Section(usize),
    /// The triangle with this index of a mesh.
    Triangle(usize),
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
    /// The `closed` setting of a direction.
    Closed(Axis),
    /// The corners of a direction.
    Corners(Axis),
    /// The element at an index of the list.
    Corner(Axis, usize),
    /// The order of the points of a curve.
    Order,
    /// The treatment of repeated points of a curve.
    RepeatedPoints,
    /// The `polyline` setting, whose edges are data, too.
    Polyline,
    /// The `trim` setting of a surface.
    Trim,
    /// The largest distance of data from the outline of a trimmed surface.
    TrimDistance,
    /// The end conditions of a direction.
    Ends(Axis),
    /// The end condition of one side of a direction.
    End(Axis, Side),
    /// The vectors of one order at an end, counted from zero.
    EndOrder(Axis, Side, usize),
    /// One such vector: order, counted from zero, and data point of the boundary.
    EndVector(Axis, Side, usize, usize),
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
    /// One entry: row and column.
    TransformEntry(Axis, usize, usize),
    /// One of the indices of a local fit.
    Index(usize),
    /// The threshold of the data point with this index.
    Threshold(usize),
    /// The weight of the data point with this index in the sum of squares.
    DataWeight(usize),
    /// One of the constraints.
    Constraint(usize),
    /// The absolute tolerance.
    Tolerance,
    /// The tolerance relative to the bounding box.
    RelativeTolerance,
}

/// A setting of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The relaxation ω of weighted, local and adaptive PIA.
    Omega,
    /// The threshold of adaptive PIA.
    Threshold,
    /// The fraction of the longest step in convexity-preserving PIA.
    StepTolerance,
    /// The step μ of least-squares PIA.
    Mu,
    /// The indices of local PIA.
    Indices,
    /// The selected lines of local PIA.
    Sweeps,
    /// The weights of the sum of squares in least-squares PIA.
    DataWeights,
    /// The choice to interpolate end points in least-squares PIA.
    EndPoints,
    /// The constraints of least-squares PIA.
    Constraints,
    /// The fairness of least-squares PIA.
    Fairness,
    /// The order of the derivative in the fairness.
    FairnessOrder,
    /// The stiffness of least-squares surfaces where they have no data.
    GapStiffness,
    /// The choice to leave outliers out of least-squares PIA.
    Robust,
    /// The update of least-squares PIA.
    Variant,
    /// Parameter correction while least-squares PIA chooses its knots.
    CorrectParameters,
}

impl Setting {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Omega => "omega",
            Self::Threshold => "threshold",
            Self::StepTolerance => "step_tolerance",
            Self::Mu => "mu",
            Self::Indices => "indices",
            Self::Sweeps => "sweeps",
            Self::DataWeights => "data_weights",
            Self::EndPoints => "end_points",
            Self::Constraints => "constraints",
            Self::Fairness => "fairness",
            Self::FairnessOrder => "fairness_order",
            Self::GapStiffness => "gap_stiffness",
            Self::Robust => "robust",
            Self::Variant => "variant",
            Self::CorrectParameters => "correct_parameters",
        }
    }
}
