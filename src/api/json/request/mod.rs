//! The bodies of jobs and edits in JSON.
//!
//! - [`job`]: a job, whose [`points`] are read quickly;
//! - [`file`]: a job whose points are in a file, with fields by their [`path`];
//! - [`batch`]: what many jobs look like;
//! - [`edit`]: changes of another one;
//! - [`places`]: where a part of the model stands.

pub(crate) mod batch;
pub(crate) mod edit;
pub(crate) mod file;
pub(crate) mod job;
pub(crate) mod path;
pub(crate) mod places;
mod points;
