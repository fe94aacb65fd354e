//! The JSON of a level: its errors, and its geometry in one of several forms.

use std::borrow::Cow;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use super::decimal::Rounding;
use super::document::Document;
use super::source::{Along, Net, NetWeights};
use super::writer::Digits;
use super::{Distances, error, kind, per_direction, point_index, rational};
use crate::api::stream::form;
use crate::api::stream::form::{Encoding, Form, View};
use crate::fit::direction::Direction;
use crate::fit::geometry::Geometry;
use crate::fit::invalid::Axis;
use crate::fit::iteration::Level;
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::fit::samples::{Samples, Uniform};
use crate::job::Job;
use crate::job::content::Content;
use crate::job::frame::Frame;
use crate::job::state::Status;

/// What every form of a level begins with.
#[derive(Serialize)]
struct Head {
    iteration: usize,
    error: Distances,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted: Option<usize>,
    moved: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<Value>,
}

/// The data of an `iteration` event.
pub fn level(problem: &Arc<Problem>, frame: &Frame, form: &Form) -> Content {
    let level = &frame.level;
    let head = Head {
        iteration: level.iteration,
        error: error(&level.error, &**problem),
        rate: level.rate,
        predicted: level.predicted,
        moved: level.moved,
        bad_weight: bad_weight(level, problem),
    };
    let begin = |count| Document::new(&head, digits(form, level), count);
    let document = match form.view {
        View::Errors => begin(0),
        View::ControlPoints => {
            let shape = net_shape(problem);
            let mut document = begin(shape.iter().product());
            document.arrays(&shape, |document| {
                write_net(document, problem, &frame.control_points);
            });
            document
        }
        View::Changed => {
            let moved = frame.moved.as_deref().unwrap_or_default();
            let mut document = begin(moved.len() * (problem.dimension() + 1));
            let geometry = Geometry::new(problem, &frame.control_points);
            write_changed(&mut document, problem, geometry, moved);
            document
        }
        View::Samples(grid) => {
            let mut document = begin(grid.count() * problem.dimension());
            let points = Arc::clone(&frame.control_points);
            write_samples(
                &mut document,
                &Samples::new(Arc::clone(problem), points, grid),
            );
            document
        }
    };
    document.finish()
}

fn digits(form: &Form, level: &Level) -> Digits {
    match (form.encoding, form.digits) {
        (Encoding::Base64, _) => Digits::Base64,
        (Encoding::Base64F32, _) => Digits::Base64F32,
        // Messages are not written here.
        (Encoding::Json | Encoding::Protobuf, form::Digits::Full) => Digits::Decimal(None),
        (Encoding::Json | Encoding::Protobuf, form::Digits::Auto) => {
            Digits::Decimal(Rounding::for_error(level.error.max))
        }
    }
}

/// What is wrong with a homogeneous level: no CAD kernel takes a weight that is not positive.
fn bad_weight(level: &Level, problem: &Problem) -> Option<Value> {
    let (index, weight) = level.bad_weight?;
    Some(json!({
        "control_point": point_index(index, problem),
        "weight": weight,
        "detail": "a weight of a control point is not positive at this level",
    }))
}

/// The shape of the complete control net: places in each direction, and coordinates.
fn net_shape(problem: &Problem) -> Vec<usize> {
    let functions = problem.directions().map(|it| it.basis.functions());
    functions.chain([problem.dimension()]).collect()
}

/// The complete control net of a level, with the weights of homogeneous fits.
fn write_net(document: &mut Document, problem: &Arc<Problem>, control_points: &Arc<Points>) {
    let shape = net_shape(problem);
    let net = || Net {
        problem: Arc::clone(problem),
        control_points: Arc::clone(control_points),
    };
    document.coordinates("control_points", &shape, net());
    if problem.is_homogeneous() {
        document.array("weights", &shape[..shape.len() - 1], NetWeights(net()));
    }
}

/// The places of the complete net at which control points have moved: `[index, point]`, with its
/// weight in homogeneous fits.
fn write_changed(
    document: &mut Document,
    problem: &Problem,
    geometry: Geometry<'_>,
    moved: &[usize],
) {
    let occurrences = moved.iter().flat_map(|&index| {
        let places = geometry.occurrences(index);
        places.map(move |place| (index, place))
    });
    document.lists(
        "changed",
        occurrences,
        |document, (index, (row, column))| {
            match problem.v() {
                None => document.element(&row),
                Some(_) => document.element(&[row, column]),
            }
            document.point(geometry.place(index));
            if let Some(weight) = geometry.weight(index) {
                document.element(&weight);
            }
        },
    );
}

/// Points of the curve or surface at equal steps of the parameters.
fn write_samples(document: &mut Document, samples: &Samples) {
    let (u, v) = (samples.u, samples.v);
    let counts = [
        Some(u.count()),
        v.map(Uniform::count),
        Some(samples.dimension()),
    ];
    let shape: Vec<usize> = counts.into_iter().flatten().collect();
    document.arrays(&shape, |document| {
        match v {
            None => document.array("parameters", &[u.count()], u),
            Some(v) => document.object("parameters", |document| {
                document.array("u", &[u.count()], u);
                document.array("v", &[v.count()], v);
            }),
        }
        document.coordinates("samples", &shape, samples.clone());
    });
}

/// Writes a field with something for each direction: itself for a curve, `{"u": …, "v": …}` for a surface.
fn write_each(
    document: &mut Document,
    name: &str,
    problem: &Problem,
    write: impl Fn(&mut Document, &str, Axis, &Direction),
) {
    match problem.v() {
        None => write(document, name, Axis::U, problem.u()),
        Some(v) => document.object(name, |document| {
            write(document, "u", Axis::U, problem.u());
            write(document, "v", Axis::V, v);
        }),
    }
}

/// Writes an array of numbers of each direction.
pub fn write_along(
    document: &mut Document,
    name: &str,
    problem: &Arc<Problem>,
    numbers: fn(&Direction) -> Cow<'_, [f64]>,
) {
    write_each(document, name, problem, |document, name, axis, _| {
        write_line(document, name, problem, axis, numbers);
    });
}

fn write_line(
    document: &mut Document,
    name: &str,
    problem: &Arc<Problem>,
    axis: Axis,
    numbers: fn(&Direction) -> Cow<'_, [f64]>,
) {
    let line = Along {
        problem: Arc::clone(problem),
        axis,
        numbers,
    };
    document.array(name, &[line.count()], line);
}

/// Writes the knots of each direction, in full; null for bases that are no B-splines.
pub fn write_knots(document: &mut Document, problem: &Arc<Problem>) {
    write_each(
        document,
        "knots",
        problem,
        |document, name, axis, direction| match direction.basis.knots() {
            None => document.field(name, &Value::Null),
            Some(_) => write_line(document, name, problem, axis, |direction| {
                direction.basis.knots().unwrap_or_default()
            }),
        },
    );
}

/// The result: geometry that can be read without anything else.
pub fn result(
    job: &Job,
    problem: &Arc<Problem>,
    status: &Status,
    level: &Level,
    control_points: &Arc<Points>,
    form: &Form,
) -> Content {
    #[derive(Serialize)]
    struct Head<'a, B, D> {
        id: uuid::Uuid,
        name: Option<&'a str>,
        kind: &'static str,
        state: &'static str,
        iteration: usize,
        error: Distances,
        basis: B,
        degree: D,
        closed: Value,
        rational: Option<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        bad_weight: Option<Value>,
    }
    let outline = job.outline();
    let head = Head {
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: kind(outline),
        state: status.state.name(),
        iteration: level.iteration,
        error: error(&level.error, &**problem),
        basis: per_direction(problem, |direction| direction.basis.name()),
        degree: per_direction(problem, |direction| direction.basis.degree()),
        closed: json!(per_direction(problem, Direction::is_closed)),
        rational: rational(problem),
        bad_weight: bad_weight(level, problem),
    };
    let shape = net_shape(problem);
    let mut document = Document::new(&head, digits(form, level), shape.iter().product());
    document.precise(|document| write_knots(document, problem));
    document.arrays(&shape, |document| {
        write_net(document, problem, control_points);
        if problem.directions().any(Direction::is_rational) {
            // Those of a rational basis stay; end copies included.
            write_along(document, "weights", problem, |direction| {
                direction.weights().unwrap_or_default().into()
            });
        }
    });
    document.finish()
}
