//! The widths of numbers in schemas: without them generated clients read numbers of 32 bits, or decimals.

use serde_json::{Map, Value};

/// Says of each number in schemas how wide it is.
pub(super) fn tell(part: &mut Value) {
    match part {
        Value::Object(fields) => {
            if let Some(format) = fields.get("type").and_then(format_of) {
                set(fields, format);
            }
            fields.values_mut().for_each(tell);
        }
        Value::Array(items) => items.iter_mut().for_each(tell),
        _ => {}
    }
}

/// The format of numbers of a type, or of a list of types.
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

/// Sizes of Rust have names that other languages do not know; what has 16 bits is signed with 32.
fn set(fields: &mut Map<String, Value>, format: &str) {
    let format = match fields.get("format").and_then(Value::as_str) {
        Some("uint8" | "uint16") => "int32",
        _ => format,
    };
    fields.insert("format".to_owned(), format.into());
}
