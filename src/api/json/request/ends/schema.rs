//! The schemas of how curves and surfaces end.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::EndWord;
use crate::model::named::Named;
use crate::model::shape::MAX_DIMENSION;

/// The schema of the ends of a curve: a word, or an end for each side.
pub(in super::super) enum CurveEnds {}

/// The schema of the ends of a direction of a surface.
enum DirectionEnds {}

/// The schema of the ends of a surface: those of both directions, or of each that is not closed.
pub(in super::super) enum SurfaceEnds {}

/// What the schemas of curves and of surfaces differ in.
trait Boundary {
    const NAME: &'static str;
    const ONE: &'static str;

    /// The schema of the vectors of one order.
    fn vectors() -> Schema;
    fn example() -> serde_json::Value;
}

/// The schema of a vector.
fn vector() -> Schema {
    json_schema!({
        "type": "array",
        "items": {"type": "number"},
        "minItems": 1,
        "maxItems": MAX_DIMENSION,
    })
}

impl Boundary for CurveEnds {
    const NAME: &'static str = "Curve";
    const ONE: &'static str = "a vector";

    fn vectors() -> Schema {
        vector()
    }

    fn example() -> serde_json::Value {
        serde_json::json!([0.0, 1.0])
    }
}

impl Boundary for DirectionEnds {
    const NAME: &'static str = "Surface";
    const ONE: &'static str = "a vector for each data point of the boundary";

    fn vectors() -> Schema {
        json_schema!({"type": "array", "items": vector(), "minItems": 2})
    }

    fn example() -> serde_json::Value {
        serde_json::json!([[0.0, 1.0, 0.0], [0.0, 1.0, 0.5]])
    }
}

/// An end with vectors.
struct GivenEnd<B>(PhantomData<B>);

/// An end for each side.
struct EndPair<B>(PhantomData<B>);

impl<B: Boundary> JsonSchema for GivenEnd<B> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}End", B::NAME).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let field = |schema: Schema, what: String| {
            let mut schema = schema;
            schema.insert("description".to_owned(), what.into());
            schema
        };
        let one = B::ONE;
        json_schema!({
            "description": "An end with derivatives with respect to the parameter: one of the fields is given.",
            "type": "object",
            "properties": {
                "derivative": field(B::vectors(), format!("The first derivative: {one}.")),
                "derivatives": field(
                    json_schema!({"type": "array", "items": B::vectors(), "minItems": 1}),
                    format!("Derivatives of the first order and further ones, for each {one}; those that are missing are estimated."),
                ),
                "tangent": field(B::vectors(), format!("The direction of the first derivative, {one}. Its length is that of the polygon through the points over the range of the parameters.")),
            },
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": false,
            "examples": [{"tangent": B::example()}],
        })
    }
}

impl<B: Boundary> JsonSchema for EndPair<B> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}EndPair", B::NAME).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let given = generator.subschema_for::<GivenEnd<B>>();
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
            "examples": [{"start": {"tangent": B::example()}, "end": "natural"}],
        })
    }
}

/// The schema of ends: a word or an object.
fn ends<B: Boundary>(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "description": "How a B-spline with knots at the data ends: with estimated derivatives, with copies of its end points (repeated), without second derivative (natural), or with derivatives that are given.",
        "oneOf": [
            {"type": "string", "enum": EndWord::names()},
            generator.subschema_for::<EndPair<B>>(),
        ],
        "default": "estimated",
        "examples": ["natural"],
    })
}

impl JsonSchema for CurveEnds {
    fn schema_name() -> Cow<'static, str> {
        "CurveEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        ends::<Self>(generator)
    }
}

impl JsonSchema for DirectionEnds {
    fn schema_name() -> Cow<'static, str> {
        "DirectionEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        ends::<Self>(generator)
    }
}

/// Ends for each direction that has some.
enum EachEnds {}

impl JsonSchema for EachEnds {
    fn schema_name() -> Cow<'static, str> {
        "SurfaceEndsPair".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut of = |which: &str| {
            let mut schema = DirectionEnds::json_schema(generator);
            schema.insert("description".to_owned(), which.into());
            schema
        };
        json_schema!({
            "description": "How each direction ends; closed ones are left out.",
            "type": "object",
            "properties": {
                "u": of("How u ends, from row to row: at the first and the last row."),
                "v": of("How v ends, from column to column: at the first and the last column."),
            },
            "minProperties": 1,
            "additionalProperties": false,
            "examples": [{"v": "natural"}],
        })
    }
}

impl JsonSchema for SurfaceEnds {
    fn schema_name() -> Cow<'static, str> {
        "SurfaceEnds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = ends::<DirectionEnds>(generator);
        let each = generator.subschema_for::<EachEnds>().to_value();
        if let Some(serde_json::Value::Array(choices)) = schema.get_mut("oneOf") {
            choices.push(each);
        }
        schema
    }
}
