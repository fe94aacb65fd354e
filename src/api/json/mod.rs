//! JSON: requests, as the model has them, and answers.
//!
//! - [`read`]: reads JSON with serde, and says in plain words what is wrong with it; `long_strings`: what errors
//!   would repeat;
//! - [`request`]: the body of a job or an edit;
//! - [`view`]: the JSON of answers; [`plain`]: schemas that generators of clients understand.

mod long_strings;
pub(crate) mod plain;
pub(crate) mod read;
pub(crate) mod request;
pub(crate) mod view;
