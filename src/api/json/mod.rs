//! The model in JSON.
//!
//! - [`read`]: JSON read to the letter, with all that is wrong in it; [`numbers`], [`per_direction`]: points and
//!   numbers straight into arrays, one value for both directions or one for each;
//! - [`request`]: the JSON of a job, and its way to a fitting problem;
//! - [`stream`]: the `stream` object of a job;
//! - [`schema`]: what clients may send;
//! - [`view`]: what the server answers.

pub mod numbers;
pub mod per_direction;
pub mod read;
pub mod request;
pub mod schema;
pub mod stream;
pub mod view;
