//! What can be wrong with a file, at its line.

/// The most mistakes of a file that are reported.
pub(super) const MOST_MISTAKES: usize = 10;

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The line, from 1; none if it is about the whole file.
    pub line: Option<usize>,
    /// What is wrong there.
    pub detail: String,
}

impl Mistake {
    pub(super) fn at(line: usize, detail: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            detail: detail.into(),
        }
    }

    pub(super) fn of_file(detail: impl Into<String>) -> Self {
        Self {
            line: None,
            detail: detail.into(),
        }
    }
}
