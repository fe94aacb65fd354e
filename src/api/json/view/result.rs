//! The JSON of a result.

use schemars::{JsonSchema, json_schema};
use serde::Serialize;
use uuid::Uuid;

use super::arrays::{KnotArray, NumberArray, PointArray, WeightArray};
use super::document::{BinaryEncoding, Document};
use super::error::ErrorView;
use super::examples;
use super::job::GeometryKind;
use super::level::digits;
use super::net::{ArrayShape, BadWeight, ControlNet, each, fixed_weights, knots, parameters};
use crate::api::json::plain::never_null;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::outliers::Outliers;
use crate::job::outline::Outline;
use crate::job::state::{State, Status};
use crate::job::trim::Trimmed;
use crate::model::basis::BasisKind;
use crate::model::per_direction::{Count, Pair, PerDirection};
use crate::model::schema::schema_of;
use crate::model::stream::form::Form;
use crate::model::weights::Rational;

/// The final curve or surface: geometry that can be read without anything else.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::result())]
pub(crate) struct FitResult<'a> {
    /// The id of the job.
    id: Uuid,
    /// The client's name for it.
    name: Option<&'a str>,
    /// Curve or surface.
    kind: GeometryKind,
    /// The final state.
    #[schemars(with = "State")]
    state: &'static str,
    /// Notices about the file that has its points, in sentences. Absent if there are none.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    notices: &'a [String],
    /// The number of the last iteration.
    iteration: usize,
    /// The distances from the data.
    error: ErrorView,
    /// The self-contained geometry.
    #[serde(flatten)]
    geometry: FitGeometry<'a>,
}

/// A curve or surface that was fitted, complete with degree and knots.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::geometry())]
pub(crate) struct FitGeometry<'a> {
    /// The basis.
    #[schemars(with = "PerDirection<BasisKind>")]
    basis: PerDirection<&'static str>,
    /// The degree.
    #[schemars(with = "PerDirection<Count>")]
    degree: PerDirection<usize>,
    /// True if it is closed: a periodic B-spline, or with corners one that is clamped at the first corner.
    closed: PerDirection<bool>,
    /// The use of weights, if there are any.
    rational: Option<Rational>,
    /// A weight that no CAD kernel takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<BadWeight>,
    /// The knots, in base64 always with 64 bits.
    knots: PerDirection<KnotArray>,
    /// The parameters of the data points, in base64 always with 64 bits.
    parameters: PerDirection<NumberArray>,
    /// The fairness of a least-squares fit, also if the data have chosen it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    fairness: Option<f64>,
    /// The points that a robust fit leaves out, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Outliers")]
    outliers: Option<Outliers<'a>>,
    /// The remaining part of a trimmed surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Trimmed")]
    trim: Option<Trimmed>,
    /// The encoding of the arrays, if they are binary.
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
pub(crate) fn result(outline: &Outline, status: &Status, frame: &Frame, form: &Form) -> Content {
    let level = &frame.level;
    let mut document = Document::new(digits(form, level));
    let result = FitResult {
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: GeometryKind::of(outline),
        state: status.state.name(),
        notices: &outline.label.notices,
        iteration: level.iteration,
        error: ErrorView::new(&level.error, &*frame.problem),
        geometry: FitGeometry::new(&mut document, frame),
    };
    document.finish(&result)
}

impl<'a> FitGeometry<'a> {
    /// The geometry of a level.
    pub(super) fn new(document: &mut Document, frame: &'a Frame) -> Self {
        let problem = &frame.problem;
        let knots = knots(document, problem);
        let parameters = parameters(document, problem);
        let net = ControlNet::new(document, problem, &frame.control_points);
        let fixed = fixed_weights(document, problem).map(ResultWeights::Fixed);
        let encoding = document.encoding();
        Self {
            basis: each(problem, |_, direction| direction.basis.name()),
            degree: each(problem, |_, direction| direction.basis.degree()),
            closed: each(problem, |_, direction| direction.is_closed()),
            rational: Rational::of(problem.request()),
            bad_weight: BadWeight::of(&frame.level, problem),
            knots,
            parameters,
            fairness: problem.method().fairness(),
            outliers: Outliers::of(problem),
            trim: Trimmed::of(frame),
            encoding,
            shape: encoding.map(|_| ArrayShape(net.shape)),
            control_points: net.points,
            weights: net.weights.map(ResultWeights::Net).or(fixed),
        }
    }
}
