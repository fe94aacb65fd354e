//! The schemas of a value for both directions of a surface, or of one for each.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use crate::fit::invalid::Axis;
pub use crate::model::either::PerDirection;

/// The schema of a whole number, zero or greater, where a name is needed for it.
pub enum Count {}

impl JsonSchema for Count {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "integer", "minimum": 0})
    }
}

/// What a JSON pointer has for a direction, if there is one value for each.
pub fn direction(each: bool, axis: Axis) -> &'static str {
    match (each, axis) {
        (false, _) => "",
        (true, Axis::U) => "/u",
        (true, Axis::V) => "/v",
    }
}

impl<T: JsonSchema> JsonSchema for PerDirection<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("PerDirectionOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut choices = one_of(T::json_schema(generator), generator.subschema_for::<T>());
        choices.push(generator.subschema_for::<Pair<T>>().to_value());
        json_schema!({"oneOf": choices})
    }
}

/// The choices of a schema. Generators of clients understand a reference to an object among the choices
/// of another schema, but no reference to what is a choice itself, a list or a name.
fn one_of(mut schema: Schema, reference: Schema) -> Vec<Value> {
    if let Some(Value::Array(choices)) = schema.get("oneOf") {
        return choices.clone();
    }
    if schema.get("properties").is_some() {
        return vec![reference.to_value()];
    }
    for about in ["description", "examples"] {
        schema.remove(about);
    }
    vec![schema.to_value()]
}

/// The schema of a value for each direction, under a name of its own: generated clients have a type
/// for it.
pub struct Pair<T>(PhantomData<T>);

impl<T: JsonSchema> JsonSchema for Pair<T> {
    fn schema_name() -> Cow<'static, str> {
        let name = T::schema_name();
        let (first, rest) = name.split_at(1);
        format!("{}{rest}Pair", first.to_uppercase()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = T::json_schema(generator);
        let is_boolean = one.get("type").is_some_and(|it| it == "boolean");
        let example = match one.get("examples") {
            Some(examples) => examples[0].clone(),
            None if is_boolean => Value::Bool(true),
            None => Value::from(8),
        };
        let value = |description: &str, generator: &mut SchemaGenerator| {
            let mut schema = generator.subschema_for::<T>();
            schema.insert("description".to_owned(), json!(description));
            schema
        };
        json_schema!({
            "description": "A value for each direction of a surface.",
            "type": "object",
            "properties": {
                "u": value("For u, from row to row.", generator),
                "v": value("For v, from column to column.", generator),
            },
            "required": ["u", "v"],
            "additionalProperties": false,
            "examples": [{"u": example, "v": example}],
        })
    }
}
