//! The API: HTTP and gRPC, JSON and protobuf, event streams.
//!
//! | Room | What it knows |
//! |---|---|
//! | `json`, `proto` | the model in JSON and in protobuf messages |
//! | `stream` | event streams: what they show, and when |
//! | `http`, `grpc` | the two doors, which use the same code |
//! | `openapi` | the description of the HTTP resources, and its reference for people |
//!
//! - `app`: what the doors share; `language`: the languages of requests and answers;
//! - `order`: new jobs and edits; `start`: the level of another job that they start from; `jobs`: finding, listing, cancelling and deleting them;
//!   `levels`: inputs, iterations and results; `rates`: comparisons of bases;
//! - `resuming`: the iteration from which a stream continues;
//! - `problem`: errors (RFC 9457); `whole`: whole numbers in texts;
//! - `fuzzing`: what fuzz targets call, in `fuzz/decoders`.

pub(crate) mod app;
pub(crate) mod batch;
#[cfg(any(test, fuzzing))]
#[path = "../../fuzz/decoders/mod.rs"]
pub mod fuzzing;
mod grpc;
pub(crate) mod http;
mod jobs;
pub(crate) mod json;
mod language;
mod levels;
mod needs;
mod openapi;
mod order;
mod problem;
mod proto;
mod rates;
mod resuming;
mod start;
pub(crate) mod stream;
mod whole;
