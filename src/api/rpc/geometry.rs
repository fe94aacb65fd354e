//! The geometry of a level as messages.

use bytes::Bytes;
use prost::Message;

use super::messages::{self as pb, fit_result, iteration};
use super::names;
use super::view::{count, direction, distances};
use crate::api::options::form::{Form, View};
use crate::fit::geometry::Geometry;
use crate::fit::iteration::Level;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Problem;
use crate::job::Job;
use crate::job::frame::Frame;
use crate::job::state::Status;

/// A level, as the bytes of an `Iteration`.
pub fn iteration(problem: &Problem, frame: &Frame, form: &Form) -> Bytes {
    let level = &frame.level;
    let geometry = Geometry::new(problem, &frame.control_points);
    let shown = match form.view {
        View::Errors => None,
        View::ControlPoints => Some(iteration::Geometry::ControlNet(net(problem, geometry))),
        View::Samples(grid) => Some(iteration::Geometry::Samples(samples(
            problem, geometry, grid,
        ))),
        View::Changed => {
            let moved = frame.moved.as_deref().unwrap_or_default();
            Some(iteration::Geometry::Changes(changes(
                problem, geometry, moved,
            )))
        }
    };
    let message = pb::Iteration {
        iteration: level.iteration as u64,
        error: Some(distances(&level.error, problem.method())),
        rate: level.rate,
        moved: level.moved as u64,
        bad_weight: bad_weight(level),
        geometry: shown,
    };
    message.encode_to_vec().into()
}

/// The final geometry, as the bytes of a `FitResult`.
pub fn result(
    job: &Job,
    problem: &Problem,
    status: &Status,
    level: &Level,
    points: &Points,
    view: View,
) -> Bytes {
    let outline = job.outline();
    let geometry = Geometry::new(problem, points);
    let shown = match view {
        View::Errors => None,
        View::Samples(grid) => Some(fit_result::Geometry::Samples(samples(
            problem, geometry, grid,
        ))),
        View::ControlPoints | View::Changed => {
            Some(fit_result::Geometry::ControlNet(net(problem, geometry)))
        }
    };
    let message = pb::FitResult {
        id: outline.id.to_string(),
        name: outline.label.name.clone(),
        kind: names::kind(outline).into(),
        state: names::state(status.state).into(),
        iteration: level.iteration as u64,
        error: Some(distances(&level.error, problem.method())),
        rational: names::rational(problem).into(),
        u: Some(direction(problem.u(), false)),
        v: problem.v().map(|v| direction(v, false)),
        bad_weight: bad_weight(level),
        geometry: shown,
    };
    message.encode_to_vec().into()
}

fn bad_weight(level: &Level) -> Option<pb::BadWeight> {
    let (index, weight) = level.bad_weight?;
    Some(pb::BadWeight {
        control_point: count(index),
        weight,
    })
}

/// The complete control net, with the weights of homogeneous fits.
fn net(problem: &Problem, geometry: Geometry<'_>) -> pb::ControlNet {
    let (rows, columns) = (geometry.rows(), geometry.columns().unwrap_or(1));
    let dimension = problem.dimension();
    let indices = || (0..rows).flat_map(|row| geometry.row(row));
    // Of a known size: growing would take twice the memory of a large net.
    let mut points = Vec::with_capacity(rows * columns * dimension);
    points.extend(indices().flat_map(|index| geometry.place(index)));
    let mut weights = Vec::new();
    if geometry.is_homogeneous() {
        weights.reserve_exact(rows * columns);
        weights.extend(indices().filter_map(|index| geometry.weight(index)));
    }
    pb::ControlNet {
        dimension: count(dimension),
        rows: count(rows),
        columns: count(columns),
        points,
        weights,
    }
}

/// The places of the complete net at which control points have moved.
fn changes(problem: &Problem, geometry: Geometry<'_>, moved: &[usize]) -> pb::Changes {
    let across = geometry.columns().unwrap_or(1);
    let mut changes = pb::Changes {
        dimension: count(problem.dimension()),
        ..pb::Changes::default()
    };
    for &index in moved {
        for (row, column) in geometry.occurrences(index) {
            changes.indices.push(count(row * across + column));
            changes.points.extend(geometry.place(index));
            changes.weights.extend(geometry.weight(index));
        }
    }
    changes
}

/// Points of the curve or surface at equal steps of the parameters.
fn samples(problem: &Problem, geometry: Geometry<'_>, grid: Grid) -> pb::Samples {
    let u = Geometry::uniform_parameters(&problem.u().basis, grid.rows);
    let v = problem
        .v()
        .map(|v| Geometry::uniform_parameters(&v.basis, grid.columns))
        .unwrap_or_default();
    let points = geometry.evaluate(&u, &v);
    let mut flat = Vec::with_capacity(points.len() * points.dimension());
    flat.extend((0..points.len()).flat_map(|index| points.point(index)));
    pb::Samples {
        dimension: count(problem.dimension()),
        rows: count(u.len()),
        columns: count(v.len().max(1)),
        points: flat,
        parameters_u: u,
        parameters_v: v,
    }
}
