//! Schemas of what the server sends: jobs, events, levels and what it says of itself.
//!
//! Fields may be added to objects, so clients ignore those that they do not know.

mod event;
mod job;
mod level;
mod server;

use serde_json::{Map, Value, json};

use super::operation::reference;

/// All schemas of answers, by name.
pub(super) fn schemas() -> Map<String, Value> {
    let groups = [
        job::schemas(),
        event::schemas(),
        level::schemas(),
        server::schemas(),
    ];
    let all = groups.into_iter().flatten();
    all.map(|(name, schema)| (name.to_owned(), schema))
        .collect()
}

/// A schema and its name.
type Named = (&'static str, Value);

/// An object with fields that are always there and others that may be.
fn object(
    description: &str,
    always: &[(&str, Value)],
    sometimes: &[(&str, Value)],
    example: Value,
) -> Value {
    let names: Vec<&str> = always.iter().map(|(name, _)| *name).collect();
    let fields = always.iter().chain(sometimes).cloned();
    let fields: Map<String, Value> = fields
        .map(|(name, schema)| (name.to_owned(), schema))
        .collect();
    json!({
        "description": description,
        "type": "object",
        "properties": fields,
        "required": names,
        "examples": [example],
    })
}

fn text(description: &str) -> Value {
    json!({"description": description, "type": "string"})
}

fn path(description: &str) -> Value {
    json!({"description": description, "type": "string", "format": "uri-reference"})
}

fn time(description: &str) -> Value {
    json!({"description": description, "type": "string", "format": "date-time"})
}

fn count(description: &str) -> Value {
    json!({"description": description, "type": "integer", "minimum": 0})
}

fn number(description: &str) -> Value {
    json!({"description": description, "type": "number"})
}

fn flag(description: &str) -> Value {
    json!({"description": description, "type": "boolean"})
}

fn list(description: &str, items: Value) -> Value {
    json!({"description": description, "type": "array", "items": items})
}

/// Another schema, and what it is for here.
fn a(name: &str, description: &str) -> Value {
    let mut schema = reference("schemas", name);
    schema["description"] = json!(description);
    schema
}

/// The same, or null.
fn or_null(mut schema: Value) -> Value {
    if let Some(name) = schema["type"].as_str() {
        schema["type"] = json!([name, "null"]);
        return schema;
    }
    let description = schema
        .as_object_mut()
        .and_then(|schema| schema.shift_remove_entry("description"));
    let mut either = Map::from_iter(description);
    either.insert("anyOf".to_owned(), json!([schema, {"type": "null"}]));
    either.into()
}

/// A list of numbers, or all of them in base64.
fn numbers() -> Value {
    json!({"anyOf": [
        {"type": "array", "items": {"type": "number"}},
        {"type": "string", "contentEncoding": "base64"},
    ]})
}

/// One value for a curve, `{"u": …, "v": …}` for a surface.
fn per_direction(description: &str, value: Value) -> Value {
    let mut u = value.clone();
    u["description"] = json!("Of the rows.");
    let mut v = value.clone();
    v["description"] = json!("Of the columns.");
    json!({
        "description": description,
        "anyOf": [
            value,
            {
                "title": "PerDirection",
                "type": "object",
                "properties": {"u": u, "v": v},
                "required": ["u", "v"],
            },
        ],
    })
}
