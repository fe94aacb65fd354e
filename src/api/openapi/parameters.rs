//! Parameters in paths, queries and headers, and the headers of answers.

use serde_json::{Map, Value, json};

use super::operation::schema_of;
use super::page;
use crate::api::http::negotiate::LONGEST_WAIT;
use crate::api::jobs::{DEFAULT_PAGE, LARGEST_PAGE};
use crate::api::json::view::examples;
use crate::api::order::LONGEST_KEY;
use crate::api::rates::{USUAL_DEGREE, USUAL_POINTS, USUAL_TOLERANCE};
use crate::api::whole::LARGEST;
use crate::export::{Dots, Format, Unit};
use crate::fit::rates::{MOST_DEGREE, MOST_POINTS};
use crate::job::state::State;
use crate::model::named::Named;
use crate::model::stream::{Describe, Digits, Encoding, MOST_MILESTONES, OnDisconnect, Pace, View};

/// The parameters, by the names of their components.
pub(super) fn parameters() -> Map<String, Value> {
    let groups = [
        paths(),
        lists(),
        comparisons(),
        views(),
        streams(),
        request_headers(),
    ];
    let all = groups.into_iter().flatten();
    let named = all.map(|parameter| {
        let name = parameter["name"].as_str().unwrap_or_default().to_owned();
        (name, parameter)
    });
    let of_readers = query(
        "on_disconnect",
        "What becomes of the job when the client goes away: it goes on. Only the stream that is the answer to the request for the job can end it.",
        json!({"type": "string", "const": "continue"}),
        json!("continue"),
    );
    named
        .chain([(READER_ON_DISCONNECT.to_owned(), of_readers)])
        .collect()
}

/// The component of `on_disconnect` in streams of jobs that other requests have made.
pub(super) const READER_ON_DISCONNECT: &str = "reader_on_disconnect";

fn query(name: &str, description: &str, schema: Value, example: Value) -> Value {
    parameter("query", name, description, schema, example)
}

fn parameter(place: &str, name: &str, description: &str, schema: Value, example: Value) -> Value {
    json!({
        "name": name,
        "in": place,
        "description": description,
        "required": place == "path",
        "schema": schema,
        "example": example,
    })
}

/// The number of an iteration, or `last`.
fn iteration() -> Value {
    json!({"oneOf": [
        {"type": "integer", "minimum": 0, "maximum": LARGEST},
        {"type": "string", "const": "last"},
    ]})
}

fn paths() -> Vec<Value> {
    let path =
        |name, description, schema, example| parameter("path", name, description, schema, example);
    vec![
        path(
            "id",
            "The id of the job.",
            json!({"type": "string", "format": "uuid"}),
            json!(examples::ID),
        ),
        path(
            "k",
            "The number of an iteration, from 0, or `last`: the last one so far.",
            iteration(),
            json!("last"),
        ),
        path(
            "format",
            "The file format.",
            json!({"type": "string", "enum": Format::ALL.map(Format::name)}),
            json!("svg"),
        ),
        path(
            "slug",
            "The last part of the `type` of a problem.",
            json!({"type": "string", "pattern": "^[a-z-]+$"}),
            json!("invalid-fit"),
        ),
        path(
            "file",
            "The name of the file.",
            json!({"type": "string", "enum": reference_files()}),
            json!("start.js"),
        ),
        path(
            "part",
            "The name of the file.",
            json!({"type": "string", "pattern": "^[a-z0-9._-]+$"}),
            json!("app.js"),
        ),
    ]
}

/// The parts of the reference, without what stands at `/docs`.
fn reference_files() -> Vec<&'static str> {
    let names = page::REFERENCE.files.iter().map(|file| file.name);
    names.filter(|name| *name != page::REFERENCE.root).collect()
}

fn lists() -> Vec<Value> {
    vec![
        query(
            "surface.size",
            "How many rows and columns of a surface the points of the file are.",
            json!({"type": "string", "pattern": "^[1-9][0-9]{0,6}x[1-9][0-9]{0,6}$"}),
            json!("40x60"),
        ),
        query(
            "state",
            "Only jobs in this state.",
            schema_of::<State>(),
            json!("converged"),
        ),
        query(
            "limit",
            "How many jobs a page has at most.",
            json!({"type": "integer", "minimum": 1, "maximum": LARGEST_PAGE, "default": DEFAULT_PAGE}),
            json!(10),
        ),
        query(
            "cursor",
            "Only jobs before this one, as `next` of the page before says.",
            json!({"type": "string", "format": "uuid"}),
            json!(examples::ID),
        ),
    ]
}

/// Of comparisons of bases.
fn comparisons() -> Vec<Value> {
    vec![
        query(
            "points",
            "How many points there are; it follows from explicit parameters.",
            json!({"type": "integer", "minimum": 2, "maximum": MOST_POINTS, "default": USUAL_POINTS}),
            json!(11),
        ),
        query(
            "parameters",
            "Their parameters: `uniform`, or increasing numbers separated by commas.",
            json!({"type": "string", "default": "uniform"}),
            json!("uniform"),
        ),
        query(
            "degree",
            "The degree of the B-splines.",
            json!({"type": "integer", "minimum": 1, "maximum": MOST_DEGREE, "default": USUAL_DEGREE}),
            json!(3),
        ),
        query(
            "tolerance",
            "To which part an error is to be reduced.",
            json!({"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1, "default": USUAL_TOLERANCE}),
            json!(1e-6),
        ),
    ]
}

/// Of single iterations, results and streams.
fn views() -> Vec<Value> {
    vec![
        query(
            "iteration",
            "Which iteration is measured: its number, or `last`: the last one so far.",
            iteration(),
            json!("last"),
        ),
        query(
            "list",
            "Whether the distance of each data point is told.",
            json!({"type": "boolean", "default": false}),
            json!(true),
        ),
        query(
            "view",
            "What is shown: control points, samples, or the errors alone.",
            schema_of::<View>(),
            json!("samples"),
        ),
        query(
            "samples",
            "How many samples: `200` for a curve, `40x40` for a surface; with view=samples, and for gltf, stl, dxf, svg and csv files; of a dxf surface at most 256 in each direction.",
            json!({"type": "string", "pattern": "^[1-9][0-9]{0,6}(x[1-9][0-9]{0,5})?$"}),
            json!("200"),
        ),
        query(
            "encoding",
            "How arrays of numbers are written in JSON.",
            schema_of::<Encoding>(),
            json!("base64"),
        ),
        query(
            "digits",
            "How many digits coordinates have in JSON.",
            schema_of::<Digits>(),
            json!("auto"),
        ),
        query(
            "dots",
            "Whether svg files show data points as dots: by default where these do not hide each other.",
            json!({"type": "string", "enum": Dots::names(), "default": Dots::default().name()}),
            json!("off"),
        ),
        query(
            "units",
            "The unit of length that step and iges files declare. Coordinates are those of the data in any unit.",
            json!({"type": "string", "enum": Unit::names(), "default": Unit::default().name()}),
            json!("m"),
        ),
    ]
}

fn streams() -> Vec<Value> {
    let mut milestones = query(
        "milestones",
        "Only the first iteration whose largest error is within each of these distances, which decrease, and the last.",
        json!({"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}, "maxItems": MOST_MILESTONES}),
        json!([0.1, 0.01]),
    );
    milestones["style"] = json!("form");
    milestones["explode"] = json!(false);
    vec![
        query(
            "every",
            "Only iterations that are multiples of this number, and the last.",
            json!({"type": "integer", "minimum": 1, "maximum": LARGEST, "default": 1}),
            json!(5),
        ),
        milestones,
        query(
            "pace",
            "What a client gets that is slower than the fit: all iterations, or the latest.",
            schema_of::<Pace>(),
            json!("latest"),
        ),
        query(
            "changed",
            "After a first complete event only control points that moved.",
            json!({"type": "boolean", "default": false}),
            json!(true),
        ),
        query(
            "describe",
            "What the `job` event says of the job: `none` leaves out knots, parameters and fixed weights, for clients that have them.",
            schema_of::<Describe>(),
            json!("none"),
        ),
        query(
            "on_disconnect",
            "What becomes of the job when the client of this stream goes away.",
            schema_of::<OnDisconnect>(),
            json!("cancel"),
        ),
    ]
}

fn request_headers() -> Vec<Value> {
    let header = |name, description, schema, example| {
        parameter("header", name, description, schema, example)
    };
    vec![
        header(
            "Last-Event-ID",
            "The id of the last event that the client has: the stream goes on after it. After `end` there is nothing: 204.",
            // The number of an iteration, `end`, or nothing, which is as if there were no header.
            json!({"type": "string", "pattern": "^(0|[1-9][0-9]{0,8}|end|)$"}),
            json!("7"),
        ),
        header(
            "Prefer",
            &format!(
                "`wait=10` (RFC 7240): the answer comes when the job has ended (of an iteration: when the job has come there), or after so many seconds, up to {LONGEST_WAIT}, as it then stands."
            ),
            json!({"type": "string"}),
            json!("wait=10"),
        ),
        header(
            "Idempotency-Key",
            "A key of the client's choice for this request; every client address has keys of its own. For a day the same key and body give the same job, so that a request can be sent again after a broken connection.",
            json!({
                "type": "string",
                "minLength": 1,
                "maxLength": LONGEST_KEY,
                "pattern": "^[!-~]([ -~]*[!-~])?$",
            }),
            json!("wing-17"),
        ),
    ]
}

/// The headers of answers.
pub(super) fn headers() -> Map<String, Value> {
    let text = || json!({"type": "string"});
    let whole = || json!({"type": "integer", "minimum": 0});
    let headers = [
        (
            "X-Request-Id",
            "The id of the request: the client's own, or one that the server gave it.",
            text(),
            json!(examples::ID),
        ),
        (
            "Location",
            "The path of the new job.",
            json!({"type": "string", "format": "uri-reference"}),
            json!(format!("/v1/jobs/{}", examples::ID)),
        ),
        (
            "Idempotency-Replayed",
            "The job was made before, for the same key.",
            json!({"type": "string", "const": "true"}),
            json!("true"),
        ),
        (
            "Preference-Applied",
            "How long the answer may have waited for the end of the job.",
            text(),
            json!("wait=10"),
        ),
        (
            "Piad-Resumed-After",
            "The iteration after which the stream goes on.",
            whole(),
            json!(7),
        ),
        (
            "Content-Disposition",
            "A name for the file: that of the job, and of an iteration its number (RFC 6266).",
            text(),
            json!("inline; filename=\"naca2412.step\"; filename*=UTF-8''naca2412.step"),
        ),
        (
            "Retry-After",
            "After how many seconds to send the request again.",
            whole(),
            json!(5),
        ),
    ];
    let header = |(name, description, schema, example): (&str, &str, Value, Value)| {
        let header = json!({"description": description, "required": false, "schema": schema, "example": example});
        (name.to_owned(), header)
    };
    headers.into_iter().map(header).collect()
}
