//! What is wrong with a job or an edit, and with which part of it.
//!
//! Places are parts of the model. The language in which a request was written says where they stand
//! there: JSON by a pointer, a protobuf message by the path of a field.

use std::fmt;

use super::stream::Choice;
use piad_fit::invalid as fit;

/// The most errors that are reported at once.
pub(crate) const MOST_MISTAKES: usize = 16;

/// A part of a job or an edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpecPart {
    /// All of it.
    Whole,
    /// The client's name for the job.
    Name,
    /// A part of the fitting problem.
    Fit(fit::Place),
    /// How weights are used.
    Rational,
    /// The last iteration that is computed.
    MaxIterations,
    /// A choice of the streams, or an element of its list.
    Stream(Choice, Option<usize>),
    /// The steps between heights, or one of them: along x or y.
    Spacing(Option<usize>),
    /// Where heights start, or a coordinate of that.
    Origin(Option<usize>),
    /// The job on whose surface scattered points have their foot points.
    FootPoints,
    /// Its iteration.
    FootPointsIteration,
    /// Edits: the iteration to start from.
    Iteration,
    /// Edits: whether nothing of it is kept.
    Ephemeral,
    /// Ephemeral edits: the name of the drag.
    Session,
    /// Edits: an entry of the list of points that change, or a part of it.
    Change(usize, ChangePart),
}

/// A part of what an edit says of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangePart {
    /// All of it.
    Whole,
    /// Which point.
    Index,
    /// Where it goes.
    Point,
    /// Its weight.
    Weight,
}

/// Where something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Site {
    /// In a part of the model.
    Part(SpecPart),
    /// At a place in the language of the request that is no part of the model.
    Text(String),
}

/// What is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Where.
    pub site: Site,
    /// Why.
    pub detail: String,
}

impl Mistake {
    /// An error in a part of the model.
    pub fn at(place: SpecPart, detail: impl Into<String>) -> Self {
        Self {
            site: Site::Part(place),
            detail: detail.into(),
        }
    }

    /// An error at a location that only the encoding of the request has.
    pub fn at_text(text: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            site: Site::Text(text.into()),
            detail: detail.into(),
        }
    }
}

/// What was read of a part of a request, or all that is wrong with it.
pub(crate) type OrMistakes<T> = Result<T, Mistakes>;

/// The independent errors that were found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mistakes(Vec<Mistake>);

impl Mistakes {
    /// Adds an error.
    pub fn push(&mut self, mistake: Mistake) {
        self.0.push(mistake);
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
            Err(mistakes) => {
                self.0.extend(mistakes.into().0);
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
        self.0.len() >= MOST_MISTAKES
    }

    /// The value if there are no errors.
    pub fn or<T>(self, value: T) -> OrMistakes<T> {
        if self.none() { Ok(value) } else { Err(self) }
    }
}

/// The details, in a line.
impl fmt::Display for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let details: Vec<&str> = self.0.iter().map(|it| it.detail.as_str()).collect();
        f.write_str(&details.join("; "))
    }
}

impl From<Mistake> for Mistakes {
    fn from(mistake: Mistake) -> Self {
        Self(vec![mistake])
    }
}

impl IntoIterator for Mistakes {
    type Item = Mistake;
    type IntoIter = std::vec::IntoIter<Mistake>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
