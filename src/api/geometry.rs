//! Inputs, single iterations, results, and the limits of local fits.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use super::export::{self, Representation};
use super::options::form::{Digits, Encoding, Form, View};
use super::options::{StreamParameters, ViewParameters};
use super::problem::{Kind, Problem};
use super::{App, encode, jobs, negotiate, no_store, view};
use crate::export::Format;
use crate::fit::iteration::Iteration;
use crate::fit::limit::{MOST_ADJUSTED, NoLimit, local_limit};
use crate::fit::points::Grid;
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::scheduler::Lane;
use crate::job::state::Levels;

/// `GET /v1/jobs/{id}/iterations/{k}`
pub async fn iteration(
    State(app): State<App>,
    Path((id, k)): Path<(String, String)>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    let k = match k.as_str() {
        "last" => last_level(&job)?,
        k => level_number(k)?,
    };
    match Cursor::new(Arc::clone(&job), k).next().await? {
        Next::Frame(frame) => match wanted {
            Wanted::Json(form) => Ok(json_response(encode::frame(&job, &frame, &form).await?)),
            Wanted::File(format, samples) => {
                let points = Arc::clone(&frame.control_points);
                export::file(&job, frame.level.iteration, points, format, samples).await
            }
        },
        Next::End(status) => {
            let reached = status.levels.map(|levels| levels.last.iteration);
            let detail = match reached {
                Some(last) => format!(
                    "the job is {} at iteration {last}, before {k}",
                    status.state
                ),
                None => format!("the job is {} before its first iteration", status.state),
            };
            Err(Problem::new(Kind::NoSuchIteration, detail))
        }
    }
}

/// `GET /v1/jobs/{id}/input`: the job as it was accepted.
pub async fn input(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let (owner, problem) = (Arc::clone(&job), job.problem().await?);
    let numbers = problem.data().len() * problem.data().dimension();
    let write = move || view::input(owner.outline(), &problem);
    Ok(json_response(
        encode::off_network(&job, numbers, write).await,
    ))
}

/// `GET /v1/jobs/{id}/result`
pub async fn result(
    State(app): State<App>,
    Path(id): Path<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    let status = job.status();
    let (Some(Levels { last: level, .. }), Some(points)) = (status.levels, job.result().await?)
    else {
        let detail = format!("the job is {} and has no result", status.state);
        return Err(Problem::new(Kind::NoResult, detail));
    };
    let form = match wanted {
        Wanted::Json(form) => form,
        Wanted::File(format, samples) => {
            return export::file(&job, level.iteration, points, format, samples).await;
        }
    };
    if form.digits == Digits::Auto {
        let detail = "a result has all digits; rounded ones are for iterations";
        return Err(Problem::at_parameter("digits", detail));
    }
    if form.view != View::ControlPoints {
        let frame = Arc::new(Frame::last(level, points));
        return Ok(json_response(encode::frame(&job, &frame, &form).await?));
    }
    let (owner, problem) = (Arc::clone(&job), job.problem().await?);
    let numbers = points.len() * points.dimension();
    let json = encode::off_network(&job, numbers, move || {
        view::level::result(&owner, &problem, &status, &level, &points, &form)
    })
    .await;
    Ok(json_response(json))
}

/// `GET /v1/jobs/{id}/limit`: where the difference vectors of the fixed points of a local fit end.
pub async fn limit(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let system = Arc::clone(job.system().await?);
    let compute = move || {
        let start = Iteration::start(system.get());
        local_limit(&start).map(|limit| view::limit(system.problem(), &limit))
    };
    let limit = app
        .jobs
        .resources()
        .scheduler
        .compute(Lane::Heavy, compute)
        .await?;
    limit.map(json_response).map_err(|reason| {
        let detail = match reason {
            NoLimit::NotLocal => "only local fits have points that stay".to_owned(),
            NoLimit::TooMany(count) => format!(
                "{count} points are adjusted; the closed form is computed for up to {MOST_ADJUSTED}"
            ),
            NoLimit::Singular => "the matrix of the adjusted points is singular".to_owned(),
        };
        Problem::new(Kind::NoLimit, detail)
    })
}

/// What a client wants of a level.
enum Wanted {
    Json(Form),
    File(Format, Option<Grid>),
}

async fn job_and_wanted(
    app: &App,
    id: &str,
    uri: &Uri,
    headers: &HeaderMap,
) -> Result<(Arc<Job>, Wanted), Problem> {
    let parameters: ViewParameters = negotiate::query(uri)?;
    let representation = export::representation(headers, parameters.format.as_deref())?;
    let job = jobs::find(app, id).await?;
    if let Representation::File(format) = representation {
        let samples = parameters.samples_of_file(job.outline().surface)?;
        return Ok((job, Wanted::File(format, samples)));
    }
    let parameters = StreamParameters::from(parameters);
    let form = parameters.form(job.outline().surface)?;
    if form.encoding == Encoding::Base64F32 {
        let problem = job.problem().await?;
        parameters.check_range(None, &problem)?;
    }
    Ok((job, Wanted::Json(form)))
}

fn last_level(job: &Job) -> Result<usize, Problem> {
    let status = job.status();
    let levels = status.levels.ok_or_else(|| {
        let detail = format!("the job is {} and has no iteration yet", status.state);
        Problem::new(Kind::NoSuchIteration, detail)
    })?;
    Ok(levels.last.iteration)
}

fn level_number(text: &str) -> Result<usize, Problem> {
    negotiate::plain_number(text).ok_or_else(|| {
        let detail =
            format!("{text:?} is no iteration: they are numbered from 0; there is also \"last\"");
        Problem::new(Kind::NoSuchIteration, detail)
    })
}

fn json_response(json: Bytes) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    no_store(([(header::CONTENT_TYPE, content_type)], json).into_response())
}
