//! The JSON of a level: its errors, and its geometry in one of several forms.

use std::borrow::Cow;
use std::sync::Arc;

use schemars::{JsonSchema, json_schema};
use serde::Serialize;
use uuid::Uuid;

use super::arrays::{KnotArray, NumberArray, PointArray, WeightArray, point};
use super::decimal::Rounding;
use super::document::{BinaryEncoding, Document};
use super::error::{FitError, PointIndex};
use super::examples;
use super::job::Geometry as Kind;
use super::source::{Along, Net, NetWeights};
use super::writer::Digits;
use crate::api::json::per_direction::{Pair, PerDirection};
use crate::api::json::read::values::Count;
use crate::api::json::schema::plain::never_null;
use crate::api::json::schema::schema_of;
use crate::fit::direction::Direction;
use crate::fit::geometry::Geometry;
use crate::fit::invalid::Axis;
use crate::fit::iteration::Level;
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::fit::samples::{Samples, Uniform};
use crate::job::Job;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::state::{State, Status};
use crate::model::shape::BasisKind;
use crate::model::stream::form::{self, Encoding, Form, View};
use crate::model::weights::Rational;

/// An iteration: the data of an `iteration` event. Which geometry there is depends on `view` and `changed`.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::iteration())]
pub struct IterationEvent {
    /// The smallest milestone that this iteration is the first to reach; with `milestones`.
    // Streams write it in front of the rest, which all of them share.
    #[serde(skip_serializing_if = "Option::is_none")]
    milestone: Option<f64>,
    /// Its number, from 0.
    iteration: usize,
    /// The distances from the data.
    error: FitError,
    /// The factor of the error in the last step.
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    /// About how many iterations it takes in all, by what is known here; absent where nobody knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted: Option<usize>,
    /// How many control points the last step has moved.
    moved: usize,
    /// A weight that no CAD kernel takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<BadWeight>,
    /// What is shown of the geometry.
    #[serde(flatten)]
    shown: Shown,
}

/// What is shown of the geometry of a level.
#[derive(Default, Serialize, JsonSchema)]
struct Shown {
    /// How the arrays are written, if they are binary.
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

/// The number of points in each direction, and of coordinates. Weights have the same without the last number.
#[derive(Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(extend("minItems" = 2, "maxItems" = 3, "examples" = [[102, 3]]))]
struct ArrayShape(Vec<usize>);

/// A control point whose weight is not positive at this iteration.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"control_point": 4, "weight": -0.01, "detail": "a weight of a control point is not positive at this level"}]))]
struct BadWeight {
    /// The control point, by the index of its data point.
    control_point: PointIndex,
    /// Its weight.
    weight: f64,
    /// What is wrong with it.
    detail: &'static str,
}

impl BadWeight {
    /// What is wrong with a homogeneous level: no CAD kernel takes a weight that is not positive.
    fn of(level: &Level, problem: &Problem) -> Option<Self> {
        let (index, weight) = level.bad_weight?;
        Some(Self {
            control_point: PointIndex::new(index, problem),
            weight,
            detail: "a weight of a control point is not positive at this level",
        })
    }
}

/// The data of an `iteration` event.
pub fn level(problem: &Arc<Problem>, frame: &Frame, form: &Form) -> Content {
    let level = &frame.level;
    let mut document = Document::new(digits(form, level));
    let points = &frame.control_points;
    let shown = match form.view {
        View::Errors => Shown::default(),
        View::ControlPoints => {
            let net = ControlNet::new(&mut document, problem, points);
            Shown {
                control_points: Some(net.points),
                weights: net.weights,
                ..Shown::default()
            }
            .written(&document, net.shape)
        }
        View::Changed => Shown {
            changed: Some(Changes::new(
                problem,
                Geometry::new(problem, points),
                frame.moved.as_deref().unwrap_or_default(),
            )),
            ..Shown::default()
        },
        View::Samples(grid) => {
            let samples = Samples::new(Arc::clone(problem), Arc::clone(points), grid);
            Shown::samples(&mut document, samples)
        }
    };
    document.finish(&IterationEvent {
        milestone: None,
        iteration: level.iteration,
        error: FitError::new(&level.error, &**problem),
        rate: level.rate,
        predicted: level.predicted,
        moved: level.moved,
        bad_weight: BadWeight::of(level, problem),
        shown,
    })
}

fn digits(form: &Form, level: &Level) -> Digits {
    match (form.encoding, form.digits) {
        (Encoding::Base64, _) => Digits::Base64,
        (Encoding::Base64F32, _) => Digits::Base64F32,
        // Messages are not written here.
        (Encoding::Json | Encoding::Protobuf, form::Digits::Full) => Digits::Decimal(None),
        (Encoding::Json | Encoding::Protobuf, form::Digits::Auto) => {
            Digits::Decimal(Rounding::for_error(level.error.max))
        }
    }
}

impl Shown {
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

    /// Says how the arrays are written, if they are binary.
    fn written(self, document: &Document, shape: Vec<usize>) -> Self {
        let encoding = document.encoding();
        Self {
            encoding,
            shape: encoding.map(|_| ArrayShape(shape)),
            ..self
        }
    }
}

/// The complete control net of a level.
struct ControlNet {
    shape: Vec<usize>,
    points: PointArray,
    /// Of homogeneous fits.
    weights: Option<WeightArray>,
}

impl ControlNet {
    fn new(document: &mut Document, problem: &Arc<Problem>, points: &Arc<Points>) -> Self {
        let functions = problem.directions().map(|it| it.basis.functions());
        let shape: Vec<usize> = functions.chain([problem.dimension()]).collect();
        let net = || Net {
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

/// The places of the complete net at which control points have moved: `[place, point]`, with its
/// weight in homogeneous fits.
#[derive(Serialize)]
#[serde(transparent)]
struct Changes(Vec<Change>);

#[derive(Serialize)]
#[serde(untagged)]
enum Change {
    Point(PointIndex, Vec<f64>),
    Weighted(PointIndex, Vec<f64>, f64),
}

impl Changes {
    fn new(problem: &Problem, geometry: Geometry<'_>, moved: &[usize]) -> Self {
        let change = |index: usize, (row, column): (usize, usize)| {
            let place = match problem.v() {
                None => PointIndex::OfCurve(row),
                Some(_) => PointIndex::OfSurface([row, column]),
            };
            let point = geometry.place(index).collect();
            match geometry.weight(index) {
                None => Change::Point(place, point),
                Some(weight) => Change::Weighted(place, point, weight),
            }
        };
        let changes = moved.iter().flat_map(|&index| {
            let places = geometry.occurrences(index);
            places.map(move |place| change(index, place))
        });
        Self(changes.collect())
    }
}

schema_of!(Changes, "Changes", generator => json_schema!({
    "description": "Places of the complete control points, with the point that is there now and in homogeneous fits its weight.",
    "type": "array",
    "items": {
        "type": "array",
        "prefixItems": [
            generator.subschema_for::<PointIndex>(),
            point(),
            {"type": "number"},
        ],
        "minItems": 2,
        "maxItems": 3,
    },
    "examples": [[[5, [0.97, 0.21, 3.25]]]],
}));

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

/// How weights are used.
pub(super) fn rational(problem: &Problem) -> Option<&'static str> {
    if problem.is_homogeneous() {
        Some("homogeneous")
    } else if problem.directions().any(Direction::is_rational) {
        Some("fixed")
    } else {
        None
    }
}

/// The final curve or surface: geometry that can be read without anything else.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::result())]
pub struct FitResult<'a> {
    /// The id of the job.
    id: Uuid,
    /// The client's name for it.
    name: Option<&'a str>,
    /// Curve or surface.
    kind: Kind,
    /// The final state.
    #[schemars(with = "State")]
    state: &'static str,
    /// The number of the last iteration.
    iteration: usize,
    /// The distances from the data.
    error: FitError,
    /// The basis.
    #[schemars(with = "PerDirection<BasisKind>")]
    basis: PerDirection<&'static str>,
    /// The degree.
    #[schemars(with = "PerDirection<Count>")]
    degree: PerDirection<usize>,
    /// Whether it is periodic.
    closed: PerDirection<bool>,
    /// How weights are used, if there are any.
    #[schemars(with = "Option<Rational>")]
    rational: Option<&'static str>,
    /// A weight that no CAD kernel takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<BadWeight>,
    /// The knots, in base64 always with 64 bits.
    knots: PerDirection<KnotArray>,
    /// How the arrays are written, if they are binary.
    #[serde(skip_serializing_if = "Option::is_none")]
    encoding: Option<BinaryEncoding>,
    /// The shape of `control_points`, if they are binary.
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<ArrayShape>,
    /// The complete control points, end copies included.
    control_points: PointArray,
    /// The weights of the control points; fixed ones of a surface are those of each direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<ResultWeights>,
}

/// Weights of control points: of each of them, or fixed ones of each direction.
#[derive(Serialize)]
#[serde(untagged)]
enum ResultWeights {
    Net(WeightArray),
    Fixed(PerDirection<NumberArray>),
}

schema_of!(ResultWeights, "ResultWeights", generator => json_schema!({
    "description": "Weights of control points: of each of them, or fixed ones of each direction of a surface.",
    "anyOf": [
        generator.subschema_for::<WeightArray>(),
        generator.subschema_for::<Pair<NumberArray>>(),
    ],
    "examples": [[1, 1.5, 2, 1]],
}));

/// The result: geometry that can be read without anything else.
pub fn result(
    job: &Job,
    problem: &Arc<Problem>,
    status: &Status,
    level: &Level,
    control_points: &Arc<Points>,
    form: &Form,
) -> Content {
    let mut document = Document::new(digits(form, level));
    let knots = knots(&mut document, problem);
    let net = ControlNet::new(&mut document, problem, control_points);
    let fixed = fixed_weights(&mut document, problem).map(ResultWeights::Fixed);
    let encoding = document.encoding();
    let outline = job.outline();
    let result = FitResult {
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: Kind::of(outline),
        state: status.state.name(),
        iteration: level.iteration,
        error: FitError::new(&level.error, &**problem),
        basis: each(problem, |_, direction| direction.basis.name()),
        degree: each(problem, |_, direction| direction.basis.degree()),
        closed: each(problem, |_, direction| direction.is_closed()),
        rational: rational(problem),
        bad_weight: BadWeight::of(level, problem),
        knots,
        encoding,
        shape: encoding.map(|_| ArrayShape(net.shape)),
        control_points: net.points,
        weights: net.weights.map(ResultWeights::Net).or(fixed),
    };
    document.finish(&result)
}
