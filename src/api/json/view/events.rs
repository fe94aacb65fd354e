//! The data of the first and the last event of a stream, and the schemas of events.

use std::sync::Arc;

use bytes::Bytes;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::json;
use uuid::Uuid;

use super::applied_method::AppliedMethod;
use super::arrays::{KnotArray, NumberArray};
use super::document::{BinaryEncoding, Document};
use super::ends::EndRules;
use super::error::ErrorView;
use super::job::{AppliedStop, EndReason, GeometryKind, Links, Prediction, failure, path};
use super::level::IterationEvent;
use super::net::{each, fixed_weights, knots, parameters};
use super::warning::WarningView;
use super::writer::Digits;
use super::{examples, to_bytes};
use crate::api::json::plain::never_null;
use crate::api::problem::ProblemBody;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::outliers::Outliers;
use crate::job::state::{Levels, Reason, State, Status};
use crate::model::basis::BasisKind;
use crate::model::per_direction::{Count, PerDirection};
use crate::model::schema::schema_of;
use crate::model::weights::Rational;
use piad_fit::basis::Corners;
use piad_fit::engine::Problem;

/// The data of the `job` event: all that does not change from iteration to iteration.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null, example = examples::job_event())]
struct JobEvent<'a> {
    /// Only where a client that has iterations gets them all again, from 0 on: those that it has are of a version
    /// of the program whose numbers differ in the last digits.
    // Streams write it in front of the shared rest, so it is never set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    resumed: Option<Resumed>,
    /// The id of the job.
    id: Uuid,
    /// The client's name for it.
    name: Option<&'a str>,
    /// Curve or surface.
    kind: GeometryKind,
    /// The number of data points.
    points: usize,
    /// The number of coordinates.
    #[schemars(range(min = 1, max = 3))]
    dimension: usize,
    /// The number of control points in each event, end copies included.
    #[schemars(with = "PerDirection<Count>")]
    control_points: PerDirection<usize>,
    /// The basis.
    #[schemars(with = "PerDirection<BasisKind>")]
    basis: PerDirection<&'static str>,
    /// The degree.
    #[schemars(with = "PerDirection<Count>")]
    degree: PerDirection<usize>,
    /// True if it is closed: a periodic B-spline, or with corners one that is clamped at the first corner.
    closed: PerDirection<bool>,
    /// Its ends.
    ends: PerDirection<EndRules>,
    /// The points at which a curve may turn, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    corners: Option<&'a [usize]>,
    /// The points that a robust fit leaves out, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Outliers")]
    outliers: Option<Outliers<'a>>,
    /// The use of weights, if there are any.
    rational: Option<Rational>,
    /// The method, with numbers that were computed for it.
    method: AppliedMethod,
    /// The forecast at iteration 0.
    predicted: Prediction,
    /// Its end conditions.
    stop: AppliedStop,
    /// The paths of the job. Ephemeral edits have none.
    links: Option<Links>,
    /// Warnings; some are found only when the job begins to run.
    warnings: Vec<WarningView>,
    /// Notices about the file that has its points, in sentences. Absent if there are none.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    notices: &'a [String],
    /// How weights, knots and parameters are written, if they are binary: always with 64 bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    encoding: Option<BinaryEncoding>,
    /// Fixed weights of the control points, end copies included. Not there with `describe=none`, as
    /// knots and parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "weights_or_null")]
    weights: Option<Option<PerDirection<NumberArray>>>,
    /// The knots.
    #[serde(skip_serializing_if = "Option::is_none")]
    knots: Option<PerDirection<KnotArray>>,
    /// The parameters of the data points.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<PerDirection<NumberArray>>,
}

/// How a stream was resumed, unless it simply continues.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Restarted)]
enum Resumed {
    /// At iteration 0.
    Restarted,
}

/// The schema of fixed weights, which are null where there are none.
fn weights_or_null(generator: &mut SchemaGenerator) -> Schema {
    let weights = generator.subschema_for::<PerDirection<NumberArray>>();
    // Not `anyOf`, of which optional fields lose null.
    json_schema!({"oneOf": [weights, {"type": "null"}]})
}

/// The data of the `job` event, with its arrays or without them.
pub(crate) fn description(
    job: &Job,
    problem: &Arc<Problem>,
    levels: Option<Levels>,
    digits: Digits,
    with_arrays: bool,
) -> Content {
    let mut document = Document::new(digits);
    let outline = job.outline();
    let request = problem.request();
    let corners = request.u.corners.as_ref().filter(|_| request.v.is_none());
    let event = JobEvent {
        resumed: None,
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: GeometryKind::of(outline),
        points: problem.grid().count(),
        dimension: problem.dimension(),
        control_points: each(problem, |_, direction| direction.basis.functions()),
        basis: each(problem, |_, direction| direction.basis.name()),
        degree: each(problem, |_, direction| direction.basis.degree()),
        closed: each(problem, |_, direction| direction.is_closed()),
        ends: EndRules::of(problem),
        corners: corners.map(Corners::indices),
        outliers: Outliers::of(problem),
        rational: Rational::of(problem.request()),
        method: AppliedMethod::new(outline, levels.map(|levels| levels.forecast)),
        predicted: Prediction::at_first(levels),
        stop: AppliedStop::new(outline),
        links: Links::of(job),
        warnings: WarningView::of(outline, levels.as_ref()),
        notices: &outline.label.notices,
        encoding: document.encoding(),
        weights: with_arrays.then(|| fixed_weights(&mut document, problem)),
        knots: with_arrays.then(|| knots(&mut document, problem)),
        parameters: with_arrays.then(|| parameters(&mut document, problem)),
    };
    document.finish(&event)
}

/// The data of the `end` event.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(example = examples::end())]
struct EndEvent {
    /// The final state.
    #[schemars(with = "State")]
    state: &'static str,
    /// The reason of the end, if the state does not imply it.
    #[schemars(with = "Option<EndReason>")]
    reason: Option<&'static str>,
    /// The reason in words, with the remaining distance.
    detail: Option<String>,
    /// The number of the last iteration.
    iterations: usize,
    /// The distances at that iteration.
    error: Option<ErrorView>,
    /// Seconds from the beginning of the computation to the end.
    elapsed: Option<f64>,
    /// All warnings, also those that were found while it ran.
    warnings: Vec<WarningView>,
    /// Links to related resources. Ephemeral edits leave nothing behind.
    links: Option<EndLinks>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<ProblemBody>,
}

/// Paths of a job that has ended.
#[derive(Serialize, JsonSchema)]
#[schemars(example = examples::end_links())]
struct EndLinks {
    /// The job.
    #[serde(rename = "self")]
    #[schemars(extend("format" = "uri-reference"))]
    itself: String,
    /// The final curve or surface.
    #[schemars(extend("format" = "uri-reference"))]
    result: String,
}

/// The data of the `end` event.
pub(crate) fn end(job: &Job, status: &Status) -> Bytes {
    let level = status.levels.map(|levels| levels.last);
    let times = status.started.zip(status.finished);
    to_bytes(&EndEvent {
        state: status.state.name(),
        reason: status.reason.map(Reason::name),
        detail: status.detail(job.outline()),
        iterations: level.map_or(0, |level| level.iteration),
        error: level.map(|level| ErrorView::of_last(&level, job.outline())),
        elapsed: times.map(|(start, end)| end.duration_since(start).as_secs_f64()),
        warnings: WarningView::of(job.outline(), status.levels.as_ref()),
        links: job.is_kept().then(|| EndLinks {
            itself: path(job),
            result: format!("{}/result", path(job)),
        }),
        problem: failure(status),
    })
}

/// The schema of a server-sent event.
pub(crate) enum ServerSentEvent {}

schema_of!(ServerSentEvent, "ServerSentEvent", generator => {
    let data = [
        generator.subschema_for::<JobEvent<'_>>(),
        generator.subschema_for::<IterationEvent>(),
        generator.subschema_for::<EndEvent>(),
    ];
    json_schema!({
        "description": "The fields of a server-sent event: `job` without an id, then `iteration` with the number of the iteration as its id, in order and without gaps unless these are requested, then `end` with the id `end`. Comments keep quiet streams open.",
        "type": "object",
        "properties": {
            "event": {"description": "What has happened.", "type": "string", "enum": ["job", "iteration", "end"]},
            "id": {"description": "The number of the iteration, or `end`. A version of the program whose numbers differ from those of the version that accepted the job adds its own number: `7@2`.", "type": "string", "pattern": "^([0-9]+(@[0-9]+)?|end)$"},
            "data": {
                "description": "Its data, as JSON: a JobEvent, an IterationEvent or an EndEvent.",
                "type": "string",
                "contentMediaType": "application/json",
                "contentSchema": {"anyOf": data},
            },
        },
        "required": ["event", "data"],
        "examples": [{"event": "iteration", "id": "1", "data": "{\"iteration\":1,\"error\":{…},\"moved\":4,\"control_points\":[…]}"}],
    })
});

/// An event as a line of JSON.
pub(crate) enum EventLine {}

schema_of!(EventLine, "EventLine", generator => {
    let lines = [
        ("job", generator.subschema_for::<JobLine>()),
        ("iteration", generator.subschema_for::<IterationLine>()),
        ("end", generator.subschema_for::<EndLine>()),
    ];
    let reference = |(name, line): &(&str, Schema)| Some(((*name).to_owned(), line.get("$ref")?.clone()));
    let mapping: serde_json::Map<_, _> = lines.iter().filter_map(reference).collect();
    json_schema!({
        "description": "An event as a line of JSON: the same as a server-sent event, and no comments.",
        "oneOf": lines.map(|(_, line)| line),
        "discriminator": {"propertyName": "event", "mapping": mapping},
        "examples": [{"event": "iteration", "id": 1, "data": examples::iteration()}],
    })
});

enum JobLine {}
enum IterationLine {}
enum EndLine {}

schema_of!(JobLine, "JobLine", generator => line_schema::<JobEvent<'_>>(generator, "job", None, json!({
    "event": "job", "data": examples::job_event(),
})));
schema_of!(IterationLine, "IterationLine", generator => line_schema::<IterationEvent>(generator, "iteration", Some(json_schema!({
    "description": "The number of the iteration. A text where server-sent events have more than a number.",
    "oneOf": [{"type": "integer", "minimum": 0}, {"type": "string", "pattern": "^[0-9]+@[0-9]+$"}],
})), json!({
    "event": "iteration", "id": 1, "data": examples::iteration(),
})));
schema_of!(EndLine, "EndLine", generator => line_schema::<EndEvent>(generator, "end", Some(json_schema!({
    "description": "The id of the event.", "type": "string", "const": "end",
})), json!({
    "event": "end", "id": "end", "data": examples::end(),
})));

/// The line of an event with these data.
fn line_schema<T: JsonSchema>(
    generator: &mut SchemaGenerator,
    name: &str,
    id: Option<Schema>,
    example: serde_json::Value,
) -> Schema {
    let mut data = generator.subschema_for::<T>();
    data.insert("description".to_owned(), json!("Its data."));
    let mut schema = json_schema!({
        "description": format!("The `{name}` event as a line."),
        "type": "object",
        "properties": {
            "event": {"description": "What has happened.", "type": "string", "const": name},
            "data": data,
        },
        "required": ["event", "data"],
        "examples": [example],
    });
    if let Some(id) = id {
        schema.insert("required".to_owned(), json!(["event", "id", "data"]));
        if let Some(fields) = schema.get_mut("properties") {
            fields["id"] = id.to_value();
        }
    }
    schema
}
