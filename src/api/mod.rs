//! The API: HTTP and gRPC, JSON and protobuf, event streams.
//!
//! | Module | Contents |
//! |---|---|
//! | `json`, `proto` | the model in JSON and in protobuf messages |
//! | `stream` | event streams: what they show, and when |
//! | `http`, `grpc` | the two transports, which use the same code |
//! | `openapi` | the OpenAPI document, and its reference page |
//!
//! - `app`: shared state of the transports; `media_type`: the encodings of requests and answers;
//! - `create_job`: new jobs and edits; `start`: the level of another job that they start from;
//! - `jobs`: finding, listing, cancelling and deleting jobs; `content`: inputs, iterations and results;
//! - `rates`: comparisons of bases;
//! - `resume`: the iteration from which a stream continues;
//! - `problem`: errors (RFC 9457); `parse_uint`: parsing of whole numbers;
//! - `fuzzing`: entry points of fuzz targets, in `fuzz/decoders`.

pub(crate) mod app;
pub(crate) mod batch;
mod content;
mod create_job;
#[cfg(any(test, fuzzing))]
#[path = "../../fuzz/decoders/mod.rs"]
pub mod fuzzing;
mod grpc;
pub(crate) mod http;
mod jobs;
pub(crate) mod json;
mod media_type;
mod needs;
mod openapi;
mod parse_uint;
mod problem;
mod proto;
mod rates;
mod resume;
mod start;
pub(crate) mod stream;
