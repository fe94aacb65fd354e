//! The geometry of a level as messages.

use std::sync::Arc;

use bytes::BufMut;
use prost::Message;
use prost::encoding::{WireType, encode_key, encode_varint};
use uuid::Uuid;

use super::names;
use super::view::{directions, distances, outliers};
use crate::api::json::view::shape::NestedShape;
use crate::api::json::view::source::{NetPoints, NetWeights, Source};
use crate::api::json::view::writer::{ArrayWriter, Digits};
use crate::job::content::Content;
use crate::job::deltas::Change;
use crate::job::frame::Frame;
use crate::job::state::State;
use crate::job::trim::Trimmed;
use crate::model::stream::form::{Form, View};
use crate::proto::job;
use crate::proto::messages::{self as pb, iteration};
use crate::proto::values::count;
use piad_fit::data::Points;
use piad_fit::engine::samples::Samples;
use piad_fit::engine::{Geometry, Level, Problem};

/// The fields of [`pb::Iteration`] and [`pb::FitResult`] that are control nets or samples, and the arrays of
/// [`pb::ControlNet`] and [`pb::Samples`]: they are large, and written while they are sent.
const NET_OF_ITERATION: u32 = 6;
const SAMPLES_OF_ITERATION: u32 = 8;
const NET_OF_RESULT: u32 = 11;
const SAMPLES_OF_RESULT: u32 = 12;
const POINTS: u32 = 4;
const WEIGHTS_OF_NET: u32 = 5;
const PARAMETERS_OF_SAMPLES: [u32; 2] = [5, 6];

/// Arrays that are written while they are sent.
enum Large<'a> {
    Net(&'a Arc<Problem>, &'a Arc<Points>),
    Samples(Samples),
}

/// A level, as the bytes of an `Iteration`.
pub(crate) fn iteration(frame: &Frame, form: &Form) -> Content {
    let (level, problem) = (&frame.level, &frame.problem);
    let points = &frame.control_points;
    let (shown, large) = match form.view {
        View::Errors => (None, None),
        View::ControlPoints => (None, Some((NET_OF_ITERATION, Large::Net(problem, points)))),
        View::Samples(grid) => {
            let samples = Samples::new(Arc::clone(problem.setup()), Arc::clone(points), grid);
            (None, Some((SAMPLES_OF_ITERATION, Large::Samples(samples))))
        }
        View::Changed => {
            let moved = frame.moved.as_deref().unwrap_or_default();
            let changes = changes(problem, Geometry::new(problem, points), moved);
            (Some(iteration::Geometry::Changes(changes)), None)
        }
    };
    let tells = form.knots && problem.is_automatic();
    let directions = problem.directions().filter(|_| tells);
    let mut knots = directions.map(|it| it.basis.knots().unwrap_or_default().into_owned());
    let message = pb::Iteration {
        knots_u: knots.next().unwrap_or_default(),
        knots_v: knots.next().unwrap_or_default(),
        geometry: shown,
        ..head(level, problem)
    };
    written(&message, large)
}

/// A level with the numbers of steps by which points, and weights, have moved since the reader's state, as the bytes of
/// an `Iteration`.
pub(crate) fn moved(frame: &Frame, view: View, changes: &[Change]) -> Content {
    let (level, problem) = (&frame.level, &frame.problem);
    let (rows, columns) = match view {
        View::Samples(grid) => (grid.rows, grid.columns),
        _ => {
            let geometry = Geometry::new(problem, &frame.control_points);
            (geometry.rows(), geometry.columns().unwrap_or(1))
        }
    };
    let step = |index: usize| changes.get(index).map_or(0.0, |change| change.step);
    let numbers = |index: usize| changes.get(index).map(|change| change.numbers.to_vec());
    let deltas = pb::Deltas {
        dimension: count(problem.dimension()),
        rows: count(rows),
        columns: count(columns),
        step: step(0),
        points: numbers(0).unwrap_or_default(),
        weight_step: step(1),
        weights: numbers(1).unwrap_or_default(),
    };
    let message = pb::Iteration {
        geometry: Some(iteration::Geometry::Deltas(deltas)),
        ..head(level, problem)
    };
    written(&message, None)
}

/// The common fields of every level.
fn head(level: &Level, problem: &Problem) -> pb::Iteration {
    pb::Iteration {
        iteration: level.iteration as u64,
        error: Some(distances(&level.error, problem.method())),
        rate: level.rate,
        moved: level.moved as u64,
        bad_weight: bad_weight(level),
        predicted: level.predicted.map(|level| level as u64),
        ..pb::Iteration::default()
    }
}

/// The job of a result.
pub(crate) struct ResultHead<'a> {
    /// The id of the job, if it has one.
    pub id: Option<Uuid>,
    /// The client's name for it.
    pub name: Option<&'a str>,
    /// Notices about its file.
    pub notices: &'a [String],
    /// The final state.
    pub state: State,
}

/// The final geometry, as the bytes of a `FitResult`.
pub(crate) fn result(head: &ResultHead<'_>, frame: &Frame, view: View) -> Content {
    let (level, problem) = (&frame.level, &frame.problem);
    let points = &frame.control_points;
    let large = match view {
        View::Errors => None,
        View::Samples(grid) => {
            let samples = Samples::new(Arc::clone(problem.setup()), Arc::clone(points), grid);
            Some((SAMPLES_OF_RESULT, Large::Samples(samples)))
        }
        View::ControlPoints | View::Changed => Some((NET_OF_RESULT, Large::Net(problem, points))),
    };
    let (u, v) = directions(problem, true);
    let message = pb::FitResult {
        id: head.id.map(|id| id.to_string()).unwrap_or_default(),
        name: head.name.map(str::to_owned),
        kind: names::kind(v.is_some()).into(),
        state: names::state(head.state).into(),
        iteration: level.iteration as u64,
        error: Some(distances(&level.error, problem.method())),
        rational: job::rational_message(problem.request()).into(),
        u: Some(u),
        v,
        bad_weight: bad_weight(level),
        geometry: None,
        notices: head.notices.to_vec(),
        fairness: problem.method().fairness(),
        outliers: outliers(problem),
        trim: Trimmed::of(frame).map(trimmed),
    };
    written(&message, large)
}

/// The remaining part of a trimmed surface.
fn trimmed(trimmed: Trimmed) -> pb::Trimmed {
    let Trimmed {
        area,
        distance,
        faces,
        loops,
    } = trimmed;
    let indices = |loops: Vec<usize>| loops.into_iter().map(count).collect();
    pb::Trimmed {
        area,
        distance,
        loops: loops
            .into_iter()
            .map(|it| pb::TrimLoop {
                degree: count(it.degree),
                knots: it.knots,
                control_points: it.control_points.into_flattened(),
            })
            .collect(),
        faces: faces
            .into_iter()
            .map(|it| pb::TrimmedFace {
                outer: count(it.outer),
                holes: indices(it.holes),
            })
            .collect(),
    }
}

/// A message, and its large field.
fn written(message: &impl Message, large: Option<(u32, Large<'_>)>) -> Content {
    let mut writer = ArrayWriter::with_capacity(message.encoded_len());
    writer.text().put_slice(&message.encode_to_vec());
    match large {
        None => {}
        Some((field, Large::Net(problem, points))) => {
            write_net(&mut writer, field, problem, points)
        }
        Some((field, Large::Samples(samples))) => write_samples(&mut writer, field, &samples),
    }
    writer.finish()
}

/// The complete control net, with the weights of homogeneous fits.
fn write_net(
    writer: &mut ArrayWriter,
    field: u32,
    problem: &Arc<Problem>,
    control_points: &Arc<Points>,
) {
    let geometry = Geometry::new(problem, control_points);
    let (rows, columns) = (geometry.rows(), geometry.columns().unwrap_or(1));
    let places = rows * columns;
    let net = || NetPoints {
        problem: Arc::clone(problem),
        control_points: Arc::clone(control_points),
    };
    let head = pb::ControlNet {
        dimension: count(problem.dimension()),
        rows: count(rows),
        columns: count(columns),
        ..pb::ControlNet::default()
    };
    let points = Packed::new(POINTS, &[places, problem.dimension()]);
    let weights = problem.is_homogeneous();
    let weights = weights.then(|| Packed::new(WEIGHTS_OF_NET, &[places]));
    let arrays = [Some(&points), weights.as_ref()];
    begin(writer, field, &head, arrays.into_iter().flatten());
    points.write(writer, net());
    if let Some(weights) = weights {
        weights.write(writer, NetWeights(net()));
    }
}

/// Points of the curve or surface at equal steps of the parameters.
fn write_samples(writer: &mut ArrayWriter, field: u32, samples: &Samples) {
    let head = pb::Samples {
        dimension: count(samples.dimension()),
        rows: count(samples.u.count()),
        columns: count(samples.columns()),
        ..pb::Samples::default()
    };
    let points = Packed::new(POINTS, &[samples.count(), samples.dimension()]);
    let lines = [Some(samples.u), samples.v].into_iter().flatten();
    let lines = PARAMETERS_OF_SAMPLES.into_iter().zip(lines);
    let lines = lines.map(|(field, line)| (Packed::new(field, &[line.count()]), line));
    let lines: Vec<_> = lines.collect();
    let arrays = std::iter::once(&points).chain(lines.iter().map(|(packed, _)| packed));
    begin(writer, field, &head, arrays);
    points.write(writer, samples.clone());
    for (packed, line) in &lines {
        packed.write(writer, *line);
    }
}

/// Begins a field that is a message with these arrays behind its head.
fn begin<'a>(
    writer: &mut ArrayWriter,
    field: u32,
    head: &impl Message,
    arrays: impl Iterator<Item = &'a Packed>,
) {
    let length: usize = arrays.map(Packed::length).sum();
    encode_key(field, WireType::LengthDelimited, writer.text());
    encode_varint((head.encoded_len() + length) as u64, writer.text());
    writer.text().put_slice(&head.encode_to_vec());
}

/// A field of packed doubles.
struct Packed {
    /// The bytes before the numbers.
    key: Vec<u8>,
    numbers: usize,
    shape: NestedShape,
}

impl Packed {
    /// Numbers of this shape: those of a point stay together.
    fn new(field: u32, shape: &[usize]) -> Self {
        let shape = NestedShape::from(shape);
        let numbers = shape.count();
        let mut key = Vec::new();
        if numbers > 0 {
            encode_key(field, WireType::LengthDelimited, &mut key);
            encode_varint(8 * numbers as u64, &mut key);
        }
        Self {
            key,
            numbers,
            shape,
        }
    }

    /// All its bytes.
    fn length(&self) -> usize {
        self.key.len() + 8 * self.numbers
    }

    fn write(&self, writer: &mut ArrayWriter, numbers: impl Source) {
        writer.text().put_slice(&self.key);
        writer.array(self.shape, numbers, Digits::Raw);
    }
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
    for (row, column) in geometry.changed(moved) {
        changes.indices.push(count(row * across + column));
        changes.points.extend(geometry.place(row, column));
        changes.weights.extend(geometry.weight(row, column));
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use piad_fit::basis::BasisChoice;
    use piad_fit::basis::Knots;
    use piad_fit::data::Grid;
    use piad_fit::engine::DirectionChoice;
    use piad_fit::engine::{Request, Tolerance, Weights};
    use piad_fit::parameters::Parametrization;

    /// Nets that are encoded by hand, in one piece or several, match the contract.
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
                weights,
                tolerance: Some(Tolerance::Absolute(0.0)),
                max_iterations: 1,
                ..Request::new(
                    points,
                    Grid {
                        rows: count,
                        columns: 1,
                    },
                    DirectionChoice::new(
                        BasisChoice::BSpline {
                            degree: 3,
                            knots: Knots::Data,
                        },
                        Parametrization::Uniform,
                    ),
                    None,
                )
            });
            let problem = Arc::new(problem.unwrap());
            let control_points = Arc::new(problem.data().clone());
            let head = pb::Iteration {
                iteration: 7,
                ..pb::Iteration::default()
            };
            let content = written(
                &head,
                Some((NET_OF_ITERATION, Large::Net(&problem, &control_points))),
            );
            assert_eq!(content.rest.is_some(), count > 5);
            let message = pb::Iteration::decode(content.whole()).unwrap();
            let Some(iteration::Geometry::ControlNet(net)) = message.geometry else {
                panic!("it has a control net");
            };
            assert_eq!((message.iteration, net.rows), (7, count as u32 + 2));
            assert_eq!((net.columns, net.dimension), (1, 2));
            let geometry = Geometry::new(&problem, &control_points);
            let places = || 0..geometry.rows();
            let points: Vec<f64> = places().flat_map(|row| geometry.place(row, 0)).collect();
            let weights: Vec<f64> = places().filter_map(|row| geometry.weight(row, 0)).collect();
            assert!(net.points == points && net.weights == weights);
        }
    }
}
