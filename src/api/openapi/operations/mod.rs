//! The descriptions of all operations, for the router to put beside their handlers.

pub mod geometry;
pub mod jobs;
pub mod server;

use super::operation::{json_of, message_of};
use crate::api::language::{NDJSON, PROTOBUF, SSE};
use crate::api::problem::Kind;
use serde_json::{Value, json};

/// A media type and what is in it.
type Content = (&'static str, Value);

/// A job, as JSON or as a message.
fn job() -> [Content; 2] {
    [json_of("Job"), message_of("Job")]
}

/// An event stream in its three framings. The schemas are those of single events, as in later
/// versions of OpenAPI, for this one has no word for streams.
fn events() -> [Content; 3] {
    let reference = |name: &str| json!({"schema": super::operation::reference("schemas", name)});
    [
        (SSE, reference("ServerSentEvent")),
        (NDJSON, reference("EventLine")),
        (
            PROTOBUF,
            json!({"schema": {
                "description": "Messages `piad.v1.WatchJobResponse`, each after its length as a varint.",
                "contentMediaType": PROTOBUF,
            }}),
        ),
    ]
}

/// What is wrong with the Accept header, with other headers and with the query.
const NEGOTIATION: [Kind; 2] = [Kind::InvalidRequest, Kind::NotAcceptable];

/// The same, and what a job in the path may be.
const OF_A_JOB: [Kind; 4] = [
    Kind::InvalidRequest,
    Kind::NotAcceptable,
    Kind::UnknownJob,
    Kind::NotFound,
];

/// What may be wrong with a request for a new job.
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

/// What can be done with a job, by the names of the operations.
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
