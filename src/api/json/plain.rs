//! Rewrites schemas so that client generators make good types of them, without changing what they allow.

use schemars::Schema;
use serde_json::{Map, Value};

/// Simplifies all schemas of a part of the OpenAPI document.
pub(crate) fn simplify(part: &mut Value) {
    match part {
        Value::Object(fields) => {
            fields.values_mut().for_each(simplify);
            if let Some(format) = fields.get("type").and_then(format_of) {
                set_format(fields, format);
            }
            flatten(fields);
            tell_default(fields);
        }
        Value::Array(items) => items.iter_mut().for_each(simplify),
        _ => {}
    }
}

/// The width of numbers of a type, or of a list of types: without it clients read numbers of 32 bits,
/// or decimals.
fn format_of(types: &Value) -> Option<&'static str> {
    let has = |name| match types {
        Value::Array(types) => types.iter().any(|it| it == name),
        one => one == name,
    };
    if has("number") {
        return Some("double");
    }
    has("integer").then_some("int64")
}

/// Replaces formats of Rust's integer types, which other languages do not know.
fn set_format(fields: &mut Map<String, Value>, format: &str) {
    // No width that languages share.
    if fields.get("maximum").and_then(Value::as_u64) > Some(i64::MAX as u64) {
        fields.remove("format");
        return;
    }
    let format = match fields.get("format").and_then(Value::as_str) {
        Some("uint8" | "uint16") => "int32",
        _ => format,
    };
    fields.insert("format".to_owned(), format.into());
}

/// Moves defaults into the description: client generators make fields with a default required, or send
/// the default where it does not belong.
fn tell_default(fields: &mut Map<String, Value>) {
    let keywords = ["type", "anyOf", "oneOf", "$ref"];
    if !keywords.iter().any(|it| fields.contains_key(*it)) {
        return;
    }
    if let Some(usual) = fields.remove("default").filter(|it| !it.is_null()) {
        let description = fields.entry("description").or_insert("".into());
        let text = description.as_str().unwrap_or_default();
        let text = format!("{text} Default: `{usual}`.");
        *description = text.trim().into();
    }
}

/// Merges null into the choices of a `oneOf`, and replaces a choice of one schema by that schema.
fn flatten(fields: &mut Map<String, Value>) {
    let Some(Value::Array(choices)) = fields.get_mut("anyOf") else {
        return;
    };
    if let [Value::Object(choice), null] = choices.as_mut_slice()
        && choice.len() == 1
        && null["type"] == "null"
        && let Some(Value::Array(mut inner)) = choice.remove("oneOf")
    {
        inner.push(null.take());
        fields.remove("anyOf");
        fields.insert("oneOf".to_owned(), inner.into());
        return;
    }
    if choices.len() > 1 {
        return;
    }
    if let Some(Value::Object(only)) = choices.pop() {
        fields.remove("anyOf");
        for (name, value) in only {
            fields.entry(name).or_insert(value);
        }
    }
}

/// Removes null from the types of optional fields: answers leave them out instead.
pub(crate) fn never_null(schema: &mut Schema) {
    let required = schema.get("required").cloned().unwrap_or_default();
    let is_required = |name: &str| {
        required
            .as_array()
            .is_some_and(|it| it.iter().any(|it| it == name))
    };
    let Some(Value::Object(fields)) = schema.get_mut("properties") else {
        return;
    };
    for (_, field) in fields.iter_mut().filter(|(name, _)| !is_required(name)) {
        if let Some(types) = field.get_mut("type").filter(|types| types.is_array()) {
            let first = types.as_array().and_then(|types| types.first().cloned());
            *types = first.unwrap_or_default();
        }
        if let Some(Value::Array(choices)) = field.get_mut("anyOf") {
            choices.retain(|choice| choice["type"] != "null");
        }
    }
}
