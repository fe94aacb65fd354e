//! The contents of inputs, iterations and results, in JSON and protobuf.

use std::sync::Arc;

use tokio::time::{Duration, sleep};

use super::app::App;
use super::create_job;
use super::json::view;
use super::media_type::Language;
use super::problem::{Kind, Problem};
use super::proto;
use super::stream::encode::{self, Cost};
use crate::job::Job;
use crate::job::content::Content;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::peer::Peer;
use crate::job::scheduler::WorkLane;
use crate::job::state::{Levels, Status};
use crate::model::stream::form::{Form, View};
use piad_files::export::{Options, shape};
use piad_fit::engine::foot;
use piad_fit::engine::foot::Deviation;

/// Bytes of memory for each data point while an input is written.
const BYTES_PER_POINT: usize = 160;

/// Bytes of memory for each data point while distances are computed and written.
const BYTES_PER_DISTANCE: usize = 64;

/// The cost of finding a nearest point, in multiplications.
const OPERATIONS_PER_DISTANCE: usize = 5000;

/// Bytes of memory for each control point and each sample while a shape is measured.
const BYTES_PER_CONTROL_POINT: usize = 300;
const BYTES_PER_SAMPLE: usize = 160;

/// The default time to wait for an iteration that has not been reached.
pub(super) const WAIT: Duration = Duration::from_secs(10);

/// The frame of a level, or without a number that of the last level so far. It waits for as long as the client wants; a
/// level that was reached before is computed again, which ends by itself.
pub(super) async fn frame(
    app: &App,
    job: &Arc<Job>,
    k: Option<usize>,
    wait: Option<Duration>,
) -> Result<Arc<Frame>, Problem> {
    let k = match k {
        None => last_level(job)?,
        Some(k) => k,
    };
    let reached = job.status().levels.map(|levels| levels.last.iteration);
    let wait = wait.or_else(|| (reached < Some(k)).then_some(WAIT));
    let mut cursor = Cursor::new(Arc::clone(job), k);
    let next = tokio::select! {
        next = cursor.next() => next?,
        () = passed(wait) => return Err(not_yet(&job.status(), k)),
        () = app.stopped() => return Err(create_job::stopping()),
    };
    match next {
        Next::Frame(frame) => Ok(frame),
        Next::End(status) => Err(Problem::new(Kind::NoSuchIteration, before(&status, k))),
    }
}

/// Completes after this time, or never without one.
async fn passed(wait: Option<Duration>) {
    match wait {
        Some(wait) => sleep(wait).await,
        None => std::future::pending().await,
    }
}

/// The progress of a job that has not reached iteration `k`.
fn before(status: &Status, k: usize) -> String {
    let state = status.state;
    match status.levels.map(|levels| levels.last.iteration) {
        None => format!("the job is {state} before its first iteration"),
        Some(last) if last < k => format!("the job is {state} at iteration {last}, before {k}"),
        Some(_) => format!("the job is {state}; iteration {k} is being computed again"),
    }
}

/// An iteration was not reached in time.
fn not_yet(status: &Status, k: usize) -> Problem {
    let mut detail = before(status, k);
    if let Some(Levels { last, .. }) = status.levels {
        detail += &format!(", and its largest distance is {:.3e}", last.error.max);
        if let Some(end) = last.predicted {
            detail += &format!(", it is expected to end at iteration {end}");
        }
    }
    Problem::new(Kind::NotReached, detail).retry_after(WAIT.as_secs() as u32)
}

/// The distances of the data from a level, or without a number from the last level so far.
pub(super) async fn deviation(
    app: &App,
    job: &Arc<Job>,
    k: Option<usize>,
    wait: Option<Duration>,
) -> Result<(Arc<Frame>, Deviation), Problem> {
    let frame = frame(app, job, k, wait).await?;
    let count = frame.problem.grid().count();
    let needed = foot::memory(&frame.problem) + count * BYTES_PER_DISTANCE;
    let resources = job.resources();
    let peer = Peer::current();
    let _room = resources.memory.files.take(peer, needed).await;
    let lane = WorkLane::of_wire(count.saturating_mul(OPERATIONS_PER_DISTANCE));
    let level = Arc::clone(&frame);
    let compute = move || Deviation::of(&level.problem, &level.control_points);
    match resources.scheduler.compute(lane, compute).await? {
        Ok(deviation) => Ok((frame, deviation)),
        Err(reason) => Err(Problem::new(Kind::NoDeviation, reason.to_string())),
    }
}

/// The shape of a level, or without a number of the last level so far, with these samples.
pub(super) async fn shape(
    app: &App,
    job: &Arc<Job>,
    k: Option<usize>,
    samples: Options,
    wait: Option<Duration>,
) -> Result<Content, Problem> {
    let frame = frame(app, job, k, wait).await?;
    let surface = frame.problem.v().is_some();
    let needed = frame.control_points.len() * BYTES_PER_CONTROL_POINT
        + shape::sample_count(surface, &samples) * BYTES_PER_SAMPLE;
    let resources = job.resources();
    let permit = resources.memory.files.take(Peer::current(), needed).await;
    let lane = WorkLane::of_samples(shape::cost(&frame.problem, &samples));
    let measure = move || {
        let shape = shape::measure(&frame.problem, &frame.control_points, &samples);
        shape.map(|shape| view::curvature::shape(frame.level.iteration, shape))
    };
    let content = resources.scheduler.compute(lane, measure).await?;
    let content = content.map_err(|reason| Problem::new(Kind::NoShape, reason.to_string()))?;
    Ok(content.with_permit(permit))
}

/// The job as it was accepted, as JSON or as the bytes of a message.
pub(super) async fn input_content(job: &Arc<Job>, language: Language) -> Result<Content, Problem> {
    // An input is made as a whole, so it needs memory for files.
    let room = &job.resources().memory.files;
    let permit = room
        .take(
            Peer::current(),
            job.outline().grid.count() * BYTES_PER_POINT,
        )
        .await;
    let (owner, problem) = (Arc::clone(job), job.problem().await?);
    let numbers = problem.data().len() * problem.data().dimension();
    let write = move || match language {
        Language::Json => view::input::input(owner.outline(), &problem).into(),
        Language::Protobuf => proto::view::input(owner.outline(), &problem).into(),
    };
    let content = encode::off_network(job, numbers, write).await?;
    Ok(content.with_permit(permit))
}

/// The last level of a job that has ended.
pub(super) async fn end(job: &Job) -> Result<(Status, Arc<Frame>), Problem> {
    let status = job.status();
    let frame = match status.levels {
        Some(Levels { last, .. }) => job.last_frame(last).await?,
        None => None,
    };
    match frame {
        Some(frame) => Ok((status, frame)),
        None => {
            let detail = format!("the job is {} and has no result", status.state);
            Err(Problem::new(Kind::NoResult, detail))
        }
    }
}

/// The final geometry in a form, as JSON or as the bytes of a message.
pub(super) async fn result_content(job: &Arc<Job>, form: Form) -> Result<Content, Problem> {
    let (status, frame) = end(job).await?;
    if form.view != View::ControlPoints && !form.is_protobuf() {
        return Ok(encode::frame(job, &frame, &form).await?);
    }
    let owner = Arc::clone(job);
    let cost = Cost::of(&frame, form.view);
    let write = move || match form.is_protobuf() {
        false => view::result::result(owner.outline(), &status, &frame, &form),
        true => {
            let outline = owner.outline();
            let head = proto::geometry::ResultHead {
                id: Some(outline.id),
                name: outline.label.name.as_deref(),
                notices: &outline.label.notices,
                state: status.state,
            };
            proto::geometry::result(&head, &frame, form.view)
        }
    };
    Ok(encode::off_network(job, cost, write).await?)
}

fn last_level(job: &Job) -> Result<usize, Problem> {
    let status = job.status();
    let levels = status.levels.ok_or_else(|| {
        let detail = format!("the job is {} and has no iteration yet", status.state);
        Problem::new(Kind::NoSuchIteration, detail)
    })?;
    Ok(levels.last.iteration)
}
