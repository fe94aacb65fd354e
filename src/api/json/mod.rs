//! JSON: requests, as the model has them, and answers.
//!
//! - [`read`]: reads JSON with serde, and says in plain words what is wrong with it;
//! - [`request`]: the body of a job or an edit;
//! - [`view`]: the JSON of answers; [`plain`]: schemas that generators of clients understand.

pub mod plain;
pub mod read;
pub mod request;
pub mod view;
