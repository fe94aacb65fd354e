//! The model in JSON.
//!
//! - [`read`]: a strict JSON reader that collects all mistakes; [`points`], [`numbers`]: points and numbers, read
//!   straight into arrays; [`per_direction`]: one value for both directions of a surface, or one for each;
//! - [`request`]: the JSON of a job, and its way to a fitting problem;
//! - [`stream`]: the `stream` object of a job;
//! - [`schema`]: schemas of requests;
//! - [`view`]: the JSON of answers.

pub mod numbers;
pub mod per_direction;
pub mod points;
pub mod read;
pub mod request;
pub mod schema;
pub mod stream;
pub mod view;
