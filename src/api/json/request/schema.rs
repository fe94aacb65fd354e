//! What the schemas of requests say of kinds and settings, and their examples.

use schemars::Schema;
use serde_json::{Value, json};

use crate::fit::about::About;
use crate::fit::basis::BASES;
use crate::fit::method::METHODS;

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
