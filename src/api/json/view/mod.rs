//! What the server answers, in JSON.
//!
//! Types that are serialised carry their schemas: what stands in the description of the API are their
//! doc comments. Fields may be added to answers, so clients ignore those that they do not know.
//!
//! - [`job`]: jobs as resources; [`events`]: what streams say first and last; [`level`]: iterations and results;
//!   [`limit`]: the limit of local fits;
//! - [`error`]: distances from the data at their parameters; [`deviation`]: from the nearest points; [`warning`]: what is doubtful about a job;
//! - [`input`](mod@input): a job as it was asked for;
//! - [`arrays`]: arrays of numbers in answers; [`document`] writes them, over [`source`] and [`writer`];
//! - [`decimal`]: numbers with as many digits as they deserve;
//! - [`examples`]: what descriptions show.

mod applied_method;
mod arrays;
mod decimal;
pub mod deviation;
mod document;
mod ends;
pub mod error;
pub mod events;
pub mod examples;
pub mod input;
pub mod job;
pub mod level;
pub mod limit;
mod net;
pub mod points;
pub mod rates;
pub mod result;
mod shape;
pub mod source;
pub mod warning;
pub mod writer;

use bytes::Bytes;
use serde::Serialize;

/// A value as bytes of JSON. The values of this module always have a JSON form.
pub fn to_bytes(value: &impl Serialize) -> Bytes {
    match serde_json::to_vec(value) {
        Ok(bytes) => bytes.into(),
        Err(error) => {
            tracing::error!(%error, "a value has no JSON form");
            Bytes::from_static(b"null")
        }
    }
}
