//! Listing, showing, cancelling and deleting jobs.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use prost::Message;
use serde::Deserialize;
use serde_json::json;
use uuid::Uuid;

use super::negotiate::{self, Language};
use super::path::Named;
use super::problem::{Kind, Problem};
use super::short::quoted;
use super::{App, no_store, rpc, view};
use crate::job::Job;
use crate::job::state::State as JobState;
use crate::job::store::Selection;

/// How many jobs a page has if nobody says it.
pub const DEFAULT_PAGE: usize = 50;
/// The most jobs of a page.
pub const LARGEST_PAGE: usize = 1000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListParameters {
    state: Option<String>,
    limit: Option<String>,
    cursor: Option<String>,
}

/// `GET /v1/jobs`
pub async fn list(
    State(app): State<App>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let parameters: ListParameters = negotiate::query(&uri)?;
    let limit = match parameters.limit.as_deref() {
        None => Ok(DEFAULT_PAGE),
        Some(text) => {
            let limit = negotiate::plain_number(text);
            let limit = limit.ok_or_else(|| format!("{} is no whole number", quoted(text)));
            limit.and_then(|limit| check_limit(limit).map(|()| limit))
        }
    };
    let limit = limit.map_err(|detail| Problem::at_parameter("limit", detail))?;
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
    let (jobs, more) = page(&app, state, before, limit).await?;
    if language == Language::Protobuf {
        let page = rpc::view::page(&jobs, more);
        return Ok(message(page.encode_to_vec().into()));
    }
    let next = jobs.last().filter(|_| more).map(|job| {
        let state = state.map_or(String::new(), |state| format!("&state={state}"));
        format!("/v1/jobs?cursor={}&limit={limit}{state}", job.id())
    });
    let jobs: Vec<_> = jobs.iter().map(|job| view::job(job)).collect();
    Ok(no_store(
        Json(json!({"jobs": jobs, "next": next})).into_response(),
    ))
}

/// Says how many jobs a page may have.
pub fn check_limit(limit: usize) -> Result<(), String> {
    match (1..=LARGEST_PAGE).contains(&limit) {
        true => Ok(()),
        false => Err(format!("{limit} does not lie between 1 and {LARGEST_PAGE}")),
    }
}

/// A page of the list, and whether there are more.
pub async fn page(
    app: &App,
    state: Option<JobState>,
    before: Option<Uuid>,
    limit: usize,
) -> Result<(Vec<Arc<Job>>, bool), Problem> {
    let selection = Selection {
        state,
        before,
        // One more tells whether there is a next page.
        limit: limit + 1,
    };
    let mut jobs = app.jobs.list(selection).await?;
    let more = jobs.len() > limit;
    jobs.truncate(limit);
    Ok((jobs, more))
}

/// `GET /v1/jobs/{id}`
pub async fn get(
    State(app): State<App>,
    Named(id): Named<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = find(&app, &id).await?;
    Ok(show(&job, language))
}

/// The job as it stands.
pub fn show(job: &Job, language: Language) -> Response {
    match language {
        Language::Json => no_store(Json(view::job(job)).into_response()),
        Language::Protobuf => message(rpc::view::job(job).encode_to_vec().into()),
    }
}

/// A protobuf message as an answer.
pub fn message(bytes: Bytes) -> Response {
    let content_type = HeaderValue::from_static(negotiate::PROTOBUF);
    no_store(([(header::CONTENT_TYPE, content_type)], bytes).into_response())
}

/// `POST /v1/jobs/{id}/cancel`
pub async fn cancel(
    State(app): State<App>,
    Named(id): Named<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = find(&app, &id).await?;
    end(&job).await?;
    Ok(show(&job, language))
}

/// Cancels a job.
pub async fn end(job: &Job) -> Result<(), Problem> {
    job.request_cancel();
    let status = job.ended().await;
    if status.state == JobState::Cancelled {
        return Ok(());
    }
    let detail = format!("the job has already ended: it is {}", status.state);
    Err(Problem::new(Kind::AlreadyEnded, detail))
}

/// `DELETE /v1/jobs/{id}`
pub async fn delete(
    State(app): State<App>,
    Named(id): Named<String>,
) -> Result<StatusCode, Problem> {
    forget(&app, &id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Deletes a job.
pub async fn forget(app: &App, id: &str) -> Result<(), Problem> {
    let existed = app.jobs.delete(job_id(id)?).await?;
    existed
        .then_some(())
        .ok_or_else(|| Problem::unknown_job(id))
}

/// The job that a path names.
pub async fn find(app: &App, id: &str) -> Result<Arc<Job>, Problem> {
    let job = app.jobs.find(job_id(id)?).await?;
    job.ok_or_else(|| Problem::unknown_job(id))
}

fn job_id(id: &str) -> Result<Uuid, Problem> {
    Uuid::try_parse(id).map_err(|_| Problem::unknown_job(id))
}
