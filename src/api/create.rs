//! New jobs: posted ones, and edits of others.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use sha2::{Digest, Sha256};
use tokio::time::Duration;

use super::negotiate::{self, Answer};
use super::options::StreamParameters;
use super::options::form::Encoding;
use super::options::object::StreamObject;
use super::problem::{Kind, Problem};
use super::request::edit::EditRequest;
use super::request::{JobRequest, ValidJob};
use super::strict::Object;
use super::{App, body, events, jobs, no_store, view};
use crate::fit::problem as fit;
use crate::fit::system::System;
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::outline::{Label, Parent};
use crate::job::scheduler::Lane;
use crate::job::service::Accepted;
use crate::job::store::Key;

/// Bodies up to this size are parsed where they arrive; larger ones on the compute pool.
const PARSED_AT_ONCE: usize = 16 * 1024;

/// Problems of up to so many points are edited where the edit arrives.
const EDITED_AT_ONCE: usize = 1000;

const IDEMPOTENCY_KEY: &str = "idempotency-key";
const REPLAYED: HeaderName = HeaderName::from_static("idempotency-replayed");
const LONGEST_KEY: usize = 255;

/// `POST /v1/jobs`
pub async fn job(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let posted = Posted::read(&app, request).await?;
    if let Some(known) = posted.known(&app).await? {
        return posted.answer(&app, known).await;
    }
    let config = Arc::clone(&app.config);
    let bytes = posted.body.clone();
    let small = bytes.len() <= PARSED_AT_ONCE;
    let ValidJob {
        name,
        stream,
        problem,
    } = compute(&app, small, move || {
        let Object(request) = body::parse::<Object<JobRequest>>(&bytes)?;
        request.validate(&config)
    })
    .await?;
    let label = Label {
        name,
        parent: None,
        stream,
    };
    posted.create(&app, label, problem, None).await
}

/// `POST /v1/jobs/{id}/edits`: a new job that starts from the control points of another one.
pub async fn edit(
    State(app): State<App>,
    Path(id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let parent = jobs::find(&app, &id).await?;
    let posted = Posted::read(&app, request).await?;
    if let Some(known) = posted.known(&app).await? {
        return posted.answer(&app, known).await;
    }
    let Object(mut request) = body::parse::<Object<EditRequest>>(&posted.body)?;
    request.inherit(StreamObject::of(&parent.outline().label)?);
    let frame = start(&parent, request.iteration()).await?;
    let iteration = frame.level.iteration;
    let (config, problem) = (Arc::clone(&app.config), parent.problem().await?);
    let levels = parent.status().levels;
    let lambda_min = levels.and_then(|levels| levels.forecast.lambda_min);
    let small = problem.grid().count() <= EDITED_AT_ONCE;
    let ValidJob {
        name,
        stream,
        problem,
    } = compute(&app, small, move || {
        request.apply(&problem, &frame.control_points, lambda_min, &config)
    })
    .await?;
    let label = Label {
        name,
        parent: Some(Parent {
            id: parent.id(),
            iteration,
        }),
        stream,
    };
    let like = parent.system().await?.at_hand();
    posted.create(&app, label, problem, like).await
}

/// The level of the parent that an edit starts from.
async fn start(parent: &Arc<Job>, iteration: Option<usize>) -> Result<Arc<Frame>, Problem> {
    let status = parent.status();
    let wrong = |detail| Problem::at_pointer(Kind::InvalidFit, "/iteration".to_owned(), detail);
    let Some(reached) = status.levels.map(|levels| levels.last.iteration) else {
        let detail = format!(
            "the job is {} and has no iteration to start from",
            status.state
        );
        return Err(wrong(detail));
    };
    let k = iteration.unwrap_or(reached);
    if k > reached {
        let detail = format!(
            "the job is {} at iteration {reached}, before {k}",
            status.state
        );
        return Err(wrong(detail));
    }
    match Cursor::new(Arc::clone(parent), k).next().await? {
        Next::Frame(frame) => Ok(frame),
        Next::End(status) => Err(wrong(format!(
            "the job is {} before iteration {k}",
            status.state
        ))),
    }
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
        scheduler.compute(Lane::Heavy, function).await?
    }
}

/// A request for a new job.
struct Posted {
    answer: Answer,
    wait: Option<Duration>,
    parameters: StreamParameters,
    key: Option<Key>,
    body: Bytes,
}

impl Posted {
    async fn read(app: &App, request: Request) -> Result<Self, Problem> {
        if *app.stopping.borrow() {
            return Err(Problem::new(Kind::Stopping, "the server is stopping").retry_after(5));
        }
        let parameters: StreamParameters = negotiate::query(request.uri())?;
        let headers = request.headers();
        let answer = negotiate::answer(headers)?;
        let wait = negotiate::wait(headers)?;
        check_parameters(answer, &parameters)?;
        let name = idempotency_key(headers)?;
        let path = request.uri().path().to_owned();
        let body = body::read_json(app, request).await?;
        let key = match name {
            None => None,
            Some(name) => Some(key(app, name, path, body.clone()).await?),
        };
        Ok(Self {
            answer,
            wait,
            parameters,
            key,
            body,
        })
    }

    /// The job that was made for the key of this request before.
    async fn known(&self, app: &App) -> Result<Option<Accepted>, Problem> {
        match &self.key {
            None => Ok(None),
            Some(key) => Ok(app.jobs.made_for(key).await?),
        }
    }

    async fn create(
        mut self,
        app: &App,
        label: Label,
        problem: fit::Problem,
        like: Option<Arc<System>>,
    ) -> Result<Response, Problem> {
        // What is wrong with the parameters is said before there is a job.
        let stream = StreamObject::of(&label)?;
        self.parameters
            .options(stream.as_ref(), problem.v().is_some())?;
        self.parameters.check_range(stream.as_ref(), &problem)?;
        self.body = Bytes::new();
        let accepted = app
            .jobs
            .create(label, problem, like, self.key.clone())
            .await?;
        self.answer(app, accepted).await
    }

    async fn answer(self, app: &App, accepted: Accepted) -> Result<Response, Problem> {
        let (job, known) = match accepted {
            Accepted::New(job) => (job, false),
            Accepted::Known(job) => (job, true),
        };
        let mut response = match self.answer {
            Answer::Events(framing) => {
                let stream = StreamObject::of(&job.outline().label)?;
                let options = self
                    .parameters
                    .options(stream.as_ref(), job.outline().surface)?;
                // With a new job it was checked before there was one.
                if known && options.form.encoding == Encoding::Base64F32 {
                    let problem = job.problem().await?;
                    self.parameters.check_range(stream.as_ref(), &problem)?;
                }
                events::stream(app, Arc::clone(&job), framing, options, None)
            }
            Answer::Json => {
                if let Some(wait) = self.wait {
                    let mut stopping = app.stopping.clone();
                    // However the wait ends, the job is shown as it stands then.
                    tokio::select! {
                        _ = job.ended() => {}
                        () = tokio::time::sleep(wait) => {}
                        _ = stopping.wait_for(|stopping| *stopping) => {}
                    }
                }
                no_store((StatusCode::CREATED, Json(view::job(&job))).into_response())
            }
        };
        let headers = response.headers_mut();
        let location = HeaderValue::from_str(&view::path(&job)).ok();
        headers.extend(location.map(|location| (header::LOCATION, location)));
        if known {
            headers.insert(REPLAYED, HeaderValue::from_static("true"));
        }
        if let (Some(wait), Answer::Json) = (self.wait, self.answer) {
            let applied = HeaderValue::from_str(&format!("wait={}", wait.as_secs())).ok();
            let name = HeaderName::from_static("preference-applied");
            headers.extend(applied.map(|applied| (name, applied)));
        }
        Ok(response)
    }
}

/// The key by which a client recognises its request.
fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get(IDEMPOTENCY_KEY) else {
        return Ok(None);
    };
    let key = value.to_str().unwrap_or("");
    if key.is_empty() || key.len() > LONGEST_KEY {
        let detail = format!("a key has 1 to {LONGEST_KEY} visible ASCII characters");
        return Err(Problem::at_header("Idempotency-Key", detail));
    }
    Ok(Some(key.to_owned()))
}

/// The key with a digest of the request.
async fn key(app: &App, name: String, path: String, body: Bytes) -> Result<Key, Problem> {
    let small = body.len() <= PARSED_AT_ONCE;
    compute(app, small, move || {
        let digest = Sha256::new()
            .chain_update(path)
            .chain_update([0])
            .chain_update(&body)
            .finalize();
        let digest = digest.into();
        Ok(Key { name, digest })
    })
    .await
}

/// The parameters are about the stream, and about one that starts at the beginning.
fn check_parameters(answer: Answer, parameters: &StreamParameters) -> Result<(), Problem> {
    let refused = match answer {
        Answer::Json => parameters.given(),
        Answer::Events(_) => parameters.last_event_id.as_ref().map(|_| "last_event_id"),
    };
    match refused {
        None => Ok(()),
        Some("last_event_id") => Err(Problem::at_parameter(
            "last_event_id",
            "a new job has no events yet",
        )),
        Some(name) => Err(Problem::at_parameter(
            name,
            "it is about event streams, but the Accept header does not ask for one",
        )),
    }
}
