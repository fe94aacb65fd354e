//! Creating, listing, showing, cancelling and deleting jobs.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Deserialize;
use serde_json::json;
use uuid::Uuid;

use super::negotiate::{self, Answer};
use super::options::StreamParameters;
use super::problem::{Kind, Problem};
use super::request::{JobRequest, ValidJob};
use super::strict::Object;
use super::{App, body, events, no_store, view};
use crate::job::Job;
use crate::job::outline::Label;
use crate::job::scheduler::Lane;
use crate::job::service::Accepted;
use crate::job::state::State as JobState;
use crate::job::store::Selection;

/// Bodies up to this size are parsed where they arrive; larger ones on the compute pool.
const PARSED_AT_ONCE: usize = 16 * 1024;

const DEFAULT_PAGE: usize = 50;
const LARGEST_PAGE: usize = 1000;

/// `POST /v1/jobs`
pub async fn create(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    if *app.stopping.borrow() {
        return Err(Problem::new(Kind::Stopping, "the server is stopping").retry_after(5));
    }
    let parameters: StreamParameters = negotiate::query(request.uri())?;
    let headers = request.headers().clone();
    let answer = negotiate::answer(&headers)?;
    let wait = negotiate::wait(&headers)?;
    check_parameters(answer, &parameters)?;
    let body = body::read_json(&app, request).await?;
    let ValidJob { name, problem } = parse(&app, body).await?;
    let options = parameters.options(problem.v().is_some())?;
    let label = Label {
        name,
        ..Label::default()
    };
    let job = match app.jobs.create(label, problem, None).await? {
        Accepted::New(job) | Accepted::Known(job) => job,
    };
    let location = HeaderValue::from_str(&view::path(&job)).ok();

    let mut response = match answer {
        Answer::Events(framing) => events::stream(&app, Arc::clone(&job), framing, options, None),
        Answer::Json => {
            if let Some(wait) = wait {
                // Either way the job is shown as it stands then.
                let _ = tokio::time::timeout(wait, job.ended()).await;
            }
            (StatusCode::CREATED, Json(view::job(&job))).into_response()
        }
    };
    let headers = response.headers_mut();
    headers.extend(location.map(|location| (header::LOCATION, location)));
    if let (Answer::Json, Some(wait)) = (answer, wait) {
        let applied = HeaderValue::from_str(&format!("wait={}", wait.as_secs())).ok();
        let name = header::HeaderName::from_static("preference-applied");
        headers.extend(applied.map(|applied| (name, applied)));
    }
    Ok(response)
}

/// Parses and validates a job; large ones off the threads that serve the network.
async fn parse(app: &App, body: Bytes) -> Result<ValidJob, Problem> {
    let config = Arc::clone(&app.config);
    let small = body.len() <= PARSED_AT_ONCE;
    let parse = move || {
        let Object(request) = body::parse::<Object<JobRequest>>(&body)?;
        request.validate(&config)
    };
    if small {
        parse()
    } else {
        app.jobs
            .resources()
            .scheduler
            .compute(Lane::Heavy, parse)
            .await?
    }
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListParameters {
    state: Option<String>,
    limit: Option<usize>,
    cursor: Option<String>,
}

/// `GET /v1/jobs`
pub async fn list(
    State(app): State<App>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let parameters: ListParameters = negotiate::query(&uri)?;
    let limit = parameters.limit.unwrap_or(DEFAULT_PAGE);
    if !(1..=LARGEST_PAGE).contains(&limit) {
        let detail = format!("{limit} does not lie between 1 and {LARGEST_PAGE}");
        return Err(Problem::at_parameter("limit", detail));
    }
    let state = parameters
        .state
        .map(|name| name.parse::<JobState>())
        .transpose()
        .map_err(|detail| Problem::at_parameter("state", detail))?;
    let before = parameters
        .cursor
        .map(|cursor| Uuid::try_parse(&cursor))
        .transpose()
        .map_err(|_| Problem::at_parameter("cursor", "it is not one that this server gave"))?;
    let selection = Selection {
        state,
        before,
        // One more tells whether there is a next page.
        limit: limit + 1,
    };
    let mut jobs = app.jobs.list(selection).await?;
    let more = jobs.len() > limit;
    jobs.truncate(limit);
    let next = jobs.last().filter(|_| more).map(|job| {
        let state = state.map_or(String::new(), |state| format!("&state={state}"));
        format!("/v1/jobs?cursor={}&limit={limit}{state}", job.id())
    });
    let jobs: Vec<_> = jobs.iter().map(|job| view::job(job)).collect();
    Ok(no_store(
        Json(json!({"jobs": jobs, "next": next})).into_response(),
    ))
}

/// `GET /v1/jobs/{id}`
pub async fn get(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = find(&app, &id).await?;
    Ok(no_store(Json(view::job(&job)).into_response()))
}

/// `POST /v1/jobs/{id}/cancel`
pub async fn cancel(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Problem> {
    let job = find(&app, &id).await?;
    job.request_cancel();
    let status = job.ended().await;
    if status.state == JobState::Cancelled {
        return Ok(no_store(Json(view::job(&job)).into_response()));
    }
    let detail = format!("the job has already ended: it is {}", status.state);
    Err(Problem::new(Kind::AlreadyEnded, detail))
}

/// `DELETE /v1/jobs/{id}`
pub async fn delete(State(app): State<App>, Path(id): Path<String>) -> Result<StatusCode, Problem> {
    let existed = app.jobs.delete(job_id(&id)?).await?;
    if existed {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(Problem::unknown_job(&id))
    }
}

/// The job that a path names.
pub async fn find(app: &App, id: &str) -> Result<Arc<Job>, Problem> {
    let job = app.jobs.find(job_id(id)?).await?;
    job.ok_or_else(|| Problem::unknown_job(id))
}

fn job_id(id: &str) -> Result<Uuid, Problem> {
    Uuid::try_parse(id).map_err(|_| Problem::unknown_job(id))
}
