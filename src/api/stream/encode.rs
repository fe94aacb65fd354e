//! Encodes frames and descriptions of jobs as JSON or messages: once for all readers, and off the
//! network threads.

use std::sync::Arc;

use crate::api::json::view::{self, writer::Digits as ArrayDigits};
use crate::api::proto;
use crate::fit::direction::Direction;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::scheduler::WorkLane;
use crate::job::state::Status;
use crate::job::store::StoreError;
use crate::model::stream::form::{Digits, Encoding, Form, View};
use crate::model::stream::options::StreamOptions;

/// Up to so many numbers are encoded at once, more of them on the compute pool.
const SMALL: usize = 2000;

/// Encoding a number takes about as long as this many multiplications.
const OPERATIONS_PER_NUMBER: usize = 50;

/// The data of the `job` event, made once for each job and encoding.
pub(super) async fn description(
    job: &Arc<Job>,
    options: &StreamOptions,
) -> Result<Content, StoreError> {
    // Always with 64 bits: knots that lie close together would coincide in 32 bits.
    let (name, digits) = match (options.form.encoding, options.describes) {
        (Encoding::Protobuf, true) => ("protobuf", None),
        (Encoding::Protobuf, false) => ("protobuf alone", None),
        (Encoding::Json, true) => ("json", Some(ArrayDigits::Decimal(None))),
        (_, true) => ("base64", Some(ArrayDigits::Base64)),
        (_, false) => ("json alone", Some(ArrayDigits::Decimal(None))),
    };
    let describes = options.describes;
    let problem = job.problem().await?;
    let owner = Arc::clone(job);
    job.description(name, || async move {
        let numbers = if describes { problem.grid().count() } else { 0 };
        let described = Arc::clone(&owner);
        let levels = owner.status().levels;
        let describe = move || match digits {
            None => proto::view::description(&described, &problem, levels, describes),
            Some(digits) => {
                view::events::description(&described, &problem, levels, digits, describes)
            }
        };
        off_network(&owner, numbers, describe).await
    })
    .await
}

/// The data of the `end` event.
pub(super) fn end(job: &Job, status: &Status, form: &Form) -> Content {
    match form.is_protobuf() {
        false => view::events::end(job, status).into(),
        true => proto::view::end(job, status),
    }
}

/// The data of an `iteration` event, made once for each frame and form.
pub(crate) async fn frame(
    job: &Arc<Job>,
    frame: &Arc<Frame>,
    form: &Form,
) -> Result<Content, StoreError> {
    let is_last = || frame.is_last || job.has_ended_at(frame.level.iteration);
    let in_full = form.digits == Digits::Auto && is_last();
    let form = if in_full {
        form.in_full()
    } else {
        form.clone()
    };
    let key = Arc::clone(form.key());
    let (owner, shown) = (Arc::clone(job), Arc::clone(frame));
    let encode = || async move {
        owner.resources().counters.encodings.inc();
        let numbers = numbers(&shown, form.view);
        let frame = shown;
        let encode = move || match form.is_protobuf() {
            false => view::level::level(&frame, &form),
            true => proto::geometry::iteration(&frame, &form),
        };
        off_network(&owner, numbers, encode).await
    };
    let cache = &job.resources().memory.cache;
    frame.encoded(&key, cache, encode).await
}

/// About how many numbers are encoded, or multiplied for samples.
fn numbers(frame: &Frame, view: View) -> usize {
    let dimension = frame.control_points.dimension();
    match view {
        View::Errors => 0,
        View::ControlPoints => frame.control_points.len() * dimension,
        View::Changed => frame.moved.as_ref().map_or(0, |moved| moved.len()) * dimension,
        View::Samples(grid) => {
            let functions = |direction: &Direction| direction.basis.support_width();
            let each: usize = frame.problem.directions().map(functions).product();
            grid.count().saturating_mul(each)
        }
    }
}

/// Encodes on the compute pool, unless there are few numbers.
pub(crate) async fn off_network(
    job: &Job,
    numbers: usize,
    encode: impl FnOnce() -> Content + Send + 'static,
) -> Result<Content, StoreError> {
    if numbers <= SMALL {
        return Ok(encode());
    }
    let lane = WorkLane::of_wire(numbers.saturating_mul(OPERATIONS_PER_NUMBER));
    let traced = job.trace().encode(numbers);
    let encode = move || {
        let _traced = traced;
        encode()
    };
    Ok(job.resources().scheduler.compute(lane, encode).await?)
}
