//! Creating jobs: posted ones, and edits of others.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use tokio::time::Duration;

use super::body_limits::{ReceivedBody, Room};
use super::negotiate::{self, Answer};
use super::path::InPath;
use super::points::Fields;
use super::query::{OF_STREAMS, StreamQuery};
use super::{body, events, jobs as shown};
use crate::api::app::App;
use crate::api::create_job;
use crate::api::create_job::{EditOrder, Order};
use crate::api::jobs;
use crate::api::json;
use crate::api::json::view::job::path;
use crate::api::media_type::{Framing, Language};
use crate::api::problem::{Locator, Problem};
use crate::api::proto;
use crate::api::proto::bounds::Bounded;
use crate::api::resume::Start;
use crate::api::stream::feed::Feed;
use crate::config::Config;
use crate::job::quota::OpenStream;
use crate::job::service::creating::Accepted;
use crate::job::store::IdempotencyKey;
use crate::model::edit::EditRequest;
use crate::model::stream::form::Encoding;
use crate::model::stream::options::{self, StreamOptions};
use crate::proto::messages as pb;

const IDEMPOTENCY_KEY: &str = "idempotency-key";
const REPLAYED: HeaderName = HeaderName::from_static("idempotency-replayed");

/// `POST /v1/jobs`
pub(super) async fn job(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    post_job(app, request, negotiate::answer).await
}

/// `POST /v1/jobs/stream`: the same, answered with the events of the job.
pub(super) async fn job_stream(
    State(app): State<App>,
    request: Request,
) -> Result<Response, Problem> {
    post_job(app, request, events_only).await
}

/// Chooses an answer by the headers of a request.
type Choice = fn(&HeaderMap) -> Result<Answer, Problem>;

fn events_only(headers: &HeaderMap) -> Result<Answer, Problem> {
    negotiate::framing(headers).map(Answer::Events)
}

async fn post_job(app: App, request: Request, choice: Choice) -> Result<Response, Problem> {
    let fields = Fields::of_points(&request, &OF_STREAMS)?;
    let fields_of = fields.as_ref();
    let mut posted = Posted::read::<pb::JobInput>(&app, request, choice, fields_of).await?;
    if let Some(known) = create_job::known(&app, posted.key.as_ref()).await? {
        return posted.answer(&app, known, None).await;
    }
    let (language, body, room) = posted.take_body();
    let order = order(&app, language, body, fields.map(|(_, fields)| fields)).await?;
    drop(room);
    posted.create(&app, order).await
}

/// The job of a body; with fields, the body has its points.
pub(super) async fn order(
    app: &App,
    language: Language,
    body: Bytes,
    fields: Option<Fields>,
) -> Result<Order, Problem> {
    let length = body.len();
    match (language, fields) {
        (_, Some(fields)) => {
            let read = move |config: &Config| fields.job(&body, config);
            Order::new(app, length, read).await
        }
        (Language::Json, None) => {
            let read = move |config: &Config| {
                json::request::job::read(body, config.max_points).map(Into::into)
            };
            Order::new(app, length, read).await
        }
        (Language::Protobuf, None) => {
            let read = move |config: &Config| proto::request::read(body, config).map(Into::into);
            Order::new(app, length, read).await
        }
    }
}

/// `POST /v1/jobs/{id}/edits`: a new job that starts from the control points of another one.
pub(super) async fn edit(
    State(app): State<App>,
    InPath(id): InPath<String>,
    request: Request,
) -> Result<Response, Problem> {
    post_edit(app, id, request, negotiate::answer).await
}

/// `POST /v1/jobs/{id}/edits/stream`: the same, answered with the events of the new job.
pub(super) async fn edit_stream(
    State(app): State<App>,
    InPath(id): InPath<String>,
    request: Request,
) -> Result<Response, Problem> {
    post_edit(app, id, request, events_only).await
}

async fn post_edit(
    app: App,
    id: String,
    request: Request,
    choice: Choice,
) -> Result<Response, Problem> {
    let mut posted = Posted::read::<pb::Edit>(&app, request, choice, None).await?;
    // Before the parent is looked up, which may have been deleted.
    if let Some(known) = create_job::known(&app, posted.key.as_ref()).await? {
        return posted.answer(&app, known, None).await;
    }
    let parent = jobs::find(&app, &id).await?;
    let (language, body, room) = posted.take_body();
    let (length, owner) = (body.len(), Arc::clone(&parent));
    let (framing, edit) = match language {
        Language::Json => {
            let read = move || json::request::edit::read(body, owner.outline());
            let (edit, places) = create_job::read(&app, length, read).await?;
            let framing = posted.ephemeral(&edit, &places)?;
            (framing, EditOrder::new(&app, &parent, edit, &places).await?)
        }
        Language::Protobuf => {
            let read = move || {
                let outline = owner.outline();
                let message = proto::request::decode(body, outline.grid.count())?;
                proto::edit::edit(message, outline)
            };
            let (edit, layout) = create_job::read(&app, length, read).await?;
            let framing = posted.ephemeral(&edit, &layout)?;
            (framing, EditOrder::new(&app, &parent, edit, &layout).await?)
        }
    };
    drop(room);
    match framing {
        None => posted.create(&app, edit.order).await,
        Some(framing) => posted.stream(&app, edit, framing).await,
    }
}

/// A request for a new job.
struct Posted {
    answer: Answer,
    wait: Option<Duration>,
    query: StreamQuery,
    key: Option<IdempotencyKey>,
    language: Language,
    body: ReceivedBody,
}

impl Posted {
    /// Reads a request with such a message; the points of a job may be its body, and these its fields.
    async fn read<M: Bounded>(
        app: &App,
        request: Request,
        choice: Choice,
        fields: Option<&(StreamQuery, Fields)>,
    ) -> Result<Self, Problem> {
        create_job::check_open(app)?;
        let query: StreamQuery = match fields {
            None => negotiate::query(request.uri())?,
            Some((query, _)) => query.clone(),
        };
        let headers = request.headers();
        let answer = choice(headers)?;
        let wait = negotiate::wait(headers)?;
        check_query(answer, &query)?;
        let name = idempotency_key(headers)?;
        // A job and its events have the same idempotency key.
        let path = request.uri().path();
        let path = path.strip_suffix("/stream").unwrap_or(path).to_owned();
        let path = fields.map_or(path.clone(), |(_, fields)| {
            format!("{path}?{}", fields.text())
        });
        let (language, body) = match fields {
            None => body::read::<M>(app, request).await?,
            Some(_) => (Language::Json, body::read_points(app, request, 0).await?),
        };
        let key = match name {
            None => None,
            Some(name) => Some(create_job::key(app, name, path, body.bytes.clone()).await?),
        };
        Ok(Self {
            answer,
            wait,
            query,
            key,
            language,
            body,
        })
    }

    /// Takes out the body and the memory that it holds, so that both are freed once it is read.
    fn take_body(&mut self) -> (Language, Bytes, Room) {
        let bytes = std::mem::take(&mut self.body.bytes);
        (self.language, bytes, std::mem::take(&mut self.body.room))
    }

    /// The form of the stream of an ephemeral edit; `None` for an edit that creates a job.
    fn ephemeral(
        &self,
        edit: &EditRequest,
        locator: &impl Locator,
    ) -> Result<Option<Framing>, Problem> {
        if edit.ephemeral != Some(true) {
            return Ok(None);
        }
        let Answer::Events(framing) = self.answer else {
            return Err(create_job::no_stream(locator));
        };
        if self.key.is_some() {
            let detail = "an ephemeral edit is not kept, so that there is nothing to find by a key";
            return Err(Problem::at_header("Idempotency-Key", detail));
        }
        Ok(Some(framing))
    }

    async fn create(self, app: &App, order: Order) -> Result<Response, Problem> {
        let spec = self.query.spec(order.is_surface())?;
        let stream = match self.answer {
            Answer::Events(framing) => {
                order.check_stream(&spec, framing)?;
                // Before the job is made: an ephemeral edit needs its stream.
                Some(app.open_stream()?)
            }
            Answer::Job(_) => None,
        };
        let accepted = order.make(app, self.key.clone()).await?;
        self.answer(app, accepted, stream).await
    }

    /// The events of an ephemeral edit, which has no other resource.
    async fn stream(
        self,
        app: &App,
        edit: EditOrder,
        framing: Framing,
    ) -> Result<Response, Problem> {
        let surface = edit.order.is_surface();
        let spec = self.query.spec(surface)?;
        edit.order.check_stream(&spec, framing)?;
        let (begun, before) = edit.begin(app).await?;
        let defaults = begun.job.outline().label.stream.clone();
        let options =
            StreamOptions::new(&spec, defaults.as_deref(), framing.is_protobuf(), surface)?;
        Ok(events::stream(
            framing,
            Feed::of_ephemeral(app, begun, before, options),
        ))
    }

    async fn answer(
        self,
        app: &App,
        accepted: Accepted,
        stream: Option<OpenStream>,
    ) -> Result<Response, Problem> {
        let Accepted { job, replayed } = accepted;
        let mut response = match self.answer {
            Answer::Events(framing) => {
                let outline = job.outline();
                let (defaults, surface) = (outline.label.stream.as_deref(), outline.surface);
                let spec = self.query.spec(surface)?;
                let mut options =
                    StreamOptions::new(&spec, defaults, framing.is_protobuf(), surface)?;
                // A job that was created before has its own stream; only that one may cancel it.
                options.cancels &= !replayed;
                // For new jobs this was checked before they were created.
                if replayed && options.form.encoding == Encoding::Base64F32 {
                    let problem = job.problem().await?;
                    options::check_range(&spec, defaults, &problem)?;
                }
                let stream = stream.map_or_else(|| app.open_stream(), Ok)?;
                let held = job.held().await?;
                let feed = Feed::new(app, Arc::clone(&job), options, Start::First, held, stream);
                events::stream(framing, feed)
            }
            Answer::Job(language) => {
                if let Some(wait) = self.wait {
                    // Whichever comes first, the job is shown in its state then.
                    tokio::select! {
                        _ = job.ended() => {}
                        () = tokio::time::sleep(wait) => {}
                        () = app.stopped() => {}
                    }
                }
                (StatusCode::CREATED, shown::show(&job, language)).into_response()
            }
        };
        let headers = response.headers_mut();
        let location = HeaderValue::from_str(&path(&job)).ok();
        headers.extend(location.map(|location| (header::LOCATION, location)));
        if replayed {
            headers.insert(REPLAYED, HeaderValue::from_static("true"));
        }
        if let Answer::Job(_) = self.answer {
            negotiate::waited(headers, self.wait);
        }
        Ok(response)
    }
}

/// The idempotency key of a request, if it has one.
fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get(IDEMPOTENCY_KEY) else {
        return Ok(None);
    };
    let key = value.to_str().unwrap_or("");
    create_job::check_key(key).map_err(|detail| Problem::at_header("Idempotency-Key", detail))?;
    Ok(Some(key.to_owned()))
}

/// Refuses parameters of streams where no stream was requested, and a resume point of a new stream.
fn check_query(answer: Answer, query: &StreamQuery) -> Result<(), Problem> {
    let refused = match answer {
        Answer::Job(_) => query.given(),
        Answer::Events(_) => query.last_event_id.as_ref().map(|_| "last_event_id"),
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
