//! Events with the differences from the reader's state.
//!
//! The reader's state is a function of the events since its last complete one. So readers with the same view that go
//! from the same complete iteration to the same next ones have the same state: each step is made once for all of them,
//! and they share the state. The others hold their own, and apply the same steps to it.

use std::sync::Arc;

use parking_lot::Mutex;

use super::encode::{self, Cost};
use crate::api::json::view::source::{NetPoints, NetWeights, Source};
use crate::api::json::view::writer::points_at_once;
use crate::api::{json, proto};
use crate::job::Job;
use crate::job::content::Content;
use crate::job::deltas::{Numbers, Step, Target};
use crate::job::frame::Frame;
use crate::job::store::StoreError;
use crate::model::stream::form::{Form, View};
use crate::model::stream::options::StreamOptions;
use piad_fit::data::Grid;
use piad_fit::engine::Geometry;
use piad_fit::engine::samples::Samples;

/// The events of a reader, each of which follows from the one before.
pub(super) struct Chain {
    /// The form of complete events with all 64 bits.
    form: Form,
    /// The distance from one iteration to the next, if readers with the same distance go the same way.
    every: Option<usize>,
    /// The reader's state, if changes can be applied to it.
    reader: Option<Reader>,
}

/// The state of a reader.
struct Reader {
    numbers: Arc<Numbers>,
    /// Identifies all readers with the same state, if there may be others.
    name: Option<Arc<str>>,
}

impl Chain {
    /// The events of a stream, if it is a difference stream.
    pub(super) fn new(options: &StreamOptions) -> Option<Self> {
        let regular = options.milestones.is_empty() && !options.latest;
        options.deltas.then(|| Self {
            form: options.form.clone(),
            every: regular.then_some(options.every),
            reader: None,
        })
    }

    /// The next event. It is complete at the start and the end, where knots are new, and where numbers differ too much
    /// from those before.
    pub(super) async fn event(
        &mut self,
        job: &Arc<Job>,
        frame: &Arc<Frame>,
        tells_knots: bool,
    ) -> Result<Content, StoreError> {
        let reader = self.reader.take().filter(|_| !tells_knots);
        let form = match tells_knots {
            true => self.form.with_knots(),
            false => self.form.clone(),
        };
        if encode::is_last(job, frame) {
            return encode::frame(job, frame, &form).await;
        }
        if let Some(reader) = reader
            && let Some((content, reader)) = self.step(job, frame, reader).await?
        {
            self.reader = Some(reader);
            return Ok(content);
        }
        self.complete(job, frame, form).await
    }

    /// A complete event, from which later events count differences.
    async fn complete(
        &mut self,
        job: &Arc<Job>,
        frame: &Arc<Frame>,
        form: Form,
    ) -> Result<Content, StoreError> {
        let memory = Arc::clone(&job.resources().memory.numbers);
        let (shown, view, is_json) = (Arc::clone(frame), form.view, !form.is_protobuf());
        let start = move || {
            let level = shown.level;
            let targets = targets(&shown, view);
            let numbers = Numbers::of(level.iteration, &targets, &memory);
            let narrow = |numbers: &Numbers| {
                is_json && numbers.have_room_in_32_bits(level.error.max) && fits(&shown, view)
            };
            let is_narrow = numbers.as_ref().is_some_and(narrow);
            // Without memory for the reader's state, all events are complete.
            let mut numbers = numbers.filter(|_| !memory.is_full());
            if let Some(numbers) = numbers.as_mut().filter(|_| is_narrow) {
                numbers.round_to_32_bits();
            }
            (numbers, is_narrow)
        };
        let cost = Cost::of(frame, form.view);
        let (numbers, is_narrow) = encode::computed(job, cost, start).await?;
        let form = match is_narrow {
            true => form.in_32_bits(),
            false => form,
        };
        let name = self.every.map(|every| {
            let since = frame.level.iteration;
            format!("{} since {since} every {every}", self.form.key()).into()
        });
        self.reader = numbers.map(|numbers| Reader {
            numbers: Arc::new(numbers),
            name,
        });
        encode::frame(job, frame, &form).await
    }

    /// The changes since the event before, and the state after them; `None` if they are too large, or there is no
    /// memory.
    async fn step(
        &self,
        job: &Arc<Job>,
        frame: &Arc<Frame>,
        reader: Reader,
    ) -> Result<Option<(Content, Reader)>, StoreError> {
        let k = frame.level.iteration;
        let cost = Cost::of(frame, self.form.view);
        let Reader { numbers, name } = reader;
        let held = Arc::new(Mutex::new(Some(numbers)));
        let make = || {
            let (owner, frame) = (Arc::clone(job), Arc::clone(frame));
            let (held, form) = (Arc::clone(&held), self.form.clone());
            async move {
                owner.resources().counters.encodings.inc();
                encode::computed(&owner, cost, move || step(&frame, &form, &held)).await
            }
        };
        let step = match &name {
            Some(name) => {
                let cache = &job.resources().memory.cache;
                frame.step(name, cache, make).await?
            }
            None => make().await?,
        };
        let Some((step, own)) = step.zip(held.lock().take()) else {
            return Ok(None);
        };
        let numbers = match step.after.upgrade() {
            _ if own.iteration() == k => own,
            Some(numbers) => numbers,
            None => {
                let changes = Arc::clone(&step.changes);
                let apply = move || {
                    let mut own = own;
                    let applied = Numbers::alone(&mut own)?.apply(k, &changes);
                    Some(applied.map(|()| own))
                };
                match encode::computed(job, cost, apply).await? {
                    Some(Ok(numbers)) => numbers,
                    Some(Err(reason)) => return Err(StoreError::Failed(reason.to_string())),
                    None => return Ok(None),
                }
            }
        };
        Ok(Some((step.content, Reader { numbers, name })))
    }
}

/// Applies the step to a frame to the state.
fn step(frame: &Frame, form: &Form, held: &Mutex<Option<Arc<Numbers>>>) -> Option<Step> {
    let mut numbers = held.lock().take()?;
    let level = &frame.level;
    let targets = targets(frame, form.view);
    let own = Numbers::alone(&mut numbers)?;
    let changes = own.follow(level.iteration, level.error.max, &targets)?;
    let content = match form.is_protobuf() {
        false => json::view::level::moved(frame, form.view, &changes),
        true => proto::geometry::moved(frame, form.view, &changes),
    };
    let after = Arc::downgrade(&numbers);
    *held.lock() = Some(numbers);
    Some(Step::new(content, changes, after))
}

/// The arrays of a view.
fn targets(frame: &Frame, view: View) -> Vec<Target> {
    let (problem, points) = (&frame.problem, &frame.control_points);
    let dimension = problem.dimension();
    if let View::Samples(grid) = view {
        return vec![target(samples(frame, grid), grid.count(), dimension)];
    }
    let geometry = Geometry::new(problem, points);
    let places = geometry.rows() * geometry.columns().unwrap_or(1);
    let net = || NetPoints {
        problem: Arc::clone(problem),
        control_points: Arc::clone(points),
    };
    let weights = problem.is_homogeneous().then(|| NetWeights(net()));
    let weights = weights.map(|weights| target(weights, places, 1));
    let points = target(net(), places, dimension);
    [Some(points), weights].into_iter().flatten().collect()
}

fn samples(frame: &Frame, grid: Grid) -> Samples {
    let (setup, points) = (frame.problem.setup(), &frame.control_points);
    Samples::new(Arc::clone(setup), Arc::clone(points), grid)
}

/// Returns false if complete events have 64 bits although all shown numbers fit in 32: samples whose control points are
/// too large.
fn fits(frame: &Frame, view: View) -> bool {
    match view {
        View::Samples(grid) => samples(frame, grid).fits_32_bits() != Some(false),
        _ => true,
    }
}

fn target(source: impl Source, places: usize, dimension: usize) -> Target {
    Target {
        places,
        dimension,
        at_once: points_at_once(dimension),
        fill: Box::new(move |start, numbers| source.fill(start, numbers)),
    }
}
