//! The contents of inputs, iterations and results, in JSON and protobuf.

use std::sync::Arc;

use super::json::view;
use super::language::Language;
use super::problem::{Kind, Problem};
use super::proto;
use super::stream::encode;
use crate::fit::foot;
use crate::fit::foot::deviation::Deviation;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::scheduler::WorkLane;
use crate::job::state::{Levels, Status};
use crate::model::stream::form::{Form, View};

/// Bytes of memory for each data point while an input is written.
const BYTES_PER_POINT: usize = 160;

/// Bytes of memory for each data point while distances are computed and written.
const BYTES_PER_DISTANCE: usize = 64;

/// To find a nearest point takes about as long as so many multiplications.
const OPERATIONS_PER_DISTANCE: usize = 5000;

/// The frame of a level, or without a number that of the last level so far.
pub async fn frame(job: &Arc<Job>, k: Option<usize>) -> Result<Arc<Frame>, Problem> {
    let k = match k {
        None => last_level(job)?,
        Some(k) => k,
    };
    match Cursor::new(Arc::clone(job), k).next().await? {
        Next::Frame(frame) => Ok(frame),
        Next::End(status) => {
            let reached = status.levels.map(|levels| levels.last.iteration);
            let detail = match reached {
                Some(last) => format!(
                    "the job is {} at iteration {last}, before {k}",
                    status.state
                ),
                None => format!("the job is {} before its first iteration", status.state),
            };
            Err(Problem::new(Kind::NoSuchIteration, detail))
        }
    }
}

/// How far the data are from a level, or without a number from the last level so far.
pub async fn deviation(
    job: &Arc<Job>,
    k: Option<usize>,
) -> Result<(Arc<Frame>, Deviation), Problem> {
    let frame = frame(job, k).await?;
    let count = frame.problem.grid().count();
    let needed = foot::memory(&frame.problem) + count * BYTES_PER_DISTANCE;
    let resources = job.resources();
    let _room = resources.memory.files.take(needed).await;
    let lane = WorkLane::of_wire(count.saturating_mul(OPERATIONS_PER_DISTANCE));
    let level = Arc::clone(&frame);
    let compute = move || Deviation::of(&level.problem, &level.control_points);
    match resources.scheduler.compute(lane, compute).await? {
        Ok(deviation) => Ok((frame, deviation)),
        Err(reason) => Err(Problem::new(Kind::NoDeviation, reason.to_string())),
    }
}

/// The job as it was accepted, as JSON or as the bytes of a message.
pub async fn input_content(job: &Arc<Job>, language: Language) -> Result<Content, Problem> {
    // An input is made as a whole, so it needs memory for files.
    let room = &job.resources().memory.files;
    let permit = room
        .take(job.outline().grid.count() * BYTES_PER_POINT)
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
pub async fn result_content(job: &Arc<Job>, form: Form) -> Result<Content, Problem> {
    let (status, frame) = end(job).await?;
    if form.view != View::ControlPoints && !form.is_protobuf() {
        return Ok(encode::frame(job, &frame, &form).await?);
    }
    let owner = Arc::clone(job);
    let points = &frame.control_points;
    let numbers = points.len() * points.dimension();
    let write = move || match form.is_protobuf() {
        false => view::result::result(&owner, &status, &frame, &form),
        true => proto::geometry::result(&owner, &status, &frame, form.view),
    };
    Ok(encode::off_network(job, numbers, write).await?)
}

fn last_level(job: &Job) -> Result<usize, Problem> {
    let status = job.status();
    let levels = status.levels.ok_or_else(|| {
        let detail = format!("the job is {} and has no iteration yet", status.state);
        Problem::new(Kind::NoSuchIteration, detail)
    })?;
    Ok(levels.last.iteration)
}
