//! A job as it was requested.

use bytes::Bytes;

use super::job::stream;
use super::to_bytes;
use crate::job::outline::Outline;
use crate::model::job::JobRequest;
use piad_fit::engine::Problem;

/// The body that would request the same problem again.
pub(crate) fn input(outline: &Outline, problem: &Problem) -> Bytes {
    let (name, stream) = (outline.label.name.clone(), stream(outline).cloned());
    to_bytes(&JobRequest::of(name, stream, problem.request()))
}
