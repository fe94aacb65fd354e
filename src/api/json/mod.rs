//! JSON: requests and answers.
//!
//! - [`read`]: reads JSON with serde, with plain error messages; `long_strings`: shortens overlong strings;
//! - [`request`]: the body of a job or an edit;
//! - [`view`]: the JSON of answers; [`plain`]: schemas that generators of clients understand.

mod long_strings;
pub(crate) mod plain;
pub(crate) mod read;
pub(crate) mod request;
pub(crate) mod view;
