//! What is wrong with a job or an edit, at its place in the JSON.

use crate::api::problem::{Kind, Problem};

/// A problem with the value at a JSON pointer.
pub(super) fn invalid(pointer: &str, detail: impl Into<String>) -> Problem {
    Problem::at_pointer(Kind::InvalidFit, pointer.to_owned(), detail)
}
