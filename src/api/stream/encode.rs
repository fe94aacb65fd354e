//! Encodes frames and descriptions of jobs as JSON or messages: once for all readers, and off the
//! network threads.

use std::sync::Arc;

use crate::api::json::view::{self, writer::Digits as ArrayDigits};
use crate::api::proto;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::scheduler::WorkLane;
use crate::job::state::Status;
use crate::job::store::StoreError;
use crate::model::stream::form::{Digits, Encoding, Form, View};
use crate::model::stream::options::StreamOptions;
use piad_fit::engine::samples::multiplications;

/// Contents of up to this many operations are encoded in place, others on the compute pool.
const SMALL: usize = 2000 * OPERATIONS_PER_NUMBER;

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

/// Returns true if no iteration follows.
pub(super) fn is_last(job: &Job, frame: &Frame) -> bool {
    frame.is_last || job.has_ended_at(frame.level.iteration)
}

/// The data of an `iteration` event, made once for each frame and form.
pub(crate) async fn frame(
    job: &Arc<Job>,
    frame: &Arc<Frame>,
    form: &Form,
) -> Result<Content, StoreError> {
    let in_full = form.digits == Digits::Auto && is_last(job, frame);
    let form = if in_full {
        form.in_full()
    } else {
        form.clone()
    };
    let key = Arc::clone(form.key());
    let (owner, shown) = (Arc::clone(job), Arc::clone(frame));
    let encode = || async move {
        owner.resources().counters.encodings.inc();
        let cost = Cost::of(&shown, form.view);
        let frame = shown;
        let encode = move || match form.is_protobuf() {
            false => view::level::level(&frame, &form),
            true => proto::geometry::iteration(&frame, &form),
        };
        off_network(&owner, cost, encode).await
    };
    let cache = &job.resources().memory.cache;
    frame.encoded(&key, cache, encode).await
}

/// The cost of encoding a content.
#[derive(Clone, Copy)]
pub(crate) struct Cost {
    numbers: usize,
    /// Multiplications for evaluating samples before they are encoded.
    evaluation: usize,
}

impl From<usize> for Cost {
    /// The cost for numbers in memory.
    fn from(numbers: usize) -> Self {
        let evaluation = 0;
        Self {
            numbers,
            evaluation,
        }
    }
}

impl Cost {
    /// The cost of a frame in a view.
    pub(crate) fn of(frame: &Frame, view: View) -> Self {
        let dimension = frame.control_points.dimension();
        let numbers = match view {
            View::Errors => 0,
            View::ControlPoints => frame.control_points.len() * dimension,
            View::Changed => frame.moved.as_ref().map_or(0, |moved| moved.len()) * dimension,
            View::Samples(grid) => grid.count() * dimension,
        };
        let evaluation = match view {
            View::Samples(grid) => multiplications(&frame.problem, grid),
            View::Errors | View::ControlPoints | View::Changed => 0,
        };
        Self {
            numbers,
            evaluation,
        }
    }

    /// The queue of encoding, if it is done on the compute pool in any case.
    pub(crate) fn lane(self) -> WorkLane {
        let operations = self.operations();
        match WorkLane::of_samples(self.evaluation) {
            WorkLane::Long(evaluation) => WorkLane::Long(evaluation),
            _ if self.is_small() => WorkLane::Quick,
            _ => WorkLane::of_wire(operations),
        }
    }

    /// Returns true if it costs less than handing it over.
    fn is_small(self) -> bool {
        self.operations() <= SMALL
    }

    fn operations(self) -> usize {
        let encoding = self.numbers.saturating_mul(OPERATIONS_PER_NUMBER);
        encoding.saturating_add(self.evaluation)
    }
}

/// Encodes on the compute pool, unless it is cheap.
pub(crate) async fn off_network(
    job: &Job,
    cost: impl Into<Cost>,
    encode: impl FnOnce() -> Content + Send + 'static,
) -> Result<Content, StoreError> {
    let cost: Cost = cost.into();
    // Many numbers are encoded while they are sent, piece by piece.
    let encode = move || match cost.is_small() {
        true => encode(),
        false => encode().costing(cost.operations()),
    };
    computed(job, cost, encode).await
}

/// Computes on the compute pool, unless it is cheap.
pub(super) async fn computed<T: Send + 'static>(
    job: &Job,
    cost: Cost,
    compute: impl FnOnce() -> T + Send + 'static,
) -> Result<T, StoreError> {
    if cost.is_small() {
        return Ok(compute());
    }
    let lane = match WorkLane::of_samples(cost.evaluation) {
        WorkLane::Long(evaluation) => WorkLane::Long(evaluation),
        _ => WorkLane::of_wire(cost.operations()),
    };
    let traced = job.trace().encode(cost.numbers);
    let compute = move || {
        let _traced = traced;
        compute()
    };
    let scheduler = &job.resources().scheduler;
    Ok(scheduler.compute_in_turns(lane, compute).await?)
}
