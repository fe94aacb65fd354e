//! Inputs, single iterations, results, and the limits of local fits.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, Uri};
use axum::response::Response;

use super::answer::{answer, whole};
use super::export::{self, Representation};
use super::file_name::{Part, named};
use super::negotiate;
use super::path::InPath;
use super::query::{DeviationQuery, IterationQuery, ShapeQuery};
use crate::api::app::App;
use crate::api::content;
use crate::api::jobs;
use crate::api::json::view::deviation::DeviationView;
use crate::api::json::view::limit::LimitView;
use crate::api::json::view::to_bytes;
use crate::api::media_type::{JSON, Language};
use crate::api::parse_uint::plain_number;
use crate::api::problem::{Kind, Problem};
use crate::api::stream::encode;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::scheduler::WorkLane;
use crate::model::stream::form::{Digits, Encoding, Form};
use crate::model::stream::options;
use piad_files::export::{Format, Options, UnknownFormat};
use piad_files::text::quoted;
use piad_fit::engine::Iteration;
use piad_fit::engine::limit::{LIMIT_COST, MOST_ADJUSTED, NoLimit, local_limit};

/// `GET /v1/jobs/{id}/iterations/{k}`
pub(super) async fn iteration(
    State(app): State<App>,
    InPath((id, k)): InPath<(String, String)>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    show_iteration(&app, &job, &k, &headers, wanted).await
}

/// `GET /v1/jobs/{id}/iterations/{k}/{format}`
pub(super) async fn iteration_file(
    State(app): State<App>,
    InPath((id, k, format)): InPath<(String, String, String)>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, file) = job_and_file(&app, &id, &format, &uri).await?;
    show_iteration(&app, &job, &k, &headers, file).await
}

async fn show_iteration(
    app: &App,
    job: &Arc<Job>,
    k: &str,
    headers: &HeaderMap,
    wanted: Wanted,
) -> Result<Response, Problem> {
    let wait = negotiate::wait(headers)?;
    let frame = content::frame(app, job, level(k)?, wait).await?;
    let part = Part::Iteration(frame.level.iteration);
    let (mut answer, extension) = match wanted {
        Wanted::Form(form) => {
            let content = encode::frame(job, &frame, &form.with_knots()).await?;
            let language = language(&form);
            let answer = answer(job, content, language.media_type());
            (answer, language.extension())
        }
        Wanted::File(format, options) => {
            let file = export::file(job, frame, format, options).await?;
            (file, format.extension())
        }
    };
    negotiate::waited(answer.headers_mut(), wait);
    Ok(named(answer, job.outline(), part, extension))
}

/// `GET /v1/jobs/{id}/input`: the job as it was accepted.
pub(super) async fn input(
    State(app): State<App>,
    InPath(id): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let language = negotiate::language(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let content = content::input_content(&job, language).await?;
    let answer = answer(&job, content, language.media_type());
    Ok(named(
        answer,
        job.outline(),
        Part::Input,
        language.extension(),
    ))
}

/// `GET /v1/jobs/{id}/result`
pub(super) async fn result(
    State(app): State<App>,
    InPath(id): InPath<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (job, wanted) = job_and_wanted(&app, &id, &uri, &headers).await?;
    show_result(&job, wanted).await
}

/// `GET /v1/jobs/{id}/result/{format}`
pub(super) async fn result_file(
    State(app): State<App>,
    InPath((id, format)): InPath<(String, String)>,
    uri: Uri,
) -> Result<Response, Problem> {
    let (job, file) = job_and_file(&app, &id, &format, &uri).await?;
    show_result(&job, file).await
}

pub(super) async fn show_result(job: &Arc<Job>, wanted: Wanted) -> Result<Response, Problem> {
    match wanted {
        Wanted::Form(form) if form.digits == Digits::Auto => {
            let detail = "a result has all digits; rounded ones are for iterations";
            Err(Problem::at_parameter("digits", detail))
        }
        Wanted::Form(form) => {
            let content = content::result_content(job, form.clone()).await?;
            let language = language(&form);
            let answer = answer(job, content, language.media_type());
            Ok(named(
                answer,
                job.outline(),
                Part::Result,
                language.extension(),
            ))
        }
        Wanted::File(format, options) => {
            let (_, frame) = content::end(job).await?;
            let file = export::file(job, frame, format, options).await?;
            Ok(named(file, job.outline(), Part::Result, format.extension()))
        }
    }
}

/// `GET /v1/jobs/{id}/limit`: the limits of the difference vectors of the fixed points of a local
/// fit.
pub(super) async fn limit(
    State(app): State<App>,
    InPath(id): InPath<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let system = job.system().await?;
    let compute = move || {
        let start = Iteration::start(system.get());
        local_limit(&start).map(|limit| to_bytes(&LimitView::new(system.problem(), &limit)))
    };
    let limit = app
        .jobs
        .resources()
        .scheduler
        .compute(WorkLane::Long(LIMIT_COST), compute)
        .await?;
    let limit = limit.map(|json| whole(json, JSON));
    limit.map_err(|reason| {
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

/// `GET /v1/jobs/{id}/deviation`: distances of the data from the nearest points of a level.
pub(super) async fn deviation(
    State(app): State<App>,
    InPath(id): InPath<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let query: DeviationQuery = negotiate::query(&uri)?;
    let (k, list) = query.choices()?;
    let job = jobs::find(&app, &id).await?;
    let wait = negotiate::wait(&headers)?;
    let (frame, deviation) = content::deviation(&app, &job, k, wait).await?;
    let numbers = if list { deviation.distances.len() } else { 1 };
    let write = move || {
        let iteration = frame.level.iteration;
        let view = DeviationView::new(&frame.problem, iteration, &deviation, list);
        Content::from(to_bytes(&view))
    };
    let content = encode::off_network(&job, numbers, write).await?;
    Ok(answer(&job, content, JSON))
}

/// `GET /v1/jobs/{id}/shape`: curvature, length or area, and continuity of a level.
pub(super) async fn shape(
    State(app): State<App>,
    InPath(id): InPath<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let query: ShapeQuery = negotiate::query(&uri)?;
    let k = query.iteration()?;
    let job = jobs::find(&app, &id).await?;
    let samples = query.samples(job.outline().surface)?;
    let wait = negotiate::wait(&headers)?;
    let content = content::shape(&app, &job, k, samples, wait).await?;
    Ok(answer(&job, content, JSON))
}

/// The requested form of a level: JSON or a message, or a file.
pub(super) enum Wanted {
    Form(Form),
    File(Format, Options),
}

async fn job_and_wanted(
    app: &App,
    id: &str,
    uri: &Uri,
    headers: &HeaderMap,
) -> Result<(Arc<Job>, Wanted), Problem> {
    let query: IterationQuery = negotiate::query(uri)?;
    let representation = export::representation(headers)?;
    let job = jobs::find(app, id).await?;
    let wanted = wanted(&job, query, representation).await?;
    Ok((job, wanted))
}

/// The requested form of a level of a job.
pub(super) async fn wanted(
    job: &Job,
    query: IterationQuery,
    representation: Representation,
) -> Result<Wanted, Problem> {
    let surface = job.outline().surface;
    if let Representation::File(format) = representation {
        let options = query.file_options(format, surface)?;
        return Ok(Wanted::File(format, options));
    }
    let spec = query.spec(surface)?;
    let form = match representation {
        Representation::Protobuf => options::message_form(&spec, surface)?,
        _ => options::json_form(&spec, surface)?,
    };
    if form.encoding == Encoding::Base64F32 {
        let problem = job.problem().await?;
        options::check_range(&spec, None, &problem)?;
    }
    Ok(Wanted::Form(form))
}

async fn job_and_file(
    app: &App,
    id: &str,
    format: &str,
    uri: &Uri,
) -> Result<(Arc<Job>, Wanted), Problem> {
    let format: Format = format.parse().map_err(|_: UnknownFormat| {
        let detail = format!("unknown format {}", quoted(format));
        Problem::new(Kind::NotFound, detail)
    })?;
    let query: IterationQuery = negotiate::query(uri)?;
    let job = jobs::find(app, id).await?;
    let options = query.file_options(format, job.outline().surface)?;
    Ok((job, Wanted::File(format, options)))
}

/// The number of an iteration; `None` is the last one so far.
fn level(text: &str) -> Result<Option<usize>, Problem> {
    if text == "last" {
        return Ok(None);
    }
    plain_number(text).map(Some).ok_or_else(|| {
        let detail = format!(
            "{} is not an iteration; expected a number from 0, or \"last\"",
            quoted(text)
        );
        Problem::new(Kind::NoSuchIteration, detail)
    })
}

fn language(form: &Form) -> Language {
    match form.is_protobuf() {
        false => Language::Json,
        true => Language::Protobuf,
    }
}
