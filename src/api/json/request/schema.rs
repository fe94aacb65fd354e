//! Schemas of requests: names and numbers that are read by hand, and which fields go together.

use schemars::{Schema, json_schema};
use serde_json::{Value, json};

use super::basis::{KnotRule, ParameterRule};
use super::edit::IterationRequest;
use super::method::{Index, Matrix, Omega};
use crate::api::json::per_direction::Pair;
use crate::api::json::read::values::Count;
use crate::api::json::schema::schema_of;
use crate::fit::about::About;
use crate::fit::basis::{BASES, MAX_DEGREE};
use crate::fit::method::{LARGEST, METHODS};

/// How data points get their parameters.
pub(super) enum Parameters {}

schema_of!(
    Parameters,
    "ParameterChoice",
    json_schema!({
        "description": "How the data points get their parameters: a rule, or strictly increasing numbers, one for each point; for a closed curve one more, at which it is back at the first.",
        "oneOf": [
            {"type": "string", "enum": ParameterRule::NAMES},
            {"type": "array", "items": {"type": "number"}, "minItems": 2},
        ],
        "default": "chord_length",
        "examples": ["centripetal", [0, 0.2, 0.7, 1]],
    })
);

/// The degree of a B-spline that is as usual otherwise.
pub(super) enum Degree {}

schema_of!(
    Degree,
    "Degree",
    json_schema!({
        "description": "The degree of a B-spline.",
        "type": "integer",
        "minimum": 1,
        "maximum": MAX_DEGREE,
        "examples": [3],
    })
);

/// Where the pieces of a B-spline meet.
pub(super) enum KnotChoice {}

schema_of!(
    KnotChoice,
    "KnotChoice",
    json_schema!({
        "description": "Where the pieces of a B-spline meet: at the parameters of the data, at averages of them, or at the numbers of a clamped knot vector.",
        "oneOf": [
            {"type": "string", "enum": KnotRule::NAMES},
            {"type": "array", "items": {"type": "number"}, "minItems": 4},
        ],
        "examples": ["data", [0, 0, 0, 0, 1, 1, 1, 1]],
    })
);

schema_of!(
    Omega,
    "Omega",
    json_schema!({
        "description": "A relaxation between 0 and 2, or \"auto\": 2 / (1 + λ_min), the best one.",
        "oneOf": [
            {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 2},
            {"type": "string", "const": "auto"},
        ],
        "default": "auto",
        "examples": ["auto", 1.5],
    })
);

schema_of!(
    Index,
    "PointIndex",
    json_schema!({
        "description": "The index of a data point, from 0: of a curve a number, of a surface [row, column].",
        "oneOf": [
            {"type": "integer", "minimum": 0},
            {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 2, "maxItems": 2},
        ],
        "examples": [17, [2, 3]],
    })
);

schema_of!(
    IterationRequest,
    "IterationChoice",
    json_schema!({
        "description": "The number of an iteration, or the last one.",
        "oneOf": [
            {"type": "integer", "minimum": 0},
            {"type": "string", "const": "last"},
        ],
        "default": "last",
        "examples": ["last", 5],
    })
);

schema_of!(
    Matrix,
    "Matrix",
    json_schema!({
        "description": "The rows of a square matrix, with a row and a column for each control point of the direction.",
        "type": "array",
        "items": {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 2,
            "maxItems": LARGEST,
        },
        "minItems": 2,
        "maxItems": LARGEST,
        "examples": [[[1, 0], [0, 1]]],
    })
);

/// The number of control points of a least-squares fit.
pub(super) enum ControlPoints {}

schema_of!(ControlPoints, "ControlPointCount", generator => {
    let count = json_schema!({"type": "integer", "minimum": 2});
    json_schema!({
        "description": "A number of control points, not greater than that of data points; on surfaces of both directions, or one for each.",
        "oneOf": [count, generator.subschema_for::<Pair<Count>>()],
        "examples": [12, {"u": 8, "v": 6}],
    })
});

/// The settings of the methods that have some.
const SETTINGS: [(&str, &[&str]); 6] = [
    ("weighted", &["omega"]),
    ("local", &["indices", "row_by_row"]),
    ("adaptive", &["threshold"]),
    ("extended", &["start"]),
    ("least_squares", &["control_points", "variant", "mu"]),
    ("custom", &["transform"]),
];

/// The settings of a method.
pub(in crate::api) fn settings(kind: &str) -> &'static [&'static str] {
    let entry = SETTINGS.iter().find(|(method, _)| *method == kind);
    entry.map_or(&[], |(_, settings)| settings)
}

/// Says which kinds of methods there are, and to which of them a setting belongs.
pub(super) fn method(schema: &mut Schema) {
    explain(schema, &METHODS);
    for (kind, settings) in SETTINGS {
        settings.iter().for_each(|name| belongs(schema, name, kind));
    }
}

/// Says which bases there are. Only B-splines have a degree and knots to choose.
pub(super) fn basis(schema: &mut Schema) {
    explain(schema, &BASES);
    for name in ["degree", "knots"] {
        belongs(schema, name, "bspline");
    }
}

/// Adds what the kinds mean to the description of an object.
fn explain(schema: &mut Schema, kinds: &[&About]) {
    let line = |about: &&About| format!("- `{}`: {}. {}", about.name, about.title, about.summary);
    let lines: Vec<String> = kinds.iter().map(line).collect();
    if let Some(Value::String(description)) = schema.get_mut("description") {
        description.push_str(" The name of a kind is short for an object with nothing else.\n\n");
        description.push_str(&lines.join("\n"));
    }
}

/// Adds to the description of a field to which kind it belongs.
fn belongs(schema: &mut Schema, field: &str, kind: &str) {
    let field = schema.pointer_mut(&format!("/properties/{field}/description"));
    if let Some(Value::String(description)) = field {
        description.push_str(&format!(" Only with `{kind}`."));
    }
}

pub(super) fn example_job() -> Value {
    json!({"name": "wing section", "curve": example_curve(), "stop": example_stop()})
}

pub(super) fn example_edit() -> Value {
    json!({"points": [example_move()], "method": {"kind": "local", "indices": [1, 2, 3]}})
}

pub(super) fn example_curve() -> Value {
    json!({
        "points": [[1.0, 0.0013], [0.95, 0.0114], [0.9, 0.0208], [0.8, 0.0375]],
        "basis": {"kind": "bspline", "degree": 3, "knots": "data"},
        "parameters": "chord_length",
    })
}

pub(super) fn example_surface() -> Value {
    json!({
        "points": [
            [[0, 0, 0], [0, 1, 1], [0, 2, 0]],
            [[1, 0, 1], [1, 1, 3], [1, 2, 1]],
            [[2, 0, 0], [2, 1, 1], [2, 2, 0]],
        ],
        "basis": {"u": {"kind": "bspline", "degree": 2}, "v": {"kind": "bernstein"}},
        "parameters": "uniform",
    })
}

pub(super) fn example_basis() -> Value {
    json!({"kind": "bspline", "degree": 3, "knots": "data"})
}

pub(super) fn example_stop() -> Value {
    json!({"tolerance": 1e-6, "max_iterations": 1000})
}

pub(super) fn example_method() -> Value {
    json!({"kind": "weighted", "omega": "auto"})
}

pub(super) fn example_move() -> Value {
    json!({"index": 2, "point": [0.9, 0.03]})
}
