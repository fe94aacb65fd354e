//! Single iterations and results.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Deserialize;

use super::problem::{Kind, Problem};
use super::{App, events, jobs, negotiate, no_store, view};
use crate::fit::iteration::Iteration;
use crate::fit::limit::{MOST_ADJUSTED, NoLimit, local_limit};
use crate::fit::points::{Grid, Points};
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::scheduler::Lane;
use crate::job::state::Levels;

/// The most points that are sampled.
const MOST_SAMPLES: usize = 1_000_000;

const DEFAULT_CURVE_SAMPLES: usize = 200;
const DEFAULT_SURFACE_SAMPLES: usize = 40;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewParameters {
    view: Option<String>,
    samples: Option<String>,
}

/// What to show of a level.
#[derive(Clone, Copy, Debug)]
enum View {
    ControlPoints,
    Samples(Grid),
}

/// `GET /v1/jobs/{id}/iterations/{k}`
pub async fn iteration(
    State(app): State<App>,
    Path((id, k)): Path<(String, String)>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let view = view(&uri, &job)?;
    let k = match k.as_str() {
        "last" => last_level(&job).ok_or_else(|| {
            let detail = format!("the job is {} and has no iteration yet", job.status().state);
            Problem::new(Kind::NoSuchIteration, detail)
        })?,
        k => k
            .parse()
            .ok()
            .filter(|&k: &usize| k < usize::MAX / 2)
            .ok_or_else(|| {
                let detail = format!(
                    "{k:?} is no iteration: they are numbered from 0; there is also \"last\""
                );
                Problem::new(Kind::NoSuchIteration, detail)
            })?,
    };
    let frame = match Cursor::new(Arc::clone(&job), k).next().await {
        Next::Frame(frame) => frame,
        Next::End(status) => {
            let reached = status.levels.map(|levels| levels.last.iteration);
            let detail = match reached {
                Some(last) => format!(
                    "the job is {} at iteration {last}, before {k}",
                    status.state
                ),
                None => format!("the job is {} before its first iteration", status.state),
            };
            return Err(Problem::new(Kind::NoSuchIteration, detail));
        }
    };
    let json = match view {
        View::ControlPoints => events::encode(&job, &frame).await,
        View::Samples(grid) => {
            let (level, points) = (frame.level, Arc::clone(&frame.control_points));
            let problem = Arc::clone(job.problem());
            events::off_network(&job, work(grid, &job), move || {
                view::samples(&problem, &level, &points, grid)
            })
            .await
        }
    };
    Ok(json_response(json))
}

/// `GET /v1/jobs/{id}/result`
pub async fn result(
    State(app): State<App>,
    Path(id): Path<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    negotiate::json(&headers)?;
    let job = jobs::find(&app, &id).await?;
    let view = view(&uri, &job)?;
    let status = job.status();
    let (Some(Levels { last: level, .. }), Some(points)) = (status.levels, job.result()) else {
        let detail = format!("the job is {} and has no result", status.state);
        return Err(Problem::new(Kind::NoResult, detail));
    };
    let points: Arc<Points> = Arc::clone(points);
    let owner = Arc::clone(&job);
    let numbers = match view {
        View::ControlPoints => points.len() * points.dimension(),
        View::Samples(grid) => work(grid, &job),
    };
    let json = events::off_network(&job, numbers, move || match view {
        View::ControlPoints => view::result(&owner, &status, &level, &points),
        View::Samples(grid) => view::samples(owner.problem(), &level, &points, grid),
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
    let computed = Arc::clone(&job);
    let compute = move || {
        let start = Iteration::start(computed.system());
        local_limit(&start).map(|limit| view::limit(computed.problem(), &limit))
    };
    let limit = app.jobs.scheduler().compute(Lane::Heavy, compute).await?;
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

/// How long sampling takes, in numbers that are written.
fn work(grid: Grid, job: &Job) -> usize {
    let directions = job.problem().directions();
    let functions: usize = directions
        .map(|direction| direction.basis.support_width())
        .product();
    grid.count().saturating_mul(functions)
}

fn last_level(job: &Job) -> Option<usize> {
    job.status().levels.map(|levels| levels.last.iteration)
}

fn json_response(json: Bytes) -> Response {
    let content_type = HeaderValue::from_static("application/json");
    no_store(([(header::CONTENT_TYPE, content_type)], json).into_response())
}

/// Reads `view` and `samples`: `200` for a curve, `40x40` for a surface.
fn view(uri: &Uri, job: &Job) -> Result<View, Problem> {
    let parameters: ViewParameters = negotiate::query(uri)?;
    let surface = job.problem().v().is_some();
    match parameters.view.as_deref() {
        None | Some("control_points") => match parameters.samples {
            None => Ok(View::ControlPoints),
            Some(_) => Err(Problem::at_parameter(
                "samples",
                "it is given, but the view is not samples: add view=samples",
            )),
        },
        Some("samples") => match parameters.samples {
            None => Ok(View::Samples(default_samples(surface))),
            Some(text) => sample_grid(&text, surface).map(View::Samples),
        },
        Some(other) => Err(Problem::at_parameter(
            "view",
            format!("{other:?} is not a view; there are control_points and samples"),
        )),
    }
}

fn default_samples(surface: bool) -> Grid {
    if surface {
        let n = DEFAULT_SURFACE_SAMPLES;
        Grid {
            rows: n,
            columns: n,
        }
    } else {
        Grid {
            rows: DEFAULT_CURVE_SAMPLES,
            columns: 1,
        }
    }
}

fn sample_grid(text: &str, surface: bool) -> Result<Grid, Problem> {
    let parsed = match (text.split_once('x'), surface) {
        (None, false) => text.parse().ok().map(|rows| Grid { rows, columns: 1 }),
        (Some((rows, columns)), true) => rows
            .parse()
            .ok()
            .zip(columns.parse().ok())
            .map(|(rows, columns)| Grid { rows, columns }),
        _ => None,
    };
    let least = if surface { 2 } else { 1 };
    parsed
        .filter(|grid| grid.rows >= 2 && grid.columns >= least)
        .filter(|grid| grid.rows.saturating_mul(grid.columns) <= MOST_SAMPLES)
        .ok_or_else(|| {
            let form = if surface { "40x40 for a surface" } else { "200 for a curve" };
            let detail = format!(
                "{text:?} is not a number of samples such as {form}, at least 2 in each direction and {MOST_SAMPLES} in all"
            );
            Problem::at_parameter("samples", detail)
        })
}
