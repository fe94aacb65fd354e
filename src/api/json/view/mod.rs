//! The JSON of answers: jobs, their descriptions and ends.
//!
//! - `input`: a job as it was asked for;
//! - [`level`]: the geometry of a level;
//! - [`document`]: objects with large arrays of numbers, over [`source`] and [`writer`];
//! - [`warning`]: what is doubtful about a job;
//! - [`decimal`]: numbers with as many digits as they deserve.

pub mod decimal;
pub mod document;
mod input;
pub mod level;
pub mod source;
pub mod warning;
pub mod writer;

use std::sync::Arc;

use bytes::Bytes;
use serde::Serialize;
use serde_json::{Value, json};

use document::Document;
use level::{write_along, write_knots};
use warning::{WarningView, warnings};
use writer::Digits;

pub use input::input;

use crate::api::problem as api;
use crate::fit::direction::Direction;
use crate::fit::limit::LocalLimit;
use crate::fit::method::{Adaptive, Extended, Local, Method, Start, Variant, Weighted};
use crate::fit::norms::FitError;
use crate::fit::problem::Problem;
use crate::fit::system::Forecast;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::outline::Outline;
use crate::job::state::{Levels, Reason, Status};
use crate::model::stream::StreamSpec;

/// A value as bytes of JSON. The values of this module always have a JSON form.
pub fn to_bytes(value: &impl Serialize) -> Bytes {
    match serde_json::to_vec(value) {
        Ok(bytes) => bytes.into(),
        Err(error) => {
            tracing::error!(%error, "a value has no JSON form");
            Bytes::from_static(b"null")
        }
    }
}

/// How the data points of a job are numbered, and whether some of them are fixed.
#[derive(Clone, Copy)]
pub struct Arrangement {
    /// On surfaces the number of columns.
    columns: Option<usize>,
    local: bool,
}

impl From<&Problem> for Arrangement {
    fn from(problem: &Problem) -> Self {
        Self {
            columns: problem.v().map(|_| problem.grid().columns),
            local: matches!(problem.method(), Method::Local(_)),
        }
    }
}

impl From<&Outline> for Arrangement {
    fn from(outline: &Outline) -> Self {
        Self {
            columns: outline.surface.then_some(outline.grid.columns),
            local: matches!(outline.method, Method::Local(_)),
        }
    }
}

/// The distances of a level from the data. On surfaces `at` is `[row, column]`. Distances that are
/// infinite, of points whose weight is not positive, are null.
#[derive(Serialize)]
pub struct Distances {
    max: f64,
    rms: f64,
    sum: f64,
    at: PointIndex,
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed_max: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    homogeneous: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gradient: Option<f64>,
}

/// The distances of a level from the data.
pub fn error(error: &FitError, of: impl Into<Arrangement>) -> Distances {
    let of = of.into();
    Distances {
        max: error.max,
        rms: error.rms,
        sum: error.sum,
        at: point_index(error.at, of),
        fixed_max: error.fixed_max.filter(|_| of.local),
        homogeneous: error.homogeneous,
        gradient: error.gradient,
    }
}

/// The index of a data point: on surfaces `[row, column]`.
#[derive(Serialize)]
#[serde(untagged)]
enum PointIndex {
    OfCurve(usize),
    OfSurface([usize; 2]),
}

fn point_index(index: usize, of: impl Into<Arrangement>) -> PointIndex {
    match of.into().columns {
        None => PointIndex::OfCurve(index),
        Some(columns) => PointIndex::OfSurface([index / columns, index % columns]),
    }
}

/// The job as a resource.
pub fn job(job: &Job) -> Value {
    let status = job.status();
    let outline = job.outline();
    let level = status.levels.map(|levels| levels.last);
    let forecast = status.levels.map(|levels| levels.forecast);
    let mut value = json!({
        "id": outline.id,
        "name": outline.label.name,
        "kind": kind(outline),
        "state": status.state.name(),
        "reason": status.reason.map(Reason::name),
        "detail": status.detail(outline.tolerance),
        "warnings": warnings(outline, status.levels.as_ref()),
        "points": outline.grid.count(),
        "method": method(outline, forecast),
        "stop": stop(outline),
        "stream": stream(outline),
        "iteration": level.map(|level| level.iteration),
        "predicted": json!({
            "rate": forecast.and_then(|it| it.rate),
            "iterations": level.and_then(|level| level.predicted),
        }),
        "error": level.map(|level| error(&level.error, outline)),
        "progress": status.progress(outline),
        "created_at": outline.created,
        "started_at": status.started,
        "finished_at": status.finished,
        "links": links(job),
    });
    if let Some(parent) = outline.label.parent {
        value["parent"] = json!({"id": parent.id, "iteration": parent.iteration});
    }
    if let Some(failure) = status.failure {
        value["problem"] = api::Problem::from(failure).to_json(None);
    }
    value
}

fn links(job: &Job) -> Value {
    let base = path(job);
    json!({
        "self": base,
        "events": format!("{base}/events"),
        "input": format!("{base}/input"),
        "result": format!("{base}/result"),
        "edits": format!("{base}/edits"),
        "limit": format!("{base}/limit"),
        "cancel": format!("{base}/cancel"),
    })
}

/// The path of a job.
pub fn path(job: &Job) -> String {
    format!("/v1/jobs/{}", job.id())
}

fn kind(outline: &Outline) -> &'static str {
    if outline.surface { "surface" } else { "curve" }
}

/// The method with its settings, and with the numbers that were computed for it.
fn method(outline: &Outline, forecast: Option<Forecast>) -> Value {
    let method = &outline.method;
    let mut value = json!({"kind": method.name()});
    match *method {
        Method::Weighted(Weighted { omega }) => {
            value["omega"] = json!(forecast.and_then(|it| it.omega).or(omega));
        }
        Method::Local(Local { row_by_row }) => {
            value["adjusted"] = json!(outline.adjusted);
            value["row_by_row"] = json!(row_by_row);
        }
        Method::Adaptive(Adaptive { threshold }) => value["threshold"] = json!(threshold),
        Method::Extended(Extended { start }) => {
            value["start"] = json!(match start {
                Start::Transformed => "transformed",
                Start::Data => "data",
            });
        }
        Method::LeastSquares(settings) => {
            value["control_points"] = match outline.surface {
                false => json!(settings.u),
                true => json!({"u": settings.u, "v": settings.v}),
            };
            value["variant"] = json!(match settings.variant {
                Variant::Diagonal => "diagonal",
                Variant::Lspia { .. } => "lspia",
                Variant::ConjugateGradients => "cg",
            });
        }
        _ => {}
    }
    if let Some(block) = forecast.and_then(|it| it.block) {
        value["lambda_min"] = json!(block);
    } else if let Some(lambda_min) = forecast.and_then(|it| it.lambda_min) {
        value["lambda_min"] = json!(lambda_min);
    }
    value
}

fn stop(outline: &Outline) -> Value {
    json!({"tolerance": outline.tolerance, "max_iterations": outline.max_iterations})
}

/// How the streams of a job go if they do not say it themselves.
fn stream(outline: &Outline) -> Option<&StreamSpec> {
    outline.label.stream.as_deref()
}

/// One value for a curve, `{"u": …, "v": …}` for a surface.
fn per_direction<T: Serialize>(
    problem: &Problem,
    value: impl Fn(&Direction) -> T,
) -> impl Serialize {
    let u = value(problem.u());
    match problem.v() {
        None => OneOrTwo::One(u),
        Some(v) => OneOrTwo::Two { u, v: value(v) },
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum OneOrTwo<T> {
    One(T),
    Two { u: T, v: T },
}

/// The data of the `job` event: all that does not change from iteration to iteration. Its arrays are
/// decimal, or of 64 bits in base64.
pub fn description(
    job: &Job,
    problem: &Arc<Problem>,
    levels: Option<Levels>,
    in_base64: bool,
) -> Content {
    #[derive(Serialize)]
    struct Head<'a, B, D> {
        id: uuid::Uuid,
        name: Option<&'a str>,
        kind: &'static str,
        points: usize,
        dimension: usize,
        control_points: Value,
        basis: B,
        degree: D,
        closed: Value,
        rational: Option<&'static str>,
        method: Value,
        predicted: Value,
        stop: Value,
        links: Value,
        warnings: Vec<WarningView>,
    }
    let outline = job.outline();
    let forecast = levels.map(|levels| levels.forecast);
    let head = Head {
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: kind(outline),
        points: problem.grid().count(),
        dimension: problem.dimension(),
        control_points: json!(per_direction(problem, |direction| direction
            .basis
            .functions())),
        basis: per_direction(problem, |direction| direction.basis.name()),
        degree: per_direction(problem, |direction| direction.basis.degree()),
        closed: json!(per_direction(problem, Direction::is_closed)),
        rational: rational(problem),
        method: method(outline, forecast),
        predicted: json!({
            "rate": forecast.and_then(|it| it.rate),
            "iterations": levels.and_then(|levels| levels.first.predicted),
        }),
        stop: stop(outline),
        links: links(job),
        warnings: warnings(outline, levels.as_ref()),
    };
    let numbers = problem.directions().map(|it| 2 * it.parameters.len()).sum();
    let digits = match in_base64 {
        true => Digits::Base64,
        false => Digits::Decimal(None),
    };
    let mut document = Document::new(&head, digits, numbers);
    if in_base64 {
        document.field("encoding", &"base64");
    }
    if problem.directions().any(Direction::is_rational) {
        // One for each control point of a direction, end copies included.
        write_along(&mut document, "weights", problem, |direction| {
            direction.weights().unwrap_or_default().into()
        });
    } else {
        document.field("weights", &Value::Null);
    }
    write_knots(&mut document, problem);
    write_along(&mut document, "parameters", problem, |direction| {
        direction.parameters.as_slice().into()
    });
    document.finish()
}

fn rational(problem: &Problem) -> Option<&'static str> {
    if problem.is_homogeneous() {
        Some("homogeneous")
    } else if problem.directions().any(Direction::is_rational) {
        Some("fixed")
    } else {
        None
    }
}

/// The data of the `end` event.
pub fn end(job: &Job, status: &Status) -> Bytes {
    let level = status.levels.map(|levels| levels.last);
    let elapsed = status
        .started
        .zip(status.finished)
        .map(|(start, end)| end.duration_since(start).as_secs_f64());
    let mut value = json!({
        "state": status.state.name(),
        "reason": status.reason.map(Reason::name),
        "detail": status.detail(job.outline().tolerance),
        "iterations": level.map_or(0, |level| level.iteration),
        "error": level.map(|level| error(&level.error, job.outline())),
        "elapsed": elapsed,
        "links": {"self": path(job), "result": format!("{}/result", path(job))},
    });
    if let Some(failure) = status.failure {
        value["problem"] = api::Problem::from(failure).to_json(None);
    }
    to_bytes(&value)
}

/// Where the difference vectors of the fixed points of a local fit end.
pub fn limit(problem: &Problem, limit: &LocalLimit) -> Bytes {
    let indices = limit.fixed.iter();
    let indices: Vec<PointIndex> = indices.map(|&index| point_index(index, problem)).collect();
    let count = limit.differences.len();
    let largest = (0..count)
        .map(|i| limit.differences.point(i).fold(0.0, f64::hypot))
        .fold(0.0, f64::max);
    let differences: Vec<Vec<f64>> = (0..count)
        .map(|i| limit.differences.point(i).collect())
        .collect();
    to_bytes(&json!({"points": indices, "differences": differences, "max": largest}))
}
