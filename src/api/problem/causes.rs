//! Errors of lower layers as problems.

use super::{Kind, Problem};
use crate::api::json::request::places::Places;
use crate::job::outline::Outline;
use crate::job::quota::Exceeded;
use crate::job::scheduler::Broken;
use crate::job::service::refused::Refused;
use crate::job::state::{Failure, Levels, Status};
use crate::job::store::StoreError;
use crate::job::store::crash_recovery::MOST_CRASHES;
use crate::model::errors::ValidationError;
use crate::model::named::Named;
use crate::model::stream::choices::ChoiceError;
use piad_files::import::FileErrors;

impl Problem {
    /// The problem of a fit that has ended without an answer.
    pub(in crate::api) fn not_converged(outline: &Outline, status: &Status) -> Self {
        if let Some(failure) = status.failure {
            return Self::from(failure);
        }
        let state = status.state;
        let Some(Levels { last, .. }) = status.levels else {
            return Self::new(Kind::NotConverged, format!("the fit is {state}"));
        };
        let left = || {
            let (distance, tolerance) = (last.error.max, outline.tolerance);
            format!("a distance of {distance:.3e} is left, the tolerance is {tolerance:.3e}")
        };
        let why = status.detail(outline).unwrap_or_else(left);
        let detail = format!(
            "the fit is {state} after iteration {}: {why}",
            last.iteration
        );
        Self::new(Kind::NotConverged, detail)
    }
}

/// Of an HTTP request, whose own choices are query parameters; those of the job are in its JSON.
impl From<ChoiceError> for Problem {
    fn from(error: ChoiceError) -> Self {
        match error.by_request() {
            Some((choice, detail)) => Self::at_parameter(choice.name(), detail),
            None => Self::of_errors(ValidationError::from(error).into(), &Places::default()),
        }
    }
}

impl From<FileErrors> for Problem {
    fn from(FileErrors(errors): FileErrors) -> Self {
        let problems = errors
            .into_iter()
            .map(|error| match (error.line, error.hint) {
                (Some(line), _) => Self::at_line(line, &error.detail),
                (None, Some(hint)) => Self::of_hint(hint, &error.detail),
                (None, None) => Self::new(Kind::InvalidFit, error.detail),
            });
        let unsaid = || Self::new(Kind::InvalidFit, "the file could not be parsed");
        Self::of_all(problems).unwrap_or_else(unsaid)
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Overflow => Self::new(
                Kind::Overflow,
                "the distances from the data have left the range of numbers: the iteration has diverged, or the data are too large",
            ),
            Failure::Crashes => Self::new(
                Kind::Internal,
                format!(
                    "the server has crashed at least {MOST_CRASHES} times while this job was running; it is not tried again"
                ),
            ),
            Failure::Defect => Self::new(Kind::Internal, "the computation panicked"),
        }
    }
}

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let detail = refused.to_string();
        match refused {
            Refused::Full { .. } => Self::new(Kind::QueueFull, detail).retry_after(5),
            Refused::PeerFull { .. } => Self::new(Kind::TooManyJobs, detail).retry_after(5),
            Refused::Quota(exceeded) => exceeded.into(),
            Refused::KeyTaken(_) => Self::new(Kind::KeyTaken, detail),
            Refused::Store(error) => error.into(),
        }
    }
}

impl From<Exceeded> for Problem {
    fn from(exceeded: Exceeded) -> Self {
        let problem = Self::new(Kind::QuotaExceeded, exceeded.to_string());
        match exceeded.for_good {
            true => problem,
            false => problem.retry_after(5),
        }
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        let detail = error.to_string();
        match error {
            StoreError::Gone(id) => Self::unknown_job(&id.to_string()),
            StoreError::Full(_) => Self::new(Kind::StoreFull, detail).retry_after(60),
            StoreError::Away(_) | StoreError::Unusable(_) => {
                Self::new(Kind::StoreAway, detail).retry_after(5)
            }
            StoreError::Failed(_) | StoreError::Broken(_) => Self::new(Kind::Internal, detail),
        }
    }
}

impl From<Broken> for Problem {
    fn from(broken: Broken) -> Self {
        Self::new(Kind::Internal, broken.to_string())
    }
}
