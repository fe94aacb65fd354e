//! The descriptions of all operations, for the router to put beside their handlers.

pub mod geometry;
pub mod jobs;
pub mod server;

use super::operation::{json_of, schema_of};
use crate::api::json::view::events::{EventLine, ServerSentEvent};
use crate::api::json::view::job::JobView;
use crate::api::language::{NDJSON, SSE};
use crate::api::problem::Kind;
use serde_json::{Value, json};

/// A media type and what is in it.
type Content = (&'static str, Value);

fn job() -> [Content; 1] {
    [json_of::<JobView<'_>>()]
}

/// An event stream in its two text framings. OpenAPI 3.1 cannot describe streams, so for generated clients
/// both are strings; the schema of single events is given as `x-itemSchema`, as in OpenAPI 3.2.
fn events() -> [Content; 2] {
    let stream = |description: &str, event: Value| {
        json!({
            "schema": {"type": "string", "description": description},
            "x-itemSchema": event,
        })
    };
    let (event, line) = (schema_of::<ServerSentEvent>(), schema_of::<EventLine>());
    [
        (SSE, stream("Server-sent events.", event)),
        (NDJSON, stream("An event a line, as JSON.", line)),
    ]
}

/// Problems of the Accept header, of other headers and of the query.
const NEGOTIATION: [Kind; 2] = [Kind::InvalidRequest, Kind::NotAcceptable];

/// The same, and problems of the job in the path.
const OF_A_JOB: [Kind; 4] = [
    Kind::InvalidRequest,
    Kind::NotAcceptable,
    Kind::UnknownJob,
    Kind::NotFound,
];

/// Problems of requests for new jobs.
const NEW_JOB: [Kind; 14] = [
    Kind::NotJson,
    Kind::NotProtobuf,
    Kind::InvalidRequest,
    Kind::NotAcceptable,
    Kind::BodyTimeout,
    Kind::BodyTooLarge,
    Kind::UnsupportedMediaType,
    Kind::UnsupportedEncoding,
    Kind::InvalidFit,
    Kind::KeyTaken,
    Kind::QueueFull,
    Kind::TooManyJobs,
    Kind::StoreFull,
    Kind::Stopping,
];

/// The operations on a job, by their ids.
pub const WITH_A_JOB: [&str; 9] = [
    "getJob",
    "watchJob",
    "getInput",
    "getIteration",
    "getResult",
    "getLimit",
    "editJob",
    "cancelJob",
    "deleteJob",
];
