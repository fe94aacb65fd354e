//! The model in JSON.
//!
//! - [`read`]: reads JSON with serde, and says in plain words what is wrong with it; [`points`], [`lists`]: points
//!   and numbers, read straight into arrays; [`per_direction`]: schemas of one value for both directions of a
//!   surface, or one for each;
//! - [`request`]: the JSON of a job, and its way to a fitting problem;
//! - [`stream`]: the `stream` object of a job;
//! - [`schema`]: schemas of requests;
//! - [`view`]: the JSON of answers.

pub mod lists;
pub mod per_direction;
pub mod points;
pub mod read;
pub mod request;
pub mod schema;
pub mod stream;
pub mod view;
