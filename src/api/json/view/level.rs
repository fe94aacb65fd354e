//! The JSON of an iteration: its errors, and its geometry in one of several forms.

use std::sync::Arc;

use schemars::{JsonSchema, json_schema};
use serde::Serialize;

use super::arrays::{KnotArray, NumberArray, PointArray, WeightArray, point};
use super::document::{BinaryEncoding, Document};
use super::error::ErrorView;
use super::examples;
use super::net::{ArrayShape, BadWeight, ControlNet, knots, net_shape};
use super::rounding::Rounding;
use super::writer::Digits;
use crate::api::json::plain::never_null;
use crate::job::content::Content;
use crate::job::deltas::Change;
use crate::job::frame::Frame;
use crate::model::per_direction::PerDirection;
use crate::model::schema::schema_of;
use crate::model::settings::Index;
use crate::model::stream::form::{self, Encoding, Form, View};
use piad_fit::engine::samples::{Samples, Uniform};
use piad_fit::engine::{Geometry, Level, Problem};

/// An iteration: the data of an `iteration` event. Which geometry there is depends on `view` and `changed`.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::iteration())]
pub(crate) struct IterationEvent {
    /// The smallest milestone that this iteration is the first to reach; with `milestones`.
    // Streams write it in front of the shared rest, so it is never set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    milestone: Option<f64>,
    /// Its number, from 0.
    iteration: usize,
    /// The distances from the data.
    error: ErrorView,
    /// The factor of the error in the last step.
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    /// The approximate total number of iterations, by the errors so far; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted: Option<usize>,
    /// The number of control points that the last step moved.
    moved: usize,
    /// The knots, where they are others than in the event before; of fits that choose them.
    #[serde(skip_serializing_if = "Option::is_none")]
    knots: Option<PerDirection<KnotArray>>,
    /// A weight that no CAD kernel takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<BadWeight>,
    /// Only with the encoding `delta`: by how much a step moves a coordinate, a power of two.
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<f64>,
    /// Only with the encoding `delta` in homogeneous fits: by how much a step moves a weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    weight_step: Option<f64>,
    /// The view of the geometry.
    #[serde(flatten)]
    shown: Shown,
}

/// The view of the geometry of a level.
#[derive(Default, Serialize, JsonSchema)]
pub(super) struct Shown {
    /// The encoding of the arrays, if they are binary.
    #[serde(skip_serializing_if = "Option::is_none")]
    encoding: Option<BinaryEncoding>,
    /// The shape of `control_points` or `samples`, if they are binary.
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<ArrayShape>,
    /// The complete control points, end copies included; with view=control_points.
    #[serde(skip_serializing_if = "Option::is_none")]
    control_points: Option<PointArray>,
    /// Homogeneous fits: the weights of the control points.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<WeightArray>,
    /// The control points that moved; with changed=true.
    #[serde(skip_serializing_if = "Option::is_none")]
    changed: Option<Changes>,
    /// The parameters of the samples; of a surface those of the rows and of the columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<PerDirection<NumberArray>>,
    /// Points of the curve or surface; with view=samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<PointArray>,
}

/// The data of an `iteration` event.
pub(crate) fn level(frame: &Frame, form: &Form) -> Content {
    let problem = &frame.problem;
    let mut document = Document::new(digits(form, &frame.level));
    let shown = Shown::new(&mut document, frame, form.view);
    let tells = form.knots && problem.is_automatic();
    let knots = tells.then(|| knots(&mut document, problem));
    document.finish(&IterationEvent {
        knots,
        ..IterationEvent::new(frame, shown)
    })
}

/// The data of an `iteration` event with the numbers of steps by which points, and weights, have moved since the
/// reader's state.
pub(crate) fn moved(frame: &Frame, view: View, changes: &[Change]) -> Content {
    let mut document = Document::new(Digits::Base64);
    let shown = Shown::moved(&mut document, frame, view, changes);
    let mut steps = changes.iter().map(|change| change.step);
    document.finish(&IterationEvent {
        step: steps.next(),
        weight_step: steps.next(),
        ..IterationEvent::new(frame, shown)
    })
}

impl IterationEvent {
    /// The common fields of every level, and this geometry.
    fn new(frame: &Frame, shown: Shown) -> Self {
        let (level, problem) = (&frame.level, &frame.problem);
        Self {
            milestone: None,
            iteration: level.iteration,
            error: ErrorView::new(&level.error, &**problem),
            rate: level.rate,
            predicted: level.predicted,
            moved: level.moved,
            knots: None,
            bad_weight: BadWeight::of(level, problem),
            step: None,
            weight_step: None,
            shown,
        }
    }
}

/// The precision of coordinates in this form.
pub(super) fn digits(form: &Form, level: &Level) -> Digits {
    match (form.encoding, form.digits) {
        (Encoding::Base64, _) => Digits::Base64,
        (Encoding::Base64F32, _) => Digits::Base64F32,
        // Protobuf is encoded elsewhere.
        (Encoding::Json | Encoding::Protobuf, form::Digits::Full) => Digits::Decimal(None),
        (Encoding::Json | Encoding::Protobuf, form::Digits::Auto) => {
            Digits::Decimal(Rounding::for_error(level.error.max))
        }
    }
}

impl Shown {
    /// The geometry of a level in a view.
    pub(super) fn new(document: &mut Document, frame: &Frame, view: View) -> Self {
        let (problem, points) = (&frame.problem, &frame.control_points);
        match view {
            View::Errors => Self::default(),
            View::ControlPoints => {
                let net = ControlNet::new(document, problem, points);
                let shown = Self {
                    control_points: Some(net.points),
                    weights: net.weights,
                    ..Self::default()
                };
                shown.written(document, net.shape)
            }
            View::Changed => Self {
                changed: Some(Changes::new(
                    problem,
                    Geometry::new(problem, points),
                    frame.moved.as_deref().unwrap_or_default(),
                )),
                ..Self::default()
            },
            View::Samples(grid) => {
                let samples = Samples::new(Arc::clone(problem.setup()), Arc::clone(points), grid);
                Self::samples(document, samples)
            }
        }
    }

    /// The numbers of steps by which the points of a view, and their weights, have moved.
    fn moved(document: &mut Document, frame: &Frame, view: View, changes: &[Change]) -> Self {
        let mut arrays = changes.iter().map(|change| change.numbers.clone());
        let points = arrays.next().map(|it| document.packed_points(it));
        let problem = &frame.problem;
        let (control_points, samples, shape) = match (view, problem.v()) {
            (View::Samples(grid), None) => (None, points, vec![grid.rows, problem.dimension()]),
            (View::Samples(grid), Some(_)) => {
                let shape = vec![grid.rows, grid.columns, problem.dimension()];
                (None, points, shape)
            }
            _ => (points, None, net_shape(problem)),
        };
        Self {
            encoding: Some(BinaryEncoding::Delta),
            shape: Some(ArrayShape(shape)),
            control_points,
            weights: arrays.next().map(|it| document.packed_weights(it)),
            samples,
            ..Self::default()
        }
    }

    /// Points of the curve or surface at equal steps of the parameters.
    fn samples(document: &mut Document, samples: Samples) -> Self {
        let (u, v) = (samples.u, samples.v);
        let counts = [
            Some(u.count()),
            v.map(Uniform::count),
            Some(samples.dimension()),
        ];
        let shape: Vec<usize> = counts.into_iter().flatten().collect();
        let mut numbers = |steps: Uniform| document.numbers(steps.count(), steps);
        let parameters = match v {
            None => PerDirection::Both(numbers(u)),
            Some(v) => PerDirection::Each {
                u: numbers(u),
                v: numbers(v),
            },
        };
        Self {
            parameters: Some(parameters),
            samples: Some(document.points(&shape, samples)),
            ..Self::default()
        }
        .written(document, shape)
    }

    /// Reports how the arrays are written, if they are binary.
    fn written(self, document: &Document, shape: Vec<usize>) -> Self {
        let encoding = document.encoding();
        Self {
            encoding,
            shape: encoding.map(|_| ArrayShape(shape)),
            ..self
        }
    }
}

/// The places of the complete net at which control points have moved: `[place, point]`, with its
/// weight in homogeneous fits.
#[derive(Serialize)]
#[serde(transparent)]
struct Changes(Vec<MovedPoint>);

#[derive(Serialize)]
#[serde(untagged)]
enum MovedPoint {
    Point(Index, Vec<f64>),
    Weighted(Index, Vec<f64>, f64),
}

impl Changes {
    fn new(problem: &Problem, geometry: Geometry<'_>, moved: &[usize]) -> Self {
        let change = |(row, column): (usize, usize)| {
            let place = match problem.v() {
                None => Index::new(row, None),
                Some(_) => Index::pair(row, column),
            };
            let point = geometry.place(row, column).collect();
            match geometry.weight(row, column) {
                None => MovedPoint::Point(place, point),
                Some(weight) => MovedPoint::Weighted(place, point, weight),
            }
        };
        Self(geometry.changed(moved).map(change).collect())
    }
}

schema_of!(Changes, "Changes", generator => json_schema!({
    "description": "Places of the complete control points, with the point that is there now and in homogeneous fits its weight.",
    "type": "array",
    "items": {
        "anyOf": [
            {
                "title": "Moved",
                "type": "array",
                "prefixItems": [generator.subschema_for::<Index>(), point()],
                "minItems": 2,
                "maxItems": 2,
            },
            {
                "title": "Weighted",
                "type": "array",
                "prefixItems": [generator.subschema_for::<Index>(), point(), {"type": "number"}],
                "minItems": 3,
                "maxItems": 3,
            },
        ],
    },
    "examples": [[[5, [0.97, 0.21, 3.25]]]],
}));
