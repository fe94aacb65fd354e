//! Listing, showing, cancelling and deleting jobs.

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use prost::Message;
use serde::Deserialize;
use uuid::Uuid;

use super::answer::{no_store, whole};
use super::negotiate;
use super::path::InPath;
use crate::api::app::App;
use crate::api::json::view::job::{JobPage, JobView};
use crate::api::media_type::{Language, PROTOBUF};
use crate::api::parse_uint::plain_number;
use crate::api::problem::Problem;
use crate::api::{jobs, proto};
use crate::job::Job;
use crate::job::state::State as JobState;
use piad_files::text::quoted;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListParameters {
    state: Option<String>,
    limit: Option<String>,
    cursor: Option<String>,
}

/// `GET /v1/jobs`
pub(super) async fn list(
    State(app): State<App>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let parameters: ListParameters = negotiate::query(&uri)?;
    let limit = match parameters.limit.as_deref() {
        None => Ok(jobs::DEFAULT_PAGE),
        Some(text) => {
            let limit = plain_number(text);
            let limit = limit.ok_or_else(|| format!("{} is not a whole number", quoted(text)));
            limit.and_then(|limit| jobs::check_limit(limit).map(|()| limit))
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
        .map_err(|_| Problem::at_parameter("cursor", "it is not from this server"))?;
    let (jobs, more) = jobs::page(&app, state, before, limit).await?;
    if language == Language::Protobuf {
        let page = proto::view::page(&jobs, more);
        return Ok(whole(page.encode_to_vec(), PROTOBUF));
    }
    let next = jobs.last().filter(|_| more).map(|job| {
        let state = state.map_or(String::new(), |state| format!("&state={state}"));
        let base = app.config.base_path.as_str();
        format!("{base}/v1/jobs?cursor={}&limit={limit}{state}", job.id())
    });
    let jobs = jobs.iter().map(|job| JobView::new(job)).collect();
    Ok(no_store(Json(JobPage { jobs, next }).into_response()))
}

/// `GET /v1/jobs/{id}`
pub(super) async fn get(
    State(app): State<App>,
    InPath(id): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = jobs::find(&app, &id).await?;
    Ok(show(&job, language))
}

/// The job in its current state.
pub(super) fn show(job: &Job, language: Language) -> Response {
    match language {
        Language::Json => no_store(Json(JobView::new(job)).into_response()),
        Language::Protobuf => whole(proto::view::job(job).encode_to_vec(), PROTOBUF),
    }
}

/// `POST /v1/jobs/{id}/cancel`
pub(super) async fn cancel(
    State(app): State<App>,
    InPath(id): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = jobs::find(&app, &id).await?;
    jobs::end(&job).await?;
    Ok(show(&job, language))
}

/// `DELETE /v1/jobs/{id}`
pub(super) async fn delete(
    State(app): State<App>,
    InPath(id): InPath<String>,
) -> Result<StatusCode, Problem> {
    jobs::forget(&app, &id).await?;
    Ok(StatusCode::NO_CONTENT)
}
