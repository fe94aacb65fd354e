//! Errors in a file, located by line.

use std::fmt;

/// The most errors of a file that are reported.
pub(super) const MOST_ERRORS: usize = 10;

/// An error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The line, from 1; `None` if it concerns the whole file.
    pub line: Option<usize>,
    /// The hint that does not fit the file, if there is one: `part` or `columns`.
    pub hint: Option<&'static str>,
    /// The reason.
    pub detail: String,
}

/// The first errors in a file, at least one and at most ten.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileErrors(pub Vec<FileError>);

impl FileError {
    /// An error in a line, or in the whole file.
    pub(super) fn new(line: Option<usize>, detail: impl Into<String>) -> Self {
        Self {
            line,
            hint: None,
            detail: detail.into(),
        }
    }

    pub(super) fn at(line: usize, detail: impl Into<String>) -> Self {
        Self::new(Some(line), detail)
    }

    pub(super) fn of_file(detail: impl Into<String>) -> Self {
        Self::new(None, detail)
    }

    /// A hint that does not fit the file.
    pub(super) fn of_hint(hint: &'static str, detail: impl Into<String>) -> Self {
        Self {
            hint: Some(hint),
            ..Self::of_file(detail)
        }
    }
}

impl FileErrors {
    /// The errors of the part of a file that begins below this number of lines.
    pub(super) fn moved_down(mut self, lines: usize) -> Self {
        for line in self.0.iter_mut().filter_map(|it| it.line.as_mut()) {
            *line += lines;
        }
        self
    }
}

impl From<FileError> for FileErrors {
    fn from(error: FileError) -> Self {
        Self(vec![error])
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.detail),
            None => f.write_str(&self.detail),
        }
    }
}

impl fmt::Display for FileErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for FileErrors {}
