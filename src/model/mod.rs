//! What clients ask for, typed and without a wire: JSON and protobuf messages are read into this model
//! and written from it.
//!
//! - [`named`]: enumerations whose values have names;
//! - [`stream`]: what the event streams of a job are like.

pub mod named;
pub mod stream;
