//! Common parts of the schemas of requests, and their examples.
//!
//! Schemas of types with derived readers are derived, too. Types with a reader written by hand have
//! a schema written by hand.

use schemars::{Schema, json_schema};
use serde_json::{Value, json};

use super::named::Named;
use piad_fit::basis::BASES;
use piad_fit::engine::KindInfo;

/// Gives a type, or the name of a schema, a schema written by hand.
macro_rules! schema_of {
    ($type:ty, $name:literal, $generator:ident => $schema:expr) => {
        impl schemars::JsonSchema for $type {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                $name.into()
            }

            fn json_schema($generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                $schema
            }
        }
    };
    ($type:ty, $name:literal, $schema:expr) => {
        schema_of!($type, $name, _generator => $schema);
    };
}
pub(crate) use schema_of;

/// One of the names of an enumeration.
pub(crate) fn names<T: Named>(description: &str) -> Schema {
    let names = T::names();
    json_schema!({
        "description": description,
        "type": "string",
        "enum": names,
        "default": names.first(),
        "examples": names.first().as_slice(),
    })
}

/// Describes the kinds of bases. Only B-splines have a degree and knots to choose.
pub(super) fn basis(schema: &mut Schema) {
    explain(schema, &BASES);
    for name in ["degree", "knots"] {
        belongs(schema, name, &["bspline"]);
    }
}

/// Adds what the kinds mean to the description of an object.
pub(super) fn explain(schema: &mut Schema, kinds: &[&KindInfo]) {
    let line =
        |about: &&KindInfo| format!("- `{}`: {}. {}", about.name, about.title, about.summary);
    let lines: Vec<String> = kinds.iter().map(line).collect();
    if let Some(Value::String(description)) = schema.get_mut("description") {
        description.push_str(" The name of a kind is short for an object with nothing else.\n\n");
        description.push_str(&lines.join("\n"));
    }
}

/// Adds to the description of a field to which kinds it belongs.
pub(super) fn belongs(schema: &mut Schema, field: &str, kinds: &[&str]) {
    let field = schema.pointer_mut(&format!("/properties/{field}/description"));
    if let Some(Value::String(description)) = field {
        let kinds: Vec<String> = kinds.iter().map(|kind| format!("`{kind}`")).collect();
        description.push_str(&format!(" Only with {}.", kinds.join(", ")));
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

pub(super) fn example_move() -> Value {
    json!({"index": 2, "point": [0.9, 0.03]})
}
