//! The bodies of jobs and edits in JSON.
//!
//! - [`job`]: a job; [`file`]: a job whose points are in a file, with fields by their [`path`]; [`edit`]: changes of
//!   another one;
//! - [`places`]: where a part of the model stands.

pub mod edit;
pub mod file;
pub mod job;
pub mod path;
pub mod places;
