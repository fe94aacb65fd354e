//! The level of another job that a job or an edit starts from.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::timeout;

use super::app::App;
use super::jobs;
use super::problem::{Locator, Problem};
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use crate::model::errors::{SpecPart, ValidationError};
use crate::model::iteration::IterationChoice;
use crate::model::job::{JobRequest, Limits, ValidJob};
use crate::model::scattered::{FootPoints, no_base};
use piad_files::text::quoted;
use piad_fit::engine::foot;
use piad_fit::geometry::Nurbs;

/// The time that a request which starts from an iteration of another job waits for the first one.
const BEGINS_WITHIN: Duration = Duration::from_secs(10);

/// The surface of another job on which the scattered points of a job have their foot points.
pub(super) struct Base {
    /// Its level, or why there is none.
    frame: Result<Arc<Frame>, ValidationError>,
    /// The memory for the search.
    _memory: Option<Permit>,
}

impl Base {
    /// For a job without a surface, or with parameters of its own.
    pub(super) fn none() -> Self {
        Self {
            frame: Err(no_base()),
            _memory: None,
        }
    }

    /// The surface that a job refers to, once there is memory for the search.
    pub(super) async fn of(app: &App, base: Option<&FootPoints>) -> Result<Self, Problem> {
        let Some(base) = base else {
            return Ok(Self::none());
        };
        let frame = frame_of(app, base).await?;
        let files = &app.jobs.resources().memory.files;
        let memory = match &frame {
            Ok(frame) => {
                let bytes = foot::memory(&frame.problem);
                files.take(Peer::current(), bytes).await
            }
            Err(_) => None,
        };
        Ok(Self {
            frame,
            _memory: memory,
        })
    }

    /// Returns true if there is a surface.
    pub(super) fn is_given(&self) -> bool {
        self.frame.is_ok()
    }

    /// Validates a job that refers to it.
    pub(super) fn validate(
        self,
        request: JobRequest,
        limits: Limits,
        locator: &impl Locator,
    ) -> Result<ValidJob, Problem> {
        let surface = self
            .frame
            .map(|base| Nurbs::of(&base.problem, &base.control_points));
        let valid = request.validate(limits, surface.as_ref().map_err(ValidationError::clone));
        valid.map_err(|errors| Problem::of_errors(errors, locator))
    }
}

/// The level of another job that a new one refers to, or why there is none.
async fn frame_of(
    app: &App,
    base: &FootPoints,
) -> Result<Result<Arc<Frame>, ValidationError>, Problem> {
    let Some(job) = jobs::known(app, &base.job).await? else {
        let detail = format!("there is no job {}", quoted(&base.job));
        return Ok(Err(ValidationError::at(SpecPart::FootPoints, detail)));
    };
    let iteration = base.iteration.and_then(IterationChoice::number);
    let place = match iteration {
        Some(_) => SpecPart::FootPointsIteration,
        // The surface would depend on the momentary progress of the job.
        None if !job.status().state.is_final() => {
            let detail = format!(
                "the job is {}: wait until it has ended, or name an iteration that it has reached",
                job.status().state
            );
            return Ok(Err(ValidationError::at(SpecPart::FootPoints, detail)));
        }
        None => SpecPart::FootPoints,
    };
    let frame = start(&job, iteration).await?;
    Ok(frame.map_err(|detail| ValidationError::at(place, detail)))
}

/// The level of a job that an edit or another job starts from, or why there is none.
pub(super) async fn start(
    parent: &Arc<Job>,
    iteration: Option<usize>,
) -> Result<Result<Arc<Frame>, String>, Problem> {
    let reached = reached(parent).await?;
    let state = parent.status().state;
    let Some(reached) = reached else {
        return Ok(Err(format!(
            "the job is {state} and has no iteration to start from"
        )));
    };
    let k = iteration.unwrap_or(reached);
    if k > reached {
        return Ok(Err(format!(
            "the job is {state} at iteration {reached}, before {k}"
        )));
    }
    Ok(match Cursor::new(Arc::clone(parent), k).next().await? {
        Next::Frame(frame) => Ok(frame),
        Next::End(status) => Err(format!("the job is {} before iteration {k}", status.state)),
    })
}

/// The progress of a job. A new one is waited for.
async fn reached(job: &Arc<Job>) -> Result<Option<usize>, Problem> {
    let reached = || job.status().levels.map(|levels| levels.last.iteration);
    if reached().is_some() {
        return Ok(reached());
    }
    let mut first = Cursor::new(Arc::clone(job), 0);
    Ok(match timeout(BEGINS_WITHIN, first.next()).await {
        // Another replica may run the job and not have reported its progress yet.
        Ok(Ok(Next::Frame(_))) => reached().or(Some(0)),
        Ok(Ok(Next::End(_))) | Err(_) => reached(),
        Ok(Err(error)) => return Err(error.into()),
    })
}
