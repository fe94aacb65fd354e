//! The bodies of jobs and edits in JSON.
//!
//! - [`job`]: a job, with a fast path for its [`points`];
//! - [`file`]: a job whose points are in a file, with fields by their [`path`];
//! - [`batch`]: the schema of a batch;
//! - [`edit`]: changes of another one;
//! - [`places`]: locations of the parts of the model.

pub(crate) mod batch;
pub(crate) mod edit;
pub(crate) mod file;
pub(crate) mod job;
pub(crate) mod path;
pub(crate) mod places;
mod points;
