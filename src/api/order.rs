//! Jobs that are asked for, in whatever language: what can be computed, and making it a job.

use std::sync::Arc;

use bytes::Bytes;
use sha2::{Digest, Sha256};

use crate::api::app::App;
use crate::api::language::Framing;
use crate::api::problem::{Kind, Problem, Words};
use crate::config::Config;
use crate::fit::problem as fit;
use crate::fit::system::System;
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::outline::{Label, Parent};
use crate::job::scheduler::WorkLane;
use crate::job::service::creating::Accepted;
use crate::job::store::IdempotencyKey;
use crate::model::edit::{EditSpec, ParentFit};
use crate::model::job::ValidJob;
use crate::model::mistakes::{Mistake, SpecPart};
use crate::model::stream::StreamSpec;
use crate::model::stream::choices::ChoiceMistake;
use crate::model::stream::options::{self, StreamOptions};

/// Bodies up to this size are parsed where they arrive; larger ones on the compute pool.
pub const PARSED_AT_ONCE: usize = 4 * 1024;

/// Problems of up to so many points are edited where the edit arrives.
const EDITED_AT_ONCE: usize = 1000;

/// The most characters of an idempotency key.
pub const LONGEST_KEY: usize = 255;

/// A job that can be made.
pub struct Order {
    label: Label,
    problem: fit::Problem,
    /// The system of a job with the same collocation matrix, if one is at hand.
    similar: Option<Arc<System>>,
}

impl Order {
    /// A new job, from a body of so many bytes.
    pub async fn new(
        app: &App,
        bytes: usize,
        read: impl FnOnce(&Config) -> Result<ValidJob, Problem> + Send + 'static,
    ) -> Result<Self, Problem> {
        let config = Arc::clone(&app.config);
        let valid = compute(app, bytes <= PARSED_AT_ONCE, move || read(&config)).await?;
        Ok(Self {
            label: Label {
                name: valid.name,
                parent: None,
                stream: valid.stream,
            },
            problem: valid.problem,
            similar: None,
        })
    }

    /// A job that starts from the control points of another one.
    pub async fn edit(
        app: &App,
        parent: &Arc<Job>,
        edit: EditSpec,
        words: &impl Words,
    ) -> Result<Self, Problem> {
        let wrong =
            |place, detail: String| Problem::of_mistakes(Mistake::at(place, detail).into(), words);
        let frame = start(parent, edit.iteration).await?;
        let frame = frame.map_err(|detail| wrong(SpecPart::Iteration, detail))?;
        let iteration = frame.level.iteration;
        // Held until the end: points that nobody holds are read from the store again.
        let shared = parent.system().await?;
        let problem = Arc::clone(shared.problem());
        let limits = app.config.limits();
        let levels = parent.status().levels;
        let lambda_min = levels.and_then(|levels| levels.forecast.lambda_min);
        let small = problem.grid().count() <= EDITED_AT_ONCE;
        let label = parent.outline().label.clone();
        let valid = compute(app, small, move || {
            let origin = ParentFit {
                problem: &problem,
                control_points: &frame.control_points,
                lambda_min,
                stream: label.stream.as_deref(),
            };
            Ok(edit.apply(&origin, limits))
        })
        .await?;
        let valid = valid.map_err(|mistakes| Problem::of_mistakes(mistakes, words))?;
        Ok(Self {
            label: Label {
                name: valid.name,
                parent: Some(Parent {
                    id: parent.id(),
                    iteration,
                }),
                stream: valid.stream,
            },
            problem: valid.problem,
            similar: shared.at_hand(),
        })
    }

    /// Whether it is about a surface.
    pub fn is_surface(&self) -> bool {
        self.problem.v().is_some()
    }

    /// Checks that a stream of the job can go like that, before there is a job.
    pub fn check_stream(
        &self,
        request: &StreamSpec,
        framing: Framing,
    ) -> Result<(), ChoiceMistake> {
        let (job, surface) = (self.label.stream.as_deref(), self.is_surface());
        StreamOptions::new(request, job, framing.is_protobuf(), surface)?;
        if framing.is_protobuf() {
            return Ok(());
        }
        options::check_range(request, job, &self.problem)
    }

    /// Makes the job, unless there is one for the same key.
    pub async fn make(self, app: &App, key: Option<IdempotencyKey>) -> Result<Accepted, Problem> {
        let (label, problem, similar) = (self.label, self.problem, self.similar);
        Ok(app.jobs.create(label, problem, similar, key).await?)
    }
}

/// Reads a body of so many bytes.
pub async fn read<T: Send + 'static>(
    app: &App,
    bytes: usize,
    read: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    compute(app, bytes <= PARSED_AT_ONCE, read).await
}

/// Refuses new jobs while the server stops.
pub fn check_open(app: &App) -> Result<(), Problem> {
    if *app.stopping.borrow() {
        return Err(Problem::new(Kind::Stopping, "the server is stopping").retry_after(5));
    }
    Ok(())
}

/// What is wrong with the name of an idempotency key.
pub fn check_key(name: &str) -> Result<(), String> {
    let visible = name.bytes().all(|byte| (b' '..=b'~').contains(&byte));
    if name.is_empty() || name.len() > LONGEST_KEY || !visible {
        return Err(format!(
            "a key has 1 to {LONGEST_KEY} visible ASCII characters and spaces"
        ));
    }
    Ok(())
}

/// The key with a digest of the request: where it went and what it said.
pub async fn key(
    app: &App,
    name: String,
    path: String,
    body: Bytes,
) -> Result<IdempotencyKey, Problem> {
    let small = body.len() <= PARSED_AT_ONCE;
    compute(app, small, move || {
        let digest = Sha256::new()
            .chain_update(path)
            .chain_update([0])
            .chain_update(&body)
            .finalize();
        let digest = digest.into();
        Ok(IdempotencyKey { name, digest })
    })
    .await
}

/// The job that was made for a key before.
pub async fn known(app: &App, key: Option<&IdempotencyKey>) -> Result<Option<Accepted>, Problem> {
    match key {
        None => Ok(None),
        Some(key) => Ok(app.jobs.find_by_key(key).await?),
    }
}

/// The level of the parent that an edit starts from, or why there is none.
async fn start(
    parent: &Arc<Job>,
    iteration: Option<usize>,
) -> Result<Result<Arc<Frame>, String>, Problem> {
    let status = parent.status();
    let Some(reached) = status.levels.map(|levels| levels.last.iteration) else {
        return Ok(Err(format!(
            "the job is {} and has no iteration to start from",
            status.state
        )));
    };
    let k = iteration.unwrap_or(reached);
    if k > reached {
        return Ok(Err(format!(
            "the job is {} at iteration {reached}, before {k}",
            status.state
        )));
    }
    Ok(match Cursor::new(Arc::clone(parent), k).next().await? {
        Next::Frame(frame) => Ok(frame),
        Next::End(status) => Err(format!("the job is {} before iteration {k}", status.state)),
    })
}

/// Computes where the request is handled, or on the compute pool if it is much.
async fn compute<T: Send + 'static>(
    app: &App,
    small: bool,
    function: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    if small {
        function()
    } else {
        let scheduler = &app.jobs.resources().scheduler;
        scheduler.compute(WorkLane::Wire, function).await?
    }
}
