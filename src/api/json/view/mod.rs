//! JSON of answers.
//!
//! Serialised types carry their schemas: their doc comments are the descriptions of the OpenAPI document. Fields may be
//! added to answers, so clients ignore unknown ones.
//!
//! - [`job`]: jobs as resources; [`events`]: the first and the last event of streams; [`level`]: iterations and
//!   results;
//!   [`limit`]: the limit of local fits;
//! - [`batch`]: the lines of a batch;
//! - [`error`]: distances from the data at their parameters; [`deviation`]: from the nearest points; [`curvature`]: the
//!   shape; [`warning`]: warnings about a job;
//! - [`input`](mod@input): a job as it was requested;
//! - [`arrays`]: arrays of numbers in answers; [`document`] writes them, over [`source`] and [`writer`];
//! - [`decimal`] and [`rounding`]: decimal numbers, exact or rounded; [`lists`] of them;
//! - [`examples`]: examples for the OpenAPI document.

mod applied_method;
mod arrays;
pub(crate) mod batch;
pub(crate) mod curvature;
mod decimal;
pub(crate) mod deviation;
mod document;
mod ends;
pub(crate) mod error;
pub(crate) mod events;
pub(crate) mod examples;
pub(crate) mod input;
pub(crate) mod job;
pub(crate) mod level;
pub(crate) mod limit;
mod lists;
mod net;
pub(crate) mod points;
pub(crate) mod rates;
pub(crate) mod result;
mod rounding;
pub(crate) mod shape;
pub(crate) mod source;
pub(crate) mod warning;
pub(crate) mod writer;

use bytes::Bytes;
use serde::Serialize;

/// A value as bytes of JSON. The values of this module always have a JSON form.
pub(crate) fn to_bytes(value: &impl Serialize) -> Bytes {
    match serde_json::to_vec(value) {
        Ok(bytes) => bytes.into(),
        Err(error) => {
            tracing::error!(%error, "a value has no JSON form");
            Bytes::from_static(b"null")
        }
    }
}
