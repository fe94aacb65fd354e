//! Where in a message an error is: JSON pointers of the model become paths of fields.

use super::messages::{self as pb, job_input::Geometry, method::Kind};
use crate::api::problem::{Place, Problem};

/// How the arrays of a message are laid out.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    dimension: usize,
    /// The number of columns of a surface.
    columns: Option<usize>,
    /// Edits: for each point that changes, its entry in `moved` and in `weighted`.
    pub(in crate::api) changes: Vec<(Option<usize>, Option<usize>)>,
    /// The numbers of columns of the matrices of a transform.
    transform: (usize, usize),
}

impl Layout {
    /// The layout of a job.
    pub fn of(input: &pb::JobInput) -> Self {
        let (dimension, columns) = match &input.geometry {
            None => (1, None),
            Some(Geometry::Curve(curve)) => (curve.dimension, None),
            Some(Geometry::Surface(surface)) => (surface.dimension, Some(surface.columns as usize)),
        };
        Self {
            dimension: dimension as usize,
            columns,
            changes: Vec::new(),
            transform: transform(input.method.as_ref()),
        }
    }

    /// The layout of an edit.
    pub(in crate::api) fn of_edit(
        dimension: usize,
        columns: Option<usize>,
        method: Option<&pb::Method>,
    ) -> Self {
        Self {
            dimension,
            columns,
            changes: Vec::new(),
            transform: transform(method),
        }
    }

    /// The problem with fields of the message instead of JSON pointers.
    pub fn name(&self, mut problem: Problem) -> Problem {
        problem.name_fields(|place| match place {
            Place::Pointer(pointer) => Some(self.field(pointer)),
            _ => None,
        });
        problem
    }

    /// The field at a JSON pointer of the model.
    pub(in crate::api) fn field(&self, pointer: &str) -> String {
        let parts: Vec<&str> = pointer.split('/').skip(1).collect();
        match parts.as_slice() {
            [] | [""] => String::new(),
            ["points", place @ ..] => self.change(place),
            ["weights", axis @ ("u" | "v"), place @ ..] => {
                format!("weights.{axis}{}", index(place))
            }
            ["weights", place @ ..] => format!("weights.values{}", self.flat(place, 1)),
            [root, "points", place @ ..] => {
                format!("{root}.points{}", self.flat(place, self.dimension))
            }
            ["surface", part, axis @ ("u" | "v"), rest @ ..] => {
                format!("surface.{axis}.{}", part_of_direction(part, rest))
            }
            ["surface", "weights", place @ ..] => format!("surface.weights{}", self.flat(place, 1)),
            [root @ ("curve" | "surface"), part, rest @ ..] => {
                format!("{root}.{}", part_of_direction(part, rest))
            }
            ["method", "transform", "v", place @ ..] => {
                entry("transform_v", place, self.transform.1)
            }
            ["method", "transform", "u", place @ ..] | ["method", "transform", place @ ..] => {
                entry("transform_u", place, self.transform.0)
            }
            ["method", rest @ ..] => method(rest),
            ["stream", name, place @ ..] => format!("stream.{}{}", option(name), index(place)),
            parts => parts.join("."),
        }
    }

    /// The place in a flat array of the point in a list or a grid; of the first one of a row.
    fn flat(&self, place: &[&str], numbers: usize) -> String {
        let number = |text: &str| text.parse::<usize>().unwrap_or(0);
        let point = match (place, self.columns) {
            ([], _) => return String::new(),
            ([i], None) => number(i),
            ([i], Some(columns)) => number(i) * columns,
            ([i, j, ..], columns) => number(i) * columns.unwrap_or(1) + number(j),
        };
        format!("[{}]", point * numbers)
    }

    /// A point that an edit changes.
    fn change(&self, place: &[&str]) -> String {
        let [k, part @ ..] = place else {
            return "points".to_owned();
        };
        let entry = k.parse().ok().and_then(|k: usize| self.changes.get(k));
        let (moved, weighted) = entry.copied().unwrap_or_default();
        match (part, moved, weighted) {
            (["weight"], _, Some(k)) => format!("point_weights[{k}]"),
            (["index"], Some(k), _) => format!("moved[{k}]"),
            (_, Some(k), _) => format!("points[{}]", k * self.dimension),
            (_, None, Some(k)) => format!("weighted[{k}]"),
            (_, None, None) => "points".to_owned(),
        }
    }
}

/// The field of a message that has the choice of a stream which a query gives this name.
pub fn option(name: &str) -> &str {
    match name {
        "samples" => "samples_u",
        "milestones" => "milestones.distances",
        "encoding" => "json_encoding",
        "digits" => "json_digits",
        name => name,
    }
}

/// The problem of a call: with choices of its stream as fields of the message.
pub fn of_call(mut problem: Problem) -> Problem {
    problem.name_fields(|place| match place {
        Place::Parameter(name) => Some(format!("stream.{}", option(name))),
        _ => None,
    });
    problem
}

fn part_of_direction(part: &str, rest: &[&str]) -> String {
    match (part, rest) {
        ("parameters", []) => "parameters".to_owned(),
        ("parameters", place) => format!("parameters.values{}", index(place)),
        ("basis", ["knots", place @ ..]) => format!("basis.knots{}", index(place)),
        ("basis", rest) => ["basis"]
            .into_iter()
            .chain(rest.iter().copied())
            .collect::<Vec<_>>()
            .join("."),
        (part, place) => format!("{part}{}", index(place)),
    }
}

fn method(parts: &[&str]) -> String {
    let [setting, rest @ ..] = parts else {
        return "method".to_owned();
    };
    let kind = match *setting {
        "omega" => "weighted",
        "indices" | "row_by_row" => "local",
        "threshold" => "adaptive",
        "start" => "extended",
        _ => "least_squares",
    };
    match (*setting, rest) {
        ("control_points", ["v"]) => format!("method.{kind}.control_points_v"),
        ("control_points", _) => format!("method.{kind}.control_points_u"),
        (setting, place) => format!("method.{kind}.{setting}{}", index(place)),
    }
}

/// The numbers of columns of the matrices of a transform, which are square.
fn transform(method: Option<&pb::Method>) -> (usize, usize) {
    match method.and_then(|method| method.kind.as_ref()) {
        Some(Kind::Custom(custom)) => {
            let columns = |entries: &[f64]| entries.len().isqrt();
            (columns(&custom.transform_u), columns(&custom.transform_v))
        }
        _ => (0, 0),
    }
}

/// An entry of a matrix, or the first one of a row.
fn entry(field: &str, place: &[&str], columns: usize) -> String {
    let number = |text: &str| text.parse::<usize>().unwrap_or(0);
    let place = match place {
        [] => String::new(),
        [row] => format!("[{}]", number(row) * columns),
        [row, column, ..] => format!("[{}]", number(row) * columns + number(column)),
    };
    format!("method.custom.{field}{place}")
}

/// The place in an array.
fn index(place: &[&str]) -> String {
    place.iter().map(|index| format!("[{index}]")).collect()
}
