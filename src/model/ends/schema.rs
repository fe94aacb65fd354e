//! The schemas of how curves and surfaces end.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::EndWord;
use crate::model::named::Named;
use crate::model::schema::schema_of;
use piad_fit::data::MAX_DIMENSION;

/// The ends of a curve: a word, or an end for each side.
pub(crate) enum CurveEnds {}

/// The ends of both sides of a curve, and one with vectors.
enum CurveEndPair {}
enum CurveEnd {}

/// The ends of a surface: those of both directions, or of each that is not closed.
pub(crate) enum SurfaceEnds {}

/// Ends for each direction that has some, and those of one direction.
enum SurfaceEndsPair {}
enum DirectionEnds {}

/// The ends of both sides of a direction of a surface, and one with vectors.
enum SurfaceEndPair {}
enum SurfaceEnd {}

schema_of!(CurveEnds, "CurveEnds", generator => ends::<CurveEndPair>(generator));
schema_of!(CurveEndPair, "CurveEndPair", generator => pair::<CurveEnd>(json!([0.0, 1.0]), generator));
schema_of!(
    CurveEnd,
    "CurveEnd",
    end(&vector(), "a vector", &json!([0.0, 1.0]))
);

schema_of!(DirectionEnds, "DirectionEnds", generator => ends::<SurfaceEndPair>(generator));
schema_of!(SurfaceEndPair, "SurfaceEndPair", generator => pair::<SurfaceEnd>(boundary(), generator));
schema_of!(SurfaceEnd, "SurfaceEnd", {
    let vectors = json_schema!({"type": "array", "items": vector(), "minItems": 2});
    end(
        &vectors,
        "a vector for each data point of the boundary",
        &boundary(),
    )
});

schema_of!(SurfaceEnds, "SurfaceEnds", generator => {
    let mut schema = ends::<SurfaceEndPair>(generator);
    let each = generator.subschema_for::<SurfaceEndsPair>().to_value();
    if let Some(Value::Array(choices)) = schema.get_mut("oneOf") {
        choices.push(each);
    }
    schema
});

schema_of!(SurfaceEndsPair, "SurfaceEndsPair", generator => {
    let of = |which: &str, generator: &mut SchemaGenerator| {
        described(DirectionEnds::json_schema(generator), which)
    };
    json_schema!({
        "description": "How each direction ends; closed ones are left out.",
        "type": "object",
        "properties": {
            "u": of("How u ends, from row to row: at the first and the last row.", generator),
            "v": of("How v ends, from column to column: at the first and the last column.", generator),
        },
        "minProperties": 1,
        "additionalProperties": false,
        "examples": [{"v": "natural"}],
    })
});

/// A vector.
fn vector() -> Schema {
    json_schema!({
        "type": "array",
        "items": {"type": "number"},
        "minItems": 1,
        "maxItems": MAX_DIMENSION,
    })
}

/// Vectors of a boundary, for example.
fn boundary() -> Value {
    json!([[0.0, 1.0, 0.0], [0.0, 1.0, 0.5]])
}

fn described(mut schema: Schema, what: &str) -> Schema {
    schema.insert("description".to_owned(), what.into());
    schema
}

/// A word, or an end for each side.
fn ends<Pair: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "description": "How a B-spline with knots at the data ends: with estimated derivatives, with copies of its end points (repeated), without second derivative (natural), or with derivatives that are given.",
        "oneOf": [
            {"type": "string", "enum": EndWord::names()},
            generator.subschema_for::<Pair>(),
        ],
        "default": "estimated",
        "examples": ["natural"],
    })
}

/// An end for each side; `example` is a tangent.
fn pair<End: JsonSchema>(example: Value, generator: &mut SchemaGenerator) -> Schema {
    let given = generator.subschema_for::<End>();
    let side = |which: &str| {
        json_schema!({
            "description": format!("How it ends at its {which} parameter."),
            "oneOf": [{"type": "string", "enum": EndWord::names()}, given],
            "default": "estimated",
        })
    };
    json_schema!({
        "description": "How both sides end.",
        "type": "object",
        "properties": {"start": side("first"), "end": side("last")},
        "minProperties": 1,
        "additionalProperties": false,
        "examples": [{"start": {"tangent": example}, "end": "natural"}],
    })
}

/// An end with vectors of one order, which are `one`; `example` is a tangent.
fn end(vectors: &Schema, one: &str, example: &Value) -> Schema {
    let field = |what: String| described(vectors.clone(), &what);
    let orders = json_schema!({"type": "array", "items": vectors, "minItems": 1});
    json_schema!({
        "description": "An end with derivatives with respect to the parameter: one of the fields is given.",
        "type": "object",
        "properties": {
            "derivative": field(format!("The first derivative: {one}.")),
            "derivatives": described(orders, &format!("Derivatives of the first order and further ones, for each {one}; those that are missing are estimated.")),
            "tangent": field(format!("The direction of the first derivative, {one}. Its length is that of the polygon through the points over the range of the parameters.")),
        },
        "minProperties": 1,
        "maxProperties": 1,
        "additionalProperties": false,
        "examples": [{"tangent": example}],
    })
}
