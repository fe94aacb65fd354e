//! What goes over the wire.
//!
//! | Room | What it knows |
//! |---|---|
//! | [`json`], [`proto`] | the model in JSON and in protobuf messages |
//! | [`stream`] | event streams: what they show, and when |
//! | [`http`], [`grpc`] | the two doors, which use the same code |
//! | [`openapi`] | the description of the HTTP resources, and its reference for people |
//!
//! - [`app`]: what the doors share; [`language`]: the languages of requests and answers;
//! - [`order`]: new jobs and edits; [`jobs`]: finding, listing, cancelling and deleting them;
//!   [`levels`]: inputs, iterations and results;
//! - [`problem`]: errors (RFC 9457); [`short`]: texts of clients in them, cut; [`text`]: whether bytes are UTF-8;
//!   [`whole`]: whole numbers in texts.

pub mod app;
pub mod grpc;
pub mod http;
pub mod jobs;
pub mod json;
pub mod language;
pub mod levels;
pub mod openapi;
pub mod order;
pub mod problem;
pub mod proto;
pub mod stream;
pub mod text;
pub mod whole;

pub use crate::model::short;
