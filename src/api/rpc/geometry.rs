//! The geometry of a level as messages.

use std::sync::Arc;

use bytes::BufMut;
use prost::Message;
use prost::encoding::{WireType, encode_key, encode_varint};

use super::messages::{self as pb, fit_result, iteration};
use super::names;
use super::view::{count, direction, distances};
use crate::api::options::form::{Form, View};
use crate::api::view::source::{Net, NetWeights};
use crate::api::view::writer::{Digits, Writer};
use crate::fit::geometry::Geometry;
use crate::fit::iteration::Level;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Problem;
use crate::job::Job;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::state::Status;

/// The fields of [`pb::Iteration`] and [`pb::FitResult`] that are control nets, and the arrays of
/// [`pb::ControlNet`]: they are large, and written when they are sent.
const NET_OF_ITERATION: u32 = 6;
const NET_OF_RESULT: u32 = 11;
const POINTS_OF_NET: u32 = 4;
const WEIGHTS_OF_NET: u32 = 5;

/// A level, as the bytes of an `Iteration`.
pub fn iteration(problem: &Arc<Problem>, frame: &Frame, form: &Form) -> Content {
    let level = &frame.level;
    let geometry = Geometry::new(problem, &frame.control_points);
    let shown = match form.view {
        View::Errors | View::ControlPoints => None,
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
    let with_net = form.view == View::ControlPoints;
    let net = with_net.then_some((NET_OF_ITERATION, problem, &frame.control_points));
    written(&message, net)
}

/// The final geometry, as the bytes of a `FitResult`.
pub fn result(
    job: &Job,
    problem: &Arc<Problem>,
    status: &Status,
    level: &Level,
    points: &Arc<Points>,
    view: View,
) -> Content {
    let outline = job.outline();
    let geometry = Geometry::new(problem, points);
    let (shown, net) = match view {
        View::Errors => (None, None),
        View::Samples(grid) => {
            let samples = samples(problem, geometry, grid);
            (Some(fit_result::Geometry::Samples(samples)), None)
        }
        View::ControlPoints | View::Changed => (None, Some((NET_OF_RESULT, problem, points))),
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
    written(&message, net)
}

/// A message, and the field of it that is a control net.
fn written(message: &impl Message, net: Option<(u32, &Arc<Problem>, &Arc<Points>)>) -> Content {
    let mut writer = Writer::with_capacity(message.encoded_len());
    writer.text().put_slice(&message.encode_to_vec());
    if let Some((field, problem, control_points)) = net {
        write_net(&mut writer, field, problem, control_points);
    }
    writer.finish()
}

/// The complete control net, with the weights of homogeneous fits.
fn write_net(
    writer: &mut Writer,
    field: u32,
    problem: &Arc<Problem>,
    control_points: &Arc<Points>,
) {
    let geometry = Geometry::new(problem, control_points);
    let (rows, columns) = (geometry.rows(), geometry.columns().unwrap_or(1));
    let places = rows * columns;
    let net = || Net {
        problem: Arc::clone(problem),
        control_points: Arc::clone(control_points),
    };
    let head = pb::ControlNet {
        dimension: count(problem.dimension()),
        rows: count(rows),
        columns: count(columns),
        ..pb::ControlNet::default()
    };
    let points = packed(POINTS_OF_NET, places * problem.dimension());
    let weights = problem.is_homogeneous();
    let weights = weights.then(|| packed(WEIGHTS_OF_NET, places));
    let arrays = [Some(&points), weights.as_ref()].into_iter().flatten();
    let length: usize = arrays.map(|(key, numbers)| key.len() + 8 * numbers).sum();
    encode_key(field, WireType::LengthDelimited, writer.text());
    encode_varint((head.encoded_len() + length) as u64, writer.text());
    writer.text().put_slice(&head.encode_to_vec());
    writer.text().put_slice(&points.0);
    writer.array([points.1].as_slice().into(), net(), Digits::Raw);
    if let Some((key, numbers)) = weights {
        writer.text().put_slice(&key);
        writer.array([numbers].as_slice().into(), NetWeights(net()), Digits::Raw);
    }
}

/// What stands before so many packed doubles of a field, and their number.
fn packed(field: u32, numbers: usize) -> (Vec<u8>, usize) {
    let mut key = Vec::new();
    if numbers > 0 {
        encode_key(field, WireType::LengthDelimited, &mut key);
        encode_varint(8 * numbers as u64, &mut key);
    }
    (key, numbers)
}

fn bad_weight(level: &Level) -> Option<pb::BadWeight> {
    let (index, weight) = level.bad_weight?;
    Some(pb::BadWeight {
        control_point: count(index),
        weight,
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::basis::knots::Knots;
    use crate::fit::direction::{BasisChoice, DirectionChoice};
    use crate::fit::method::Method;
    use crate::fit::parameters::Parametrization;
    use crate::fit::problem::{Request, Tolerance, Weights};

    /// Nets that are written by hand, in one piece or several, are what the contract says.
    #[test]
    fn written_nets_are_messages() {
        for (count, homogeneous) in [(5, false), (5, true), (9000, false), (9000, true)] {
            let mut points = Points::new(2);
            (0..count).for_each(|i| points.push(&[i as f64, (i as f64).sin()]));
            let weights = match homogeneous {
                true => Weights::Homogeneous((0..count).map(|i| 1.0 + i as f64).collect()),
                false => Weights::None,
            };
            let problem = Problem::new(Request {
                points: Arc::new(points),
                grid: Grid {
                    rows: count,
                    columns: 1,
                },
                u: DirectionChoice {
                    basis: BasisChoice::BSpline {
                        degree: 3,
                        knots: Knots::Data,
                    },
                    parameters: Parametrization::Uniform,
                    closed: false,
                    control_points: None,
                    weights: None,
                },
                v: None,
                missing: Vec::new(),
                weights,
                method: Method::Global,
                selected: None,
                start: None,
                lambda_min: None,
                tolerance: Tolerance::Absolute(0.0),
                max_iterations: 1,
            });
            let problem = Arc::new(problem.unwrap());
            let control_points = Arc::new(problem.data().clone());
            let head = pb::Iteration {
                iteration: 7,
                ..pb::Iteration::default()
            };
            let content = written(&head, Some((NET_OF_ITERATION, &problem, &control_points)));
            assert_eq!(content.rest.is_some(), count > 5);
            let message = pb::Iteration::decode(content.whole()).unwrap();
            let Some(iteration::Geometry::ControlNet(net)) = message.geometry else {
                panic!("it has a control net");
            };
            assert_eq!((message.iteration, net.rows), (7, count as u32 + 2));
            assert_eq!((net.columns, net.dimension), (1, 2));
            let geometry = Geometry::new(&problem, &control_points);
            let places = || (0..geometry.rows()).flat_map(|row| geometry.row(row));
            let points: Vec<f64> = places().flat_map(|index| geometry.place(index)).collect();
            let weights: Vec<f64> = places()
                .filter_map(|index| geometry.weight(index))
                .collect();
            assert!(net.points == points && net.weights == weights);
        }
    }
}
