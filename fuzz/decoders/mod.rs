//! What the fuzz targets call (`fuzz/`): each decoder with any bytes, and what must hold of all that it
//! accepts. Tests give it the seeds.
//!
//! Points that are read quickly are those that serde reads. A job that is accepted is written again, in
//! JSON, as a message and as it is kept in the store, and each is read again: the problem is the same to
//! the last bit. Then its first levels are computed.

mod made;
#[cfg(test)]
mod tests;

use std::sync::{Arc, OnceLock};

use bytes::Bytes;

use crate::api::json::request::{edit as json_edit, job as json_job};
use crate::api::json::view;
use crate::api::problem::{Locator, Problem as Refusal};
use crate::api::proto;
use crate::config::Config;
use crate::job::outline::{Label, Outline};
use crate::job::result::LastGeometry;
use crate::job::state::{Levels, State, Status};
use crate::job::store::fuzzing as store;
use crate::job::store::{Record, StoreError};
use crate::model::edit::{EditRequest, ParentFit};
use crate::model::errors::MAX_ERRORS;
use crate::model::job::{JobRequest, ValidJob};
use crate::model::scattered::no_base;
use made::Choices;
use piad_fit::data::Points;
use piad_fit::engine::{Iteration, Problem, System};

/// Jobs of more points are read and written, but not computed.
const MOST_POINTS: usize = 50;

/// Nor are those that take more multiplications before the first level.
const MOST_WORK: usize = 1_000_000;

/// Lists of points are read in parts of this many bytes.
const SHORT: usize = 50;

/// The levels that are computed after the first.
const LEVELS: usize = 3;

/// The maximum size of an error response in bytes.
const LONGEST_ANSWER: usize = 64 * 1024;

/// The body of `POST /v1/jobs` in JSON.
pub fn job(bytes: &[u8]) {
    if let Some(job) = accepted(job_of_json(bytes)) {
        check(&job);
    }
}

/// The body of `POST /v1/jobs/{id}/edits` in JSON, for each of a few jobs.
pub fn edit(bytes: &[u8]) {
    parents()
        .iter()
        .for_each(|parent| check_edit(edit_of_json(parent, bytes)));
}

/// The body of `POST /v1/jobs` as a protobuf message.
pub fn message(bytes: &[u8]) {
    if let Some(job) = accepted(job_of_message(bytes)) {
        check(&job);
    }
}

/// The body of `POST /v1/jobs/{id}/edits` as a protobuf message, for each of the same jobs.
pub fn edit_message(bytes: &[u8]) {
    parents()
        .iter()
        .for_each(|parent| check_edit(edit_of_message(parent, bytes)));
}

/// A job that is made up of the bytes, and an edit of it.
pub fn made(bytes: &[u8]) {
    let mut choices = Choices::of(bytes);
    let asked = choices.job();
    let Some(job) = accepted(job_of_json(&view::to_bytes(&asked))) else {
        return;
    };
    check(&job);
    if let Some(parent) = Parent::of(job) {
        let edit = choices.edit(&asked);
        check_edit(edit_of_json(&parent, &view::to_bytes(&edit)));
    }
}

/// A record of the store. The first byte says of which kind.
pub fn record(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    match kind % 4 {
        0 => check_kept(store::record(bytes), store::kept_record, store::record),
        1 => check_kept(store::result(bytes), store::kept_result, store::result),
        2 => check_kept(store::entry(bytes), store::kept_entry, store::entry),
        _ => {
            let problem = store::problem(bytes);
            if let Ok(problem) = &problem {
                compute(problem);
            }
            check_kept(problem, store::kept, store::problem);
        }
    }
}

fn config() -> &'static Config {
    static CONFIG: OnceLock<Config> = OnceLock::new();
    CONFIG.get_or_init(Config::standard)
}

fn job_of_json(bytes: &[u8]) -> Result<ValidJob, Refusal> {
    check_quick(bytes);
    let most = config().max_points;
    let (request, places) = json_job::read(Bytes::copy_from_slice(bytes), most)?;
    valid(request, &places)
}

/// What is read quickly is what serde reads, to the last bit.
fn check_quick(bytes: &[u8]) {
    let most = config().max_points;
    if let Some(quick) = json_job::read_quickly(bytes, SHORT, most) {
        let read = json_job::read_by_serde(bytes, most);
        let read = read.map_err(|problem| problem.detail().to_owned());
        assert_eq!(
            view::to_bytes(&quick),
            view::to_bytes(&read.unwrap_or_default())
        );
    }
}

fn job_of_message(bytes: &[u8]) -> Result<ValidJob, Refusal> {
    let (request, layout) = proto::request::read(Bytes::copy_from_slice(bytes), config())?;
    valid(request, &layout)
}

fn valid(request: JobRequest, locator: &impl Locator) -> Result<ValidJob, Refusal> {
    let valid = request.validate(config().limits(), Err(no_base()));
    valid.map_err(|errors| Refusal::of_errors(errors, locator))
}

/// Returns the accepted value. A refusal must have errors of limited length.
fn accepted<T>(outcome: Result<T, Refusal>) -> Option<T> {
    let refusal = match outcome {
        Ok(accepted) => return Some(accepted),
        Err(refusal) => refusal,
    };
    assert!(!refusal.detail().is_empty(), "{refusal:?}");
    assert!(refusal.errors().len() <= MAX_ERRORS, "{refusal:?}");
    let answer = view::to_bytes(&refusal.body(None));
    assert!(answer.len() <= LONGEST_ANSWER, "{refusal:?}");
    None
}

/// The outline of a job. Nothing depends on its id.
fn outline(job: &ValidJob) -> Outline {
    let label = Label {
        name: job.name.clone(),
        parent: None,
        stream: job.stream.clone(),
        notices: Vec::new(),
    };
    Outline::new(label, &job.problem, None)
}

/// What must hold of every job that is accepted: what is written of it asks for the same job.
fn check(job: &ValidJob) {
    let outline = outline(job);
    let json = view::input::input(&outline, &job.problem);
    check_same(job, &job_of_json(&json));
    let message = proto::view::input(&outline, &job.problem);
    check_same(job, &job_of_message(&message));
    check_run(outline, &job.problem);
}

fn check_same(job: &ValidJob, again: &Result<ValidJob, Refusal>) {
    assert!(again.is_ok(), "{again:?} for what was written of {job:?}");
    if let Ok(again) = again {
        assert_eq!((&again.name, &again.stream), (&job.name, &job.stream));
        let kept = (store::kept(&again.problem), store::kept(&job.problem));
        assert!(kept.0 == kept.1, "{again:?} for {job:?}");
    }
}

/// What was read from the store is there again after it was written: to the last bit, as not all
/// numbers are equal to themselves.
fn check_kept<T>(
    read: Result<T, StoreError>,
    write: impl Fn(&T) -> Vec<u8>,
    read_again: impl Fn(&[u8]) -> Result<T, StoreError>,
) {
    let Ok(read) = read else { return };
    let kept = write(&read);
    match read_again(&kept) {
        Ok(again) => assert_eq!(write(&again), kept),
        Err(error) => assert_eq!(error.to_string(), "it can be read", "{kept:?}"),
    }
}

/// A level of a fit as it is kept.
fn kept_level(iteration: &Iteration) -> Vec<u8> {
    store::kept_result(&LastGeometry {
        control_points: iteration.shared_control_points(),
        bases: iteration.problem().bases().map(Arc::new),
    })
}

/// A job is kept as it is, before it runs and after.
fn check_run(outline: Outline, problem: &Problem) {
    let kept = store::kept(problem);
    check_kept(store::problem(&kept), store::kept, store::problem);
    let iteration = compute(problem);
    if let Some(iteration) = &iteration {
        let kept = kept_level(iteration);
        check_kept(store::result(&kept), store::kept_result, store::result);
    }
    let record = record_of(outline, iteration.as_ref());
    let kept = store::kept_record(&record);
    check_kept(store::record(&kept), store::kept_record, store::record);
}

/// The record of a job, which was cancelled if it has begun.
fn record_of(outline: Outline, iteration: Option<&Iteration>) -> Record {
    let levels = iteration.map(|iteration| Levels {
        first: iteration.level(),
        last: iteration.level(),
        forecast: iteration.system().forecast(),
    });
    let (created, begun) = (outline.created, iteration.is_some());
    let state = if begun {
        State::Cancelled
    } else {
        State::Queued
    };
    let status = Status {
        state,
        levels,
        started: begun.then_some(created),
        finished: begun.then_some(created),
        ..Status::QUEUED
    };
    Record::new(outline, status)
}

/// The first levels of a small problem.
fn compute(problem: &Problem) -> Option<Iteration> {
    if problem.grid().count() > MOST_POINTS || problem.start_cost() > MOST_WORK {
        return None;
    }
    let system = Arc::new(System::new(Arc::new(problem.clone())));
    let mut iteration = Iteration::start_plain(system);
    for _ in 0..LEVELS {
        if iteration.outcome().is_some() {
            break;
        }
        iteration.step();
    }
    Some(iteration)
}

/// A job that is edited.
struct Parent {
    outline: Outline,
    problem: Problem,
    control_points: Arc<Points>,
}

/// A curve, one with weights, one with fixed weights, a surface, and one with missing points.
const PARENTS: [&str; 5] = [
    include_str!("../seeds/job/curve.json"),
    include_str!("../seeds/job/homogeneous.json"),
    include_str!("../seeds/job/fixed.json"),
    include_str!("../seeds/job/surface.json"),
    include_str!("../seeds/job/missing.json"),
];

fn parents() -> &'static [Parent] {
    static JOBS: OnceLock<Vec<Parent>> = OnceLock::new();
    JOBS.get_or_init(|| {
        let parent = |text: &&str| Parent::of(job_of_json(text.as_bytes()).ok()?);
        PARENTS.iter().filter_map(parent).collect()
    })
}

fn edit_of_json(parent: &Parent, bytes: &[u8]) -> Result<ValidJob, Refusal> {
    let (request, places) = json_edit::read(Bytes::copy_from_slice(bytes), &parent.outline)?;
    parent.edited(request, &places)
}

fn edit_of_message(parent: &Parent, bytes: &[u8]) -> Result<ValidJob, Refusal> {
    let most = parent.outline.grid.count();
    let message = proto::request::decode(Bytes::copy_from_slice(bytes), most)?;
    let (request, layout) = proto::edit::edit(message, &parent.outline)?;
    parent.edited(request, &layout)
}

impl Parent {
    /// A job at one of its first levels.
    fn of(job: ValidJob) -> Option<Self> {
        Some(Self {
            outline: outline(&job),
            control_points: compute(&job.problem)?.shared_control_points(),
            problem: job.problem,
        })
    }

    fn edited(&self, request: EditRequest, locator: &impl Locator) -> Result<ValidJob, Refusal> {
        let origin = ParentFit {
            problem: &self.problem,
            control_points: &self.control_points,
            lambda_min: None,
            stream: None,
        };
        let edited = request.apply(&origin, config().limits());
        edited.map_err(|errors| Refusal::of_errors(errors, locator))
    }
}

/// What must hold of every edit that is accepted. What is written of it asks for its problem from the
/// start.
fn check_edit(edited: Result<ValidJob, Refusal>) {
    let Some(job) = accepted(edited) else {
        return;
    };
    let outline = outline(&job);
    let json = view::input::input(&outline, &job.problem);
    let again = job_of_json(&json);
    assert!(again.is_ok(), "{again:?} for what was written of {job:?}");
    if let Ok(again) = again {
        let again = view::input::input(&outline, &again.problem);
        assert_eq!(again, json);
    }
    check_run(outline, &job.problem);
}
