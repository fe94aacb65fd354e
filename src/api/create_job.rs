//! Requests for jobs in any encoding: what can be computed, and creating the job.

use std::sync::Arc;

use bytes::Bytes;
use sha2::{Digest, Sha256};

use crate::api::app::App;
use crate::api::media_type::Framing;
use crate::api::problem::{Kind, Locator, Problem};
use crate::api::start::{Base, start};
use crate::config::Config;
use crate::job::Job;
use crate::job::frame::Frame;
use crate::job::outline::{Label, Parent};
use crate::job::peer::Peer;
use crate::job::scheduler::WorkLane;
use crate::job::service::creating::Accepted;
use crate::job::service::ephemeral::Ephemeral;
use crate::job::service::sessions::SessionTurn;
use crate::job::store::IdempotencyKey;
use crate::model::edit::{EditRequest, ParentFit};
use crate::model::errors::{SpecPart, ValidationError};
use crate::model::iteration::IterationChoice;
use crate::model::job::{JobRequest, Limits};
use crate::model::scattered;
use crate::model::stream::StreamSpec;
use crate::model::stream::choices::ChoiceError;
use crate::model::stream::options::{self, StreamOptions};
use piad_files::export::{self, ExportError, Format};
use piad_fit::engine as fit;
use piad_fit::engine::System;

/// Bodies up to this size are parsed where they arrive; larger ones on the compute pool.
pub(super) const PARSED_AT_ONCE: usize = 16 * 1024;

/// Problems of up to this many points are edited by the replica that receives the edit.
const EDITED_AT_ONCE: usize = 1000;

/// The most characters of an idempotency key.
pub(super) const LONGEST_KEY: usize = 255;

/// A validated job.
pub(super) struct Order {
    label: Label,
    problem: fit::Problem,
    /// The system of a job with the same collocation matrix, if one is in memory.
    similar: Option<Arc<System>>,
}

/// A job that was read from a body.
pub(super) struct ReadJob<W> {
    /// The requested job.
    pub request: JobRequest,
    /// The locations of its parts.
    pub locator: W,
    /// Notices about the file that has its points, in sentences.
    pub notices: Vec<String>,
}

impl<W> From<(JobRequest, W)> for ReadJob<W> {
    fn from((request, locator): (JobRequest, W)) -> Self {
        Self {
            request,
            locator,
            notices: Vec::new(),
        }
    }
}

/// A validated edit.
pub(super) struct EditOrder {
    pub order: Order,
    /// The level of the parent that it starts from.
    before: Arc<Frame>,
    /// Its place in a drag.
    turn: Option<SessionTurn>,
}

impl Order {
    /// A new job, from a body of this many bytes.
    pub(super) async fn new<W: Locator + Send + 'static>(
        app: &App,
        bytes: usize,
        read: impl FnOnce(&Config) -> Result<ReadJob<W>, Problem> + Send + 'static,
    ) -> Result<Self, Problem> {
        let (config, limits) = (Arc::clone(&app.config), limits(app));
        let is_small = bytes <= PARSED_AT_ONCE;
        let ReadJob {
            request,
            locator,
            mut notices,
        } = compute(app, is_small, move || read(&config)).await?;
        let base = Base::of(app, request.base()).await?;
        // Foot points take long even for small jobs.
        let is_short = is_small && !base.is_given();
        let validate = move || base.validate(request, limits, &locator);
        let valid = compute(app, is_short, validate).await?;
        notices.extend(scattered::notices(&valid.problem));
        Ok(Self {
            label: Label {
                name: valid.name,
                parent: None,
                stream: valid.stream,
                notices,
            },
            problem: valid.problem,
            similar: None,
        })
    }

    /// Returns true if it is about a surface.
    pub(super) fn is_surface(&self) -> bool {
        self.problem.v().is_some()
    }

    /// Validates the stream of a job before the job is created.
    pub(super) fn check_stream(
        &self,
        request: &StreamSpec,
        framing: Framing,
    ) -> Result<(), ChoiceError> {
        let (job, surface) = (self.label.stream.as_deref(), self.is_surface());
        StreamOptions::new(request, job, framing.is_protobuf(), surface)?;
        if framing.is_protobuf() {
            return Ok(());
        }
        options::check_range(request, job, &self.problem)
    }

    /// Checks that the result can be written in a format, before the fit begins.
    pub(super) fn check_export(&self, format: Format) -> Result<(), ExportError> {
        export::check(format, &self.problem)
    }

    /// Begins the fit for one answer, without creating a stored job.
    pub(super) async fn begin(
        self,
        app: &App,
        turn: Option<SessionTurn>,
    ) -> Result<Ephemeral, Problem> {
        let (label, problem, similar) = (self.label, self.problem, self.similar);
        Ok(app
            .jobs
            .begin_ephemeral(label, problem, similar, turn)
            .await?)
    }

    /// Creates the job, unless there is one for the same key.
    pub(super) async fn make(
        self,
        app: &App,
        key: Option<IdempotencyKey>,
    ) -> Result<Accepted, Problem> {
        let (label, problem, similar) = (self.label, self.problem, self.similar);
        Ok(app.jobs.create(label, problem, similar, key).await?)
    }
}

impl EditOrder {
    /// A job that starts from the control points of another one.
    pub(super) async fn new(
        app: &App,
        parent: &Arc<Job>,
        edit: EditRequest,
        locator: &impl Locator,
    ) -> Result<Self, Problem> {
        // From here on the previous edit of the same session is obsolete.
        let is_ephemeral = edit.ephemeral == Some(true);
        let session = edit.session.clone().filter(|_| is_ephemeral);
        let turn = session.map(|name| app.jobs.session(parent, name));
        let wrong = |place, detail: String| {
            Problem::of_errors(ValidationError::at(place, detail).into(), locator)
        };
        let iteration = edit.iteration.and_then(IterationChoice::number);
        let frame = start(parent, iteration).await?;
        let frame = frame.map_err(|detail| wrong(SpecPart::Iteration, detail))?;
        let iteration = frame.level.iteration;
        // Held until the end: points without a holder are read from the store again.
        let shared = parent.system().await?;
        if is_ephemeral {
            app.jobs.keep_at_hand(parent, &shared).await?;
        }
        let problem = Arc::clone(&frame.problem);
        let limits = limits(app);
        let levels = parent.status().levels;
        let lambda_min = levels.and_then(|levels| levels.forecast.lambda_min);
        let small = problem.grid().count() <= EDITED_AT_ONCE;
        let label = parent.outline().label.clone();
        let before = Arc::clone(&frame);
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
        let valid = valid.map_err(|errors| Problem::of_errors(errors, locator))?;
        let order = Order {
            label: Label {
                name: valid.name,
                parent: Some(Parent {
                    id: parent.id(),
                    iteration,
                }),
                stream: valid.stream,
                notices: Vec::new(),
            },
            problem: valid.problem,
            similar: shared.at_hand(),
        };
        Ok(Self {
            order,
            before,
            turn,
        })
    }

    /// Begins the fit for one stream, without creating a stored job; also the level of the parent that it starts from,
    /// which the client has.
    pub(super) async fn begin(self, app: &App) -> Result<(Ephemeral, Arc<Frame>), Problem> {
        Ok((self.order.begin(app, self.turn).await?, self.before))
    }
}

/// Refuses an ephemeral edit whose stream is not requested.
pub(super) fn no_stream(locator: &impl Locator) -> Problem {
    let detail = "an ephemeral edit exists only as a stream: request one with POST /v1/jobs/{id}/edits/stream or the Accept header";
    Problem::of_errors(
        ValidationError::at(SpecPart::Ephemeral, detail).into(),
        locator,
    )
}

/// Reads a body of this many bytes.
pub(super) async fn read<T: Send + 'static>(
    app: &App,
    bytes: usize,
    read: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    compute(app, bytes <= PARSED_AT_ONCE, read).await
}

/// Refuses new jobs while the server stops.
pub(super) fn check_open(app: &App) -> Result<(), Problem> {
    if *app.stopping.borrow() {
        return Err(stopping());
    }
    Ok(())
}

/// The server stops.
pub(super) fn stopping() -> Problem {
    Problem::new(Kind::Stopping, "the server is stopping").retry_after(5)
}

/// The error for an invalid idempotency key.
pub(super) fn check_key(name: &str) -> Result<(), String> {
    let visible = name.bytes().all(|byte| (b' '..=b'~').contains(&byte));
    if name.is_empty() || name.len() > LONGEST_KEY || !visible {
        return Err(format!(
            "a key has 1 to {LONGEST_KEY} visible ASCII characters and spaces"
        ));
    }
    Ok(())
}

/// The key with a digest of the request: its route and its body. Each peer has a key space of its own, so that peers
/// cannot block each other's keys.
pub(super) async fn key(
    app: &App,
    name: String,
    path: String,
    body: Bytes,
) -> Result<IdempotencyKey, Problem> {
    let small = body.len() <= PARSED_AT_ONCE;
    let peer = Peer::current();
    compute(app, small, move || {
        let digest = Sha256::new()
            .chain_update(path)
            .chain_update([0])
            .chain_update(&body)
            .finalize();
        let digest = digest.into();
        Ok(IdempotencyKey::new(peer, &name, digest))
    })
    .await
}

/// The job that was made for a key before.
pub(super) async fn known(
    app: &App,
    key: Option<&IdempotencyKey>,
) -> Result<Option<Accepted>, Problem> {
    match key {
        None => Ok(None),
        Some(key) => Ok(app.jobs.find_by_key(key).await?),
    }
}

/// The largest jobs that are accepted.
pub(super) fn limits(app: &App) -> Limits {
    Limits {
        admission: app.jobs.admission(),
        ..app.config.limits()
    }
}

/// Computes where the request is handled, or on the compute pool if it takes long.
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
