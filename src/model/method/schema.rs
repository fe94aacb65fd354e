//! The schema of methods.

use std::borrow::Cow;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};

use super::{
    AdaptiveInput, ConvexInput, CustomInput, ExtendedInput, LeastSquaresInput, LocalInput,
    MethodInput, MethodKind, WeightedInput,
};
use crate::model::schema;
use piad_fit::method::METHODS;

/// One object with the settings of all methods, each with its methods in the description: generated
/// clients have one type for it.
impl JsonSchema for MethodInput {
    fn schema_name() -> Cow<'static, str> {
        "Method".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut kind = generator.subschema_for::<MethodKind>();
        kind.insert("description".to_owned(), "The kind of the method.".into());
        let mut all = Map::from_iter([("kind".to_owned(), kind.to_value())]);
        let mut owners: Vec<(String, Vec<&str>)> = Vec::new();
        for (kind, mut schema) in schemas(generator) {
            for (name, setting) in fields(&mut schema) {
                match owners.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, kinds)) => kinds.push(kind),
                    None => owners.push((name.clone(), vec![kind])),
                }
                all.entry(name).or_insert(setting);
            }
        }
        let mut schema = json_schema!({
            "description": "How the control points move from iteration to iteration.",
            "type": "object",
            "properties": all,
            "required": ["kind"],
            "additionalProperties": false,
            "examples": [{"kind": "weighted", "omega": "auto"}],
        });
        schema::explain(&mut schema, &METHODS);
        for (name, kinds) in owners {
            schema::belongs(&mut schema, &name, &kinds);
        }
        schema
    }
}

/// The schemas of the settings of methods that have some.
fn schemas(generator: &mut SchemaGenerator) -> [(&'static str, Schema); 7] {
    [
        ("weighted", WeightedInput::json_schema(generator)),
        ("local", LocalInput::json_schema(generator)),
        ("adaptive", AdaptiveInput::json_schema(generator)),
        ("convex", ConvexInput::json_schema(generator)),
        ("extended", ExtendedInput::json_schema(generator)),
        ("least_squares", LeastSquaresInput::json_schema(generator)),
        ("custom", CustomInput::json_schema(generator)),
    ]
}

/// The fields of a schema.
fn fields(schema: &mut Schema) -> Map<String, Value> {
    match schema.remove("properties") {
        Some(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}

/// The settings of a method.
pub(crate) fn settings_of(kind: &str) -> Vec<String> {
    static SETTINGS: LazyLock<Vec<(&str, Vec<String>)>> = LazyLock::new(|| {
        let schemas = schemas(&mut SchemaGenerator::default()).into_iter();
        let names = |mut schema| fields(&mut schema).into_iter().map(|(name, _)| name);
        let own = schemas.map(|(kind, schema)| (kind, names(schema).collect()));
        own.collect()
    });
    let entry = SETTINGS.iter().find(|(method, _)| *method == kind);
    entry.map_or_else(Vec::new, |(_, settings)| settings.clone())
}
