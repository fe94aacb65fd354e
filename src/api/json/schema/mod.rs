//! JSON schemas of requests, for the description of the API. Those of answers stand beside the answers.
//!
//! Schemas of types with derived readers are derived, too. Where a reader is written by hand so is
//! its schema.
//!
//! - [`plain`]: what generators of clients understand;
//! - `numbers`: points, weights and numbers.

pub mod numbers;
pub mod plain;

use schemars::{Schema, json_schema};

/// Gives a type, or a name that stands for a schema, the schema that is written down.
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
pub(in crate::api) use schema_of;

/// One of these names.
pub fn names(description: &str, usual: &str, names: &[&str]) -> Schema {
    json_schema!({
        "description": description,
        "type": "string",
        "enum": names,
        "default": usual,
        "examples": [usual],
    })
}
