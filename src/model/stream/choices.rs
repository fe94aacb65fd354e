//! The source of each choice of a stream: its request, or the job for all of its streams; and
//! combinations that are not allowed.

use super::{Choice, StreamSpec};
use crate::model::errors::{SpecPart, ValidationError};
use crate::model::named::Named;
use piad_files::text::plain;

/// The source of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    /// By the request for the stream.
    Request,
    /// By the `stream` object of the job.
    Job,
}

/// An error of a choice, of the request for a stream or of the job.
#[derive(Debug)]
pub struct ChoiceError {
    by: By,
    choice: Choice,
    /// The element of a list.
    index: Option<usize>,
    detail: String,
}

impl ChoiceError {
    /// An error of the request for a stream.
    pub fn of_request(choice: Choice, detail: impl Into<String>) -> Self {
        Self {
            by: By::Request,
            choice,
            index: None,
            detail: detail.into(),
        }
    }

    /// The choice and the reason, if the request for the stream has made it.
    pub fn by_request(&self) -> Option<(Choice, &str)> {
        (self.by == By::Request).then_some((self.choice, self.detail.as_str()))
    }
}

/// An error of the job.
impl From<ChoiceError> for ValidationError {
    fn from(error: ChoiceError) -> Self {
        let place = SpecPart::Stream(error.choice, error.index);
        Self::at(place, error.detail)
    }
}

/// The choices of a request and those of the job. The request overrides the job.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choices<'a> {
    request: &'a StreamSpec,
    job: Option<&'a StreamSpec>,
}

/// Two choices that exclude each other: whether they were made, and the reason.
pub(super) type Conflict = (bool, Choice, Choice, &'static str);

impl<'a> Choices<'a> {
    pub(super) fn new(request: &'a StreamSpec, job: Option<&'a StreamSpec>) -> Self {
        Self { request, job }
    }

    /// The choice that was made.
    pub(super) fn get<T>(self, of: impl Fn(&'a StreamSpec) -> Option<T>) -> Option<T> {
        of(self.request).or_else(|| self.job.and_then(of))
    }

    /// The source of a choice, and its value.
    fn made(self, choice: Choice) -> Option<(By, String)> {
        let request = self.request.text(choice).map(|text| (By::Request, text));
        request.or_else(|| Some((By::Job, self.job?.text(choice)?)))
    }

    /// The error of a choice that was made.
    pub(super) fn error(self, choice: Choice, detail: impl Into<String>) -> ChoiceError {
        self.error_at(choice, None, detail)
    }

    /// The error of an element of a choice that was made.
    pub(super) fn error_at(
        self,
        choice: Choice,
        index: Option<usize>,
        detail: impl Into<String>,
    ) -> ChoiceError {
        ChoiceError {
            by: self.made(choice).map_or(By::Request, |(by, _)| by),
            choice,
            index,
            detail: detail.into(),
        }
    }

    /// Returns true if the job has made a choice, and the request has chosen `other`.
    pub(super) fn is_default_for(self, choice: Choice, other: Choice) -> bool {
        let by = |choice| self.made(choice).map(|(by, _)| by);
        by(choice) == Some(By::Job) && by(other) == Some(By::Request)
    }

    /// Refuses choices that exclude each other. The error blames a choice of the request before one
    /// of the job.
    pub(super) fn refuse(self, conflicts: &[Conflict]) -> Result<(), ChoiceError> {
        let Some(&(_, one, other, why)) = conflicts.iter().find(|(both, ..)| *both) else {
            return Ok(());
        };
        let (Some(first), Some(second)) = (self.made(one), self.made(other)) else {
            return Ok(());
        };
        let mut detail = format!(
            "{}={} and {}={} do not go together: {why}",
            one.name(),
            plain(&first.1),
            other.name(),
            plain(&second.1)
        );
        let (named, set) = match (first.0, second.0) {
            (By::Job, By::Request) => (other, one),
            _ => (one, other),
        };
        if self.is_default_for(set, named) {
            let (name, usual) = (set.name(), usual(set));
            detail.push_str(&format!(
                "; the job sets {name} for its streams, which {name}={usual} overrides"
            ));
        }
        Err(self.error(named, detail))
    }
}

/// The default value of a choice.
fn usual(choice: Choice) -> &'static str {
    match choice {
        Choice::View => "control_points",
        Choice::Every => "1",
        Choice::Pace => "all",
        Choice::Changed => "false",
        Choice::Describe => "full",
        Choice::Encoding => "json",
        Choice::Digits => "full",
        Choice::OnDisconnect => "continue",
        Choice::Samples | Choice::Milestones => "",
    }
}
