//! Common parts of iterations and results: the control net, knots and weights.

use std::borrow::Cow;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::arrays::{KnotArray, NumberArray, PointArray, WeightArray};
use super::document::Document;
use super::error::index;
use super::source::{Along, NetPoints, NetWeights};
use crate::model::per_direction::PerDirection;
use crate::model::settings::Index;
use piad_fit::data::Points;
use piad_fit::engine::{Direction, Level, Problem};
use piad_fit::invalid::Axis;

/// The complete control net of a level.
pub(super) struct ControlNet {
    pub(super) shape: Vec<usize>,
    pub(super) points: PointArray,
    /// Weights of homogeneous fits.
    pub(super) weights: Option<WeightArray>,
}

impl ControlNet {
    pub(super) fn new(
        document: &mut Document,
        problem: &Arc<Problem>,
        points: &Arc<Points>,
    ) -> Self {
        let shape = net_shape(problem);
        let net = || NetPoints {
            problem: Arc::clone(problem),
            control_points: Arc::clone(points),
        };
        let points = document.points(&shape, net());
        let places = &shape[..shape.len() - 1];
        let weights = problem
            .is_homogeneous()
            .then(|| document.weights(places, NetWeights(net())));
        Self {
            shape,
            points,
            weights,
        }
    }
}

/// The numbers of control points in each direction, and of coordinates.
pub(super) fn net_shape(problem: &Problem) -> Vec<usize> {
    let functions = problem.directions().map(|it| it.basis.functions());
    functions.chain([problem.dimension()]).collect()
}

/// The number of points in each direction, and of coordinates. Weights have the same without the last number.
#[derive(Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(extend("minItems" = 2, "maxItems" = 3, "examples" = [[102, 3]]))]
pub(super) struct ArrayShape(pub(super) Vec<usize>);

/// A control point whose weight is not positive at this iteration.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"control_point": 4, "weight": -0.01, "detail": "a weight of a control point is not positive at this level"}]))]
pub(super) struct BadWeight {
    /// The control point, by the index of its data point.
    control_point: Index,
    /// Its weight.
    weight: f64,
    /// The reason.
    detail: &'static str,
}

impl BadWeight {
    /// The warning about a homogeneous level: CAD kernels do not accept weights that are not positive.
    pub(super) fn of(level: &Level, problem: &Problem) -> Option<Self> {
        let (index, weight) = level.bad_weight?;
        Some(Self {
            control_point: self::index(index, problem),
            weight,
            detail: "a weight of a control point is not positive at this level",
        })
    }
}

/// One value for a curve, one for each direction of a surface.
pub(super) fn each<T>(
    problem: &Problem,
    mut value: impl FnMut(Axis, &Direction) -> T,
) -> PerDirection<T> {
    match problem.v() {
        None => PerDirection::Both(value(Axis::U, problem.u())),
        Some(v) => PerDirection::Each {
            u: value(Axis::U, problem.u()),
            v: value(Axis::V, v),
        },
    }
}

/// Numbers of a direction.
pub(super) fn line(
    problem: &Arc<Problem>,
    axis: Axis,
    numbers: fn(&Direction) -> Cow<'_, [f64]>,
) -> Along {
    Along {
        problem: Arc::clone(problem),
        axis,
        numbers,
    }
}

/// The parameters of the data points.
pub(super) fn parameters(
    document: &mut Document,
    problem: &Arc<Problem>,
) -> PerDirection<NumberArray> {
    each(problem, |axis, _| {
        let line = line(problem, axis, |it| it.parameters.as_slice().into());
        document.exact_numbers(line.count(), line)
    })
}

/// The knots of each direction, in full.
pub(super) fn knots(document: &mut Document, problem: &Arc<Problem>) -> PerDirection<KnotArray> {
    each(problem, |axis, direction| {
        let knots = direction.basis.knots().map(|_| {
            let knots = line(problem, axis, |it| it.basis.knots().unwrap_or_default());
            document.exact_numbers(knots.count(), knots)
        });
        KnotArray(knots)
    })
}

/// The weights of rational bases, one for each control point of a direction, end copies included.
pub(super) fn fixed_weights(
    document: &mut Document,
    problem: &Arc<Problem>,
) -> Option<PerDirection<NumberArray>> {
    let is_rational = problem.directions().any(Direction::is_rational);
    is_rational.then(|| {
        each(problem, |axis, _| {
            let weights = line(problem, axis, |it| it.weights().unwrap_or_default().into());
            document.numbers(weights.count(), weights)
        })
    })
}
