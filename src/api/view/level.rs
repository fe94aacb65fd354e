//! The JSON of a level: its errors, and its geometry in one of several forms.

use bytes::Bytes;
use serde::Serialize;
use serde_json::{Value, json};

use super::decimal::Rounding;
use super::document::{Document, Numbers};
use super::{error, kind, per_direction, point_index, rational};
use crate::api::options::form::{Digits, Encoding, Form, View};
use crate::fit::direction::Direction;
use crate::fit::geometry::Geometry;
use crate::fit::iteration::Level;
use crate::fit::points::{Grid, Points};
use crate::fit::problem::Problem;
use crate::job::Job;
use crate::job::frame::Frame;
use crate::job::state::Status;

/// What every form of a level begins with.
#[derive(Serialize)]
struct Head {
    iteration: usize,
    error: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    moved: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    bad_weight: Option<Value>,
}

/// The data of an `iteration` event.
pub fn level(problem: &Problem, frame: &Frame, form: &Form) -> Bytes {
    let level = &frame.level;
    let head = Head {
        iteration: level.iteration,
        error: error(&level.error, problem),
        rate: level.rate,
        moved: level.moved,
        bad_weight: bad_weight(level, problem),
    };
    let geometry = Geometry::new(problem, &frame.control_points);
    let begin = |count| Document::new(&head, numbers(form, level), count);
    let document = match form.view {
        View::Errors => begin(0),
        View::ControlPoints => {
            let mut document = begin(net_size(problem));
            document.arrays(&net_shape(problem), |document| {
                write_net(document, problem, geometry);
            });
            document
        }
        View::Changed => {
            let moved = frame.moved.as_deref().unwrap_or_default();
            let mut document = begin(moved.len() * (problem.dimension() + 1));
            write_changed(&mut document, problem, geometry, moved);
            document
        }
        View::Samples(grid) => {
            let mut document = begin(grid.count() * problem.dimension());
            write_samples(&mut document, problem, geometry, grid);
            document
        }
    };
    document.finish()
}

fn numbers(form: &Form, level: &Level) -> Numbers {
    match (form.encoding, form.digits) {
        (Encoding::Base64, _) => Numbers::Binary64,
        (Encoding::Base64F32, _) => Numbers::Binary32,
        // Messages are not written here.
        (Encoding::Json | Encoding::Protobuf, Digits::Full) => Numbers::Decimal(None),
        (Encoding::Json | Encoding::Protobuf, Digits::Auto) => {
            Numbers::Decimal(Rounding::for_error(level.error.max))
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

fn net_size(problem: &Problem) -> usize {
    net_shape(problem).iter().product()
}

/// The complete control net of a level, with the weights of homogeneous fits.
fn write_net(document: &mut Document, problem: &Problem, geometry: Geometry<'_>) {
    let shape = net_shape(problem);
    let net = || (0..geometry.rows()).flat_map(|row| geometry.row(row));
    let places = net().flat_map(|index| geometry.place(index));
    document.coordinates("control_points", &shape, places);
    if geometry.is_homogeneous() {
        let weights = net().filter_map(|index| geometry.weight(index));
        document.array("weights", &shape[..shape.len() - 1], weights);
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
fn write_samples(document: &mut Document, problem: &Problem, geometry: Geometry<'_>, grid: Grid) {
    let u = Geometry::uniform_parameters(&problem.u().basis, grid.rows);
    let v = problem.v().map(|v| {
        let count = grid.columns;
        Geometry::uniform_parameters(&v.basis, count)
    });
    let points = geometry.evaluate(&u, v.as_deref().unwrap_or_default());
    let across = v.as_ref().map(Vec::len);
    let shape: Vec<usize> = [u.len()].into_iter().chain(across).collect();
    let shape = [shape, vec![problem.dimension()]].concat();
    document.arrays(&shape, |document| {
        match &v {
            None => write_line(document, "parameters", &u),
            Some(v) => document.object("parameters", |document| {
                write_line(document, "u", &u);
                write_line(document, "v", v);
            }),
        }
        let coordinates = (0..points.len()).flat_map(|index| points.point(index));
        document.coordinates("samples", &shape, coordinates);
    });
}

/// The weights that stay of a rational basis, end copies included.
fn write_fixed_weights(document: &mut Document, problem: &Problem) {
    let weights = |direction: &'_ Direction| direction.weights().unwrap_or_default().to_vec();
    let u = weights(problem.u());
    match problem.v() {
        None => write_line(document, "weights", &u),
        Some(v) => document.object("weights", |document| {
            write_line(document, "u", &u);
            write_line(document, "v", &weights(v));
        }),
    }
}

fn write_line(document: &mut Document, name: &str, numbers: &[f64]) {
    document.array(name, &[numbers.len()], numbers.iter().copied());
}

/// The result: geometry that can be read without anything else.
pub fn result(
    job: &Job,
    problem: &Problem,
    status: &Status,
    level: &Level,
    control_points: &Points,
    form: &Form,
) -> Bytes {
    #[derive(Serialize)]
    struct Head<'a, B, D, K> {
        id: uuid::Uuid,
        name: Option<&'a str>,
        kind: &'static str,
        state: &'static str,
        iteration: usize,
        error: Value,
        basis: B,
        degree: D,
        closed: Value,
        rational: Option<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        bad_weight: Option<Value>,
        knots: K,
    }
    let outline = job.outline();
    let head = Head {
        id: outline.id,
        name: outline.label.name.as_deref(),
        kind: kind(outline),
        state: status.state.name(),
        iteration: level.iteration,
        error: error(&level.error, problem),
        basis: per_direction(problem, |direction| direction.basis.name()),
        degree: per_direction(problem, |direction| direction.basis.degree()),
        closed: json!(per_direction(problem, Direction::is_closed)),
        rational: rational(problem),
        bad_weight: bad_weight(level, problem),
        knots: per_direction(problem, |direction| direction.basis.knots()),
    };
    let mut document = Document::new(&head, numbers(form, level), net_size(problem));
    document.arrays(&net_shape(problem), |document| {
        write_net(document, problem, Geometry::new(problem, control_points));
        if problem.directions().any(Direction::is_rational) {
            write_fixed_weights(document, problem);
        }
    });
    document.finish()
}
