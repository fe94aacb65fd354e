//! Validation errors of a job or an edit, and their locations.
//!
//! Locations are parts of the model. The encoding of a request maps them: JSON to a pointer, a
//! protobuf message to the path of a field.

use std::fmt;

use super::stream::Choice;
use piad_fit::invalid as fit;

/// The most errors that are reported at once.
pub(crate) const MAX_ERRORS: usize = 16;

/// A part of a job or an edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpecPart {
    /// All of it.
    Whole,
    /// The client's name for the job.
    Name,
    /// A part of the fitting problem.
    Fit(fit::Place),
    /// The use of weights.
    Rational,
    /// The last iteration that is computed.
    MaxIterations,
    /// A choice of the streams, or an element of its list.
    Stream(Choice, Option<usize>),
    /// The steps between heights, or one of them: along x or y.
    Spacing(Option<usize>),
    /// The origin of heights, or a coordinate of it.
    Origin(Option<usize>),
    /// The job on whose surface scattered points have their foot points.
    FootPoints,
    /// Its iteration.
    FootPointsIteration,
    /// Edits: the iteration to start from.
    Iteration,
    /// Edits: the `ephemeral` setting.
    Ephemeral,
    /// Ephemeral edits: the name of the drag.
    Session,
    /// Edits: an entry of the list of points that change, or a part of it.
    Change(usize, ChangePart),
}

/// A part of the change of a point in an edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangePart {
    /// All of it.
    Whole,
    /// The index of the point.
    Index,
    /// Its new position.
    Point,
    /// Its weight.
    Weight,
}

/// The location of an error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// In a part of the model.
    Part(SpecPart),
    /// At a location in the encoding of the request that is not a part of the model.
    Text(String),
}

/// An error, with its location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValidationError {
    /// The location.
    pub location: Location,
    /// The reason.
    pub detail: String,
}

impl ValidationError {
    /// An error in a part of the model.
    pub fn at(place: SpecPart, detail: impl Into<String>) -> Self {
        Self {
            location: Location::Part(place),
            detail: detail.into(),
        }
    }

    /// An error at a location that only the encoding of the request has.
    pub fn at_text(text: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            location: Location::Text(text.into()),
            detail: detail.into(),
        }
    }
}

/// A part of a request, or all of its errors.
pub(crate) type OrErrors<T> = Result<T, ValidationErrors>;

/// The independent errors that were found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ValidationErrors(Vec<ValidationError>);

impl ValidationErrors {
    /// Adds an error.
    pub fn push(&mut self, error: ValidationError) {
        self.0.push(error);
    }

    /// Adds to the last one, after which no more are reported.
    pub fn more(&mut self, detail: &str) {
        if let Some(last) = self.0.last_mut() {
            last.detail = format!("{}; {detail}", last.detail);
        }
    }

    /// The value; its errors are added.
    pub fn keep<T>(&mut self, read: Result<T, impl Into<Self>>) -> Option<T> {
        match read {
            Ok(value) => Some(value),
            Err(errors) => {
                self.0.extend(errors.into().0);
                None
            }
        }
    }

    /// Returns true if there are none.
    pub fn none(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns true if no more are reported.
    pub fn full(&self) -> bool {
        self.0.len() >= MAX_ERRORS
    }

    /// The value if there are no errors.
    pub fn or<T>(self, value: T) -> OrErrors<T> {
        if self.none() { Ok(value) } else { Err(self) }
    }
}

/// The details, in a line.
impl fmt::Display for ValidationErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let details: Vec<&str> = self.0.iter().map(|it| it.detail.as_str()).collect();
        f.write_str(&details.join("; "))
    }
}

impl From<ValidationError> for ValidationErrors {
    fn from(error: ValidationError) -> Self {
        Self(vec![error])
    }
}

impl IntoIterator for ValidationErrors {
    type Item = ValidationError;
    type IntoIter = std::vec::IntoIter<ValidationError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
