//! The parts of a fitting problem, as errors and warnings name them.
//!
//! Places are typed: the languages in which problems are written say where each of them stands.

use serde::{Deserialize, Serialize};

/// A direction of the parameter domain. Curves have only [`Axis::U`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
pub enum Side {
    /// That of the first parameter.
    Start,
    /// That of the last one.
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
    /// How a direction ends.
    Ends(Axis),
    /// How a direction ends on one side.
    End(Axis, Side),
    /// The vectors of an end of one order, counted from zero.
    EndOrder(Axis, Side, usize),
    /// One of the vectors: order, counted from zero, and data point of the boundary.
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
    /// One entry of it: row and column.
    TransformEntry(Axis, usize, usize),
    /// One of the indices of a local fit.
    Index(usize),
    /// The threshold of the data point with this index.
    Threshold(usize),
    /// How much the data point with this index counts.
    DataWeight(usize),
    /// One of the constraints.
    Constraint(usize),
    /// The absolute tolerance.
    Tolerance,
    /// The tolerance relative to the bounding box.
    RelativeTolerance,
}

/// A setting of a method that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The relaxation ω of weighted, local and adaptive PIA.
    Omega,
    /// The threshold of adaptive PIA.
    Threshold,
    /// How near convexity-preserving PIA comes to the longest step.
    StepTolerance,
    /// The step μ of least-squares PIA.
    Mu,
    /// The indices of local PIA.
    Indices,
    /// The lines that local PIA goes by.
    Sweeps,
    /// How much each data point counts in least-squares PIA.
    DataWeights,
    /// Whether least-squares PIA interpolates end points.
    EndPoints,
    /// What least-squares PIA obeys.
    Constraints,
    /// How smooth least-squares PIA is to be.
    Fairness,
    /// The order of the derivative for it.
    FairnessOrder,
    /// The update of least-squares PIA.
    Variant,
    /// Whether parameters move while least-squares PIA chooses its knots.
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
            Self::Variant => "variant",
            Self::CorrectParameters => "correct_parameters",
        }
    }
}
