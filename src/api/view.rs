//! The JSON of answers.

use bytes::Bytes;
use serde::ser::{SerializeSeq, SerializeStruct};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::problem as api;
use crate::fit::geometry::Geometry;
use crate::fit::iteration::{FitError, Level};
use crate::fit::points::{Grid, Points};
use crate::fit::problem::{Direction, Problem};
use crate::fit::transform::Method;
use crate::job::Job;
use crate::job::state::Status;

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

/// The distances of a level from the data. On surfaces `at` is `[row, column]`.
pub fn error(error: &FitError, problem: &Problem) -> Value {
    let at = match problem.v() {
        None => json!(error.at),
        Some(_) => {
            let columns = problem.grid().columns;
            json!([error.at / columns, error.at % columns])
        }
    };
    json!({"max": error.max, "rms": error.rms, "sum": error.sum, "at": at})
}

/// The job as a resource.
pub fn job(job: &Job) -> Value {
    let status = job.status();
    let problem = job.problem();
    let id = job.id();
    let level = status.levels.map(|levels| levels.last);
    let mut value = json!({
        "id": id,
        "name": job.name(),
        "kind": kind(problem),
        "state": status.state.name(),
        "points": problem.grid().count(),
        "method": method(problem),
        "stop": stop(problem),
        "iteration": level.map(|level| level.iteration),
        "error": level.map(|level| error(&level.error, problem)),
        "progress": status.progress(problem),
        "created_at": job.created(),
        "started_at": status.started,
        "finished_at": status.finished,
        "links": links(job),
    });
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
        "result": format!("{base}/result"),
        "cancel": format!("{base}/cancel"),
    })
}

/// The path of a job.
pub fn path(job: &Job) -> String {
    format!("/v1/jobs/{}", job.id())
}

fn kind(problem: &Problem) -> &'static str {
    match problem.v() {
        None => "curve",
        Some(_) => "surface",
    }
}

fn method(problem: &Problem) -> Value {
    match problem.method() {
        Method::Global => json!({"kind": "global"}),
    }
}

fn stop(problem: &Problem) -> Value {
    json!({"tolerance": problem.tolerance(), "max_iterations": problem.max_iterations()})
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

/// The data of the `job` event: all that does not change from iteration to iteration.
pub fn description(job: &Job) -> Bytes {
    #[derive(Serialize)]
    struct Description<'a, D, B, K, P> {
        id: uuid::Uuid,
        name: Option<&'a str>,
        kind: &'static str,
        points: usize,
        basis: B,
        degree: D,
        method: Value,
        stop: Value,
        links: Value,
        knots: K,
        parameters: P,
    }
    let problem = job.problem();
    to_bytes(&Description {
        id: job.id(),
        name: job.name(),
        kind: kind(problem),
        points: problem.grid().count(),
        basis: per_direction(problem, |direction| direction.basis.name()),
        degree: per_direction(problem, |direction| direction.basis.degree()),
        method: method(problem),
        stop: stop(problem),
        links: links(job),
        knots: per_direction(problem, |direction| direction.basis.clamped_knots()),
        parameters: per_direction(problem, |direction| direction.parameters.clone()),
    })
}

/// The data of an `iteration` event: the level with its complete control points.
pub fn iteration(problem: &Problem, level: &Level, control_points: &Points) -> Bytes {
    #[derive(Serialize)]
    struct Iteration<'a> {
        iteration: usize,
        error: Value,
        moved: usize,
        control_points: Net<'a>,
    }
    to_bytes(&Iteration {
        iteration: level.iteration,
        error: error(&level.error, problem),
        moved: level.moved,
        control_points: Net(Geometry::new(problem, control_points)),
    })
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
        "iterations": level.map_or(0, |level| level.iteration),
        "error": level.map(|level| error(&level.error, job.problem())),
        "elapsed": elapsed,
        "links": {"self": path(job), "result": format!("{}/result", path(job))},
    });
    if let Some(failure) = status.failure {
        value["problem"] = api::Problem::from(failure).to_json(None);
    }
    to_bytes(&value)
}

/// The result: geometry that can be read without anything else.
pub fn result(job: &Job, status: &Status, level: &Level, control_points: &Points) -> Bytes {
    #[derive(Serialize)]
    struct ResultView<'a, D, K> {
        id: uuid::Uuid,
        name: Option<&'a str>,
        kind: &'static str,
        state: &'static str,
        iteration: usize,
        error: Value,
        degree: D,
        knots: K,
        control_points: Net<'a>,
    }
    let problem = job.problem();
    to_bytes(&ResultView {
        id: job.id(),
        name: job.name(),
        kind: kind(problem),
        state: status.state.name(),
        iteration: level.iteration,
        error: error(&level.error, problem),
        degree: per_direction(problem, |direction| direction.basis.degree()),
        knots: per_direction(problem, |direction| direction.basis.clamped_knots()),
        control_points: Net(Geometry::new(problem, control_points)),
    })
}

/// Points of the curve or surface of a level, at equal steps of the parameters.
pub fn samples(problem: &Problem, level: &Level, control_points: &Points, grid: Grid) -> Bytes {
    struct Samples<'a> {
        problem: &'a Problem,
        level: &'a Level,
        u: Vec<f64>,
        v: Vec<f64>,
        points: Points,
    }
    impl Serialize for Samples<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let mut fields = serializer.serialize_struct("Samples", 4)?;
            fields.serialize_field("iteration", &self.level.iteration)?;
            fields.serialize_field("error", &error(&self.level.error, self.problem))?;
            if self.problem.v().is_none() {
                fields.serialize_field("parameters", &self.u)?;
                fields.serialize_field("samples", &Line(&self.points, 0, self.u.len()))?;
            } else {
                fields.serialize_field("parameters", &json!({"u": self.u, "v": self.v}))?;
                fields.serialize_field("samples", &Lines(&self.points, self.v.len()))?;
            }
            fields.end()
        }
    }
    let u = Geometry::uniform_parameters(&problem.u().basis, grid.rows);
    let v = problem.v().map_or(Vec::new(), |v| {
        Geometry::uniform_parameters(&v.basis, grid.columns)
    });
    let points = Geometry::new(problem, control_points).evaluate(&u, &v);
    to_bytes(&Samples {
        problem,
        level,
        u,
        v,
        points,
    })
}

/// The complete control net: points for a curve, rows of points for a surface.
struct Net<'a>(Geometry<'a>);

impl Serialize for Net<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let geometry = self.0;
        match geometry.columns() {
            None => serializer.collect_seq(
                (0..geometry.rows())
                    .flat_map(|row| geometry.row(row))
                    .map(|index| Point(geometry.control_points(), index)),
            ),
            Some(_) => {
                serializer.collect_seq((0..geometry.rows()).map(|row| NetRow(geometry, row)))
            }
        }
    }
}

struct NetRow<'a>(Geometry<'a>, usize);

impl Serialize for NetRow<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(geometry, row) = *self;
        let points = geometry.row(row).collect::<Vec<_>>();
        serializer.collect_seq(
            points
                .into_iter()
                .map(|index| Point(geometry.control_points(), index)),
        )
    }
}

/// Rows of so many points.
struct Lines<'a>(&'a Points, usize);

impl Serialize for Lines<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, columns) = *self;
        let rows = points.len() / columns;
        serializer.collect_seq((0..rows).map(|row| Line(points, row * columns, columns)))
    }
}

/// Points from an index on.
struct Line<'a>(&'a Points, usize, usize);

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, start, count) = *self;
        serializer.collect_seq((start..start + count).map(|index| Point(points, index)))
    }
}

struct Point<'a>(&'a Points, usize);

impl Serialize for Point<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sequence = serializer.serialize_seq(Some(self.0.dimension()))?;
        for coordinate in self.0.point(self.1) {
            sequence.serialize_element(&coordinate)?;
        }
        sequence.end()
    }
}
