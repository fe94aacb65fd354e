//! Inputs, single iterations, results, and the limits of local fits.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use super::export::{self, Representation};
use super::file_name::named;
use super::negotiate::{self, Language};
use super::options::form::{Digits, Encoding, Form, View};
use super::options::{StreamParameters, ViewParameters};
use super::path::Named;
use super::problem::{Kind, Problem};
use super::sending::answer;
use super::short::quoted;
use super::{App, encode, jobs, no_store, rpc, view};
use crate::export::Format;
use crate::fit::iteration::{Iteration, Level};
use crate::fit::limit::{LIMIT_COST, MOST_ADJUSTED, NoLimit, local_limit};
use crate::fit::points::{Grid, Points};
use crate::job::Job;
use crate::job::content::Content;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::scheduler::Lane;
use crate::job::state::{Levels, Status};

/// Bytes of a data point of an input with all that is given for it.
const BYTES_PER_POINT: usize = 160;

/// `GET /v1/jobs/{id}/iterations/{k}`
pub async fn iteration(
    State(app): State<App>,
    Named((id, k)): Named<(String, String)>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    let k = match k.as_str() {
        "last" => None,
        k => Some(level_number(k)?),
    };
    let frame = frame(&job, k).await?;
    match wanted {
        Wanted::Form(form) => {
            let content = encode::frame(&job, &frame, &form).await?;
            Ok(answer(&job, content, media_type(&form)))
        }
        Wanted::File(format, samples) => {
            let (level, points) = (frame.level.iteration, Arc::clone(&frame.control_points));
            let file = export::file(&job, level, points, format, samples).await?;
            Ok(named(file, job.outline(), Some(level), format))
        }
    }
}

/// The frame of a level; without a number that of the last level so far.
pub async fn frame(job: &Arc<Job>, k: Option<usize>) -> Result<Arc<Frame>, Problem> {
    let k = match k {
        None => last_level(job)?,
        Some(k) => k,
    };
    match Cursor::new(Arc::clone(job), k).next().await? {
        Next::Frame(frame) => Ok(frame),
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
    Named(id): Named<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let content = input_content(&job, language).await?;
    Ok(answer(&job, content, language.media_type()))
}

/// The job as it was accepted, as JSON or as the bytes of a message.
pub async fn input_content(job: &Arc<Job>, language: Language) -> Result<Content, Problem> {
    // It is made as a whole.
    let room = &job.resources().memory.files;
    let permit = room
        .take(job.outline().grid.count() * BYTES_PER_POINT)
        .await;
    let (owner, problem) = (Arc::clone(job), job.problem().await?);
    let numbers = problem.data().len() * problem.data().dimension();
    let write = move || match language {
        Language::Json => view::input(owner.outline(), &problem).into(),
        Language::Protobuf => rpc::input::input(owner.outline(), &problem).into(),
    };
    let content = encode::off_network(job, numbers, write).await?;
    Ok(content.with_permit(permit))
}

/// `GET /v1/jobs/{id}/result`
pub async fn result(
    State(app): State<App>,
    Named(id): Named<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    match wanted {
        Wanted::Form(form) if form.digits == Digits::Auto => {
            let detail = "a result has all digits; rounded ones are for iterations";
            Err(Problem::at_parameter("digits", detail))
        }
        Wanted::Form(form) => {
            let content = result_content(&job, form.clone()).await?;
            Ok(answer(&job, content, media_type(&form)))
        }
        Wanted::File(format, samples) => {
            let (_, level, points) = end(&job).await?;
            let file = export::file(&job, level.iteration, points, format, samples).await?;
            Ok(named(file, job.outline(), None, format))
        }
    }
}

/// The last level of a job that has ended.
async fn end(job: &Job) -> Result<(Status, Level, Arc<Points>), Problem> {
    let status = job.status();
    match (status.levels, job.result().await?) {
        (Some(Levels { last, .. }), Some(points)) => Ok((status, last, points)),
        _ => {
            let detail = format!("the job is {} and has no result", status.state);
            Err(Problem::new(Kind::NoResult, detail))
        }
    }
}

/// The final geometry in a form, as JSON or as the bytes of a message.
pub async fn result_content(job: &Arc<Job>, form: Form) -> Result<Content, Problem> {
    let (status, level, points) = end(job).await?;
    if form.view != View::ControlPoints && !form.is_protobuf() {
        let frame = Arc::new(Frame::last(level, points));
        return Ok(encode::frame(job, &frame, &form).await?);
    }
    let (owner, problem) = (Arc::clone(job), job.problem().await?);
    let numbers = points.len() * points.dimension();
    let write = move || match form.is_protobuf() {
        false => view::level::result(&owner, &problem, &status, &level, &points, &form),
        true => rpc::geometry::result(&owner, &problem, &status, &level, &points, form.view),
    };
    Ok(encode::off_network(job, numbers, write).await?)
}

/// `GET /v1/jobs/{id}/limit`: where the difference vectors of the fixed points of a local fit end.
pub async fn limit(
    State(app): State<App>,
    Named(id): Named<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let system = job.system().await?;
    let compute = move || {
        let start = Iteration::start(system.get());
        local_limit(&start).map(|limit| view::limit(system.problem(), &limit))
    };
    let limit = app
        .jobs
        .resources()
        .scheduler
        .compute(Lane::Long(LIMIT_COST), compute)
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
    Form(Form),
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
    let surface = job.outline().surface;
    if let Representation::File(format) = representation {
        let samples = parameters.samples_of_file(surface)?;
        return Ok((job, Wanted::File(format, samples)));
    }
    let parameters = StreamParameters::from(parameters);
    let form = match representation {
        Representation::Protobuf => parameters.message_form(surface)?,
        _ => parameters.form(surface)?,
    };
    if form.encoding == Encoding::Base64F32 {
        let problem = job.problem().await?;
        parameters.check_range(None, &problem)?;
    }
    Ok((job, Wanted::Form(form)))
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
        let detail = format!(
            "{} is no iteration: they are numbered from 0; there is also \"last\"",
            quoted(text)
        );
        Problem::new(Kind::NoSuchIteration, detail)
    })
}

fn media_type(form: &Form) -> &'static str {
    match form.is_protobuf() {
        false => Language::Json.media_type(),
        true => Language::Protobuf.media_type(),
    }
}

fn json_response(json: Bytes) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    no_store(([(header::CONTENT_TYPE, content_type)], json).into_response())
}
