//! Jobs as resources.

use jiff::Timestamp;
use schemars::{JsonSchema, json_schema};
use serde::Serialize;
use uuid::Uuid;

use super::applied_method::AppliedMethod;
use super::error::ErrorView;
use super::examples;
use super::warning::WarningView;
use crate::api::json::plain::never_null;
use crate::api::problem::{Problem, ProblemBody};
use crate::job::Job;
use crate::job::outline::Outline;
use crate::job::state::{Levels, Reason, State, Status};
use crate::model::schema::schema_of;
use crate::model::stream::StreamSpec;

/// A fit as it stands.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "Job", example = examples::job())]
pub(crate) struct JobView<'a> {
    /// Its id; ids grow with time.
    id: Uuid,
    /// The client's name for it.
    name: Option<&'a str>,
    /// Curve or surface.
    kind: GeometryKind,
    /// Its state.
    #[schemars(with = "State")]
    state: &'static str,
    /// The reason of the end, if the state does not imply it.
    #[schemars(with = "Option<EndReason>")]
    reason: Option<&'static str>,
    /// The reason in words, with the remaining distance.
    detail: Option<String>,
    /// Warnings; some are found only when the job begins to run.
    warnings: Vec<WarningView>,
    /// Notices about the file that has its points, in sentences. Absent if there are none.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    notices: &'a [String],
    /// The number of data points.
    points: usize,
    /// The method.
    method: AppliedMethod,
    /// Its end conditions.
    stop: AppliedStop,
    /// The stream options of the job, if it has any.
    stream: Option<&'a StreamSpec>,
    /// The last iteration so far.
    iteration: Option<usize>,
    /// The forecast at that iteration.
    predicted: Prediction,
    /// The distances at that iteration.
    error: Option<ErrorView>,
    /// Its progress.
    #[schemars(range(min = 0, max = 1))]
    progress: f64,
    /// When it was accepted.
    created_at: Timestamp,
    /// When it began to run.
    started_at: Option<Timestamp>,
    /// When it ended.
    finished_at: Option<Timestamp>,
    /// Its paths.
    links: Links,
    /// The job of which it is an edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    parent: Option<ParentView>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<ProblemBody>,
}

impl<'a> JobView<'a> {
    /// The job as it stands.
    pub(crate) fn new(job: &'a Job) -> Self {
        let status = job.status();
        let outline = job.outline();
        let level = status.levels.map(|levels| levels.last);
        let forecast = status.levels.map(|levels| levels.forecast);
        let parent = outline.label.parent;
        Self {
            id: outline.id,
            name: outline.label.name.as_deref(),
            kind: GeometryKind::of(outline),
            state: status.state.name(),
            reason: status.reason.map(Reason::name),
            detail: status.detail(outline),
            warnings: WarningView::of(outline, status.levels.as_ref()),
            notices: &outline.label.notices,
            points: outline.grid.count(),
            method: AppliedMethod::new(outline, forecast),
            stop: AppliedStop::new(outline),
            stream: stream(outline),
            iteration: level.map(|level| level.iteration),
            predicted: Prediction {
                rate: forecast.and_then(|it| it.rate),
                iterations: level.and_then(|level| level.predicted),
            },
            error: level.map(|level| ErrorView::of_last(&level, outline)),
            progress: status.progress(outline),
            created_at: outline.created,
            started_at: status.started,
            finished_at: status.finished,
            links: Links::new(job),
            parent: parent.map(|it| ParentView {
                id: it.id,
                iteration: it.iteration,
            }),
            problem: failure(&status),
        }
    }
}

/// Why a job has failed.
pub(super) fn failure(status: &Status) -> Option<ProblemBody> {
    status.failure.map(|it| Problem::from(it).body(None))
}

/// A page of the list of jobs.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"jobs": [], "next": null}]))]
pub(crate) struct JobPage<'a> {
    /// Jobs, the newest first.
    pub jobs: Vec<JobView<'a>>,
    /// The next page, if there is one.
    #[schemars(extend("format" = "uri-reference"))]
    pub next: Option<String>,
}

/// The geometry.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Curve)]
pub(in crate::api) enum GeometryKind {
    Curve,
    Surface,
}

impl GeometryKind {
    /// The geometry that a job fits.
    pub(super) fn of(outline: &Outline) -> Self {
        if outline.surface {
            Self::Surface
        } else {
            Self::Curve
        }
    }
}

/// When the iteration ends.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"tolerance": 1e-6, "max_iterations": 1000}]))]
pub(super) struct AppliedStop {
    /// The largest allowed distance, in data units.
    tolerance: f64,
    /// The last iteration that is computed.
    max_iterations: usize,
}

impl AppliedStop {
    /// The stop rules of a job.
    pub(super) fn new(outline: &Outline) -> Self {
        Self {
            tolerance: outline.tolerance,
            max_iterations: outline.max_iterations,
        }
    }
}

/// The default stream options of a job.
pub(super) fn stream(outline: &Outline) -> Option<&StreamSpec> {
    outline.label.stream.as_deref()
}

/// The forecast of the convergence.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"rate": 0.8, "iterations": 60}]))]
pub(super) struct Prediction {
    /// The factor by which the error shrinks in each iteration, in the long run.
    rate: Option<f64>,
    /// The approximate total number of iterations; null if unknown.
    iterations: Option<usize>,
}

impl Prediction {
    /// The forecast at iteration 0.
    pub(super) fn at_first(levels: Option<Levels>) -> Self {
        Self {
            rate: levels.and_then(|levels| levels.forecast.rate),
            iterations: levels.and_then(|levels| levels.first.predicted),
        }
    }
}

/// The job of which another one is an edit.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Parent", extend("examples" = [{"id": examples::ID, "iteration": 38}]))]
struct ParentView {
    /// Its id.
    id: Uuid,
    /// The iteration from whose control points the edit started.
    iteration: usize,
}

/// Paths of a job.
#[derive(Serialize, JsonSchema)]
#[schemars(example = examples::links())]
pub(super) struct Links {
    /// The job.
    #[serde(rename = "self")]
    #[schemars(extend("format" = "uri-reference"))]
    itself: String,
    /// Its event stream.
    #[schemars(extend("format" = "uri-reference"))]
    events: String,
    /// The job as it was requested.
    #[schemars(extend("format" = "uri-reference"))]
    input: String,
    /// The final curve or surface.
    #[schemars(extend("format" = "uri-reference"))]
    result: String,
    /// The address of edits.
    #[schemars(extend("format" = "uri-reference"))]
    edits: String,
    /// The limits of the fixed points of a local fit.
    #[schemars(extend("format" = "uri-reference"))]
    limit: String,
    /// The address for cancelling, with POST.
    #[schemars(extend("format" = "uri-reference"))]
    cancel: String,
}

impl Links {
    /// The paths of a job that is kept.
    pub(super) fn of(job: &Job) -> Option<Self> {
        job.is_kept().then(|| Self::new(job))
    }

    fn new(job: &Job) -> Self {
        let base = path(job);
        Self {
            events: format!("{base}/events"),
            input: format!("{base}/input"),
            result: format!("{base}/result"),
            edits: format!("{base}/edits"),
            limit: format!("{base}/limit"),
            cancel: format!("{base}/cancel"),
            itself: base,
        }
    }
}

/// The path of a job.
pub(crate) fn path(job: &Job) -> String {
    format!("{}/v1/jobs/{}", job.resources().base_path, job.id())
}

schema_of!(
    State,
    "JobState",
    json_schema!({
        "description": "Where a job is in its life: queued → running → converged (within the tolerance; with reason minimum, a least-squares fit without a tolerance that was requested at its minimum) | exhausted (at max_iterations) | stalled (the method cannot continue) | failed | cancelled.",
        "type": "string",
        "enum": State::ALL.map(State::name),
        "examples": ["converged"],
    })
);

/// Why a job ended.
pub(crate) enum EndReason {}

schema_of!(
    EndReason,
    "EndReason",
    json_schema!({
        "description": "Why a job ended, where its state does not say it. minimum: a least-squares fit is at its minimum, which is stalled if it is above a tolerance that was requested, else converged; convexity: no step keeps the convexity of the data; nilpotent: the extended method has come to its end; rounding: distances do not fall any more; diverging: distances grow.",
        "type": "string",
        "enum": Reason::ALL.map(Reason::name),
        "examples": ["minimum"],
    })
);
