//! Arrays of numbers in answers: nested lists of numbers, or all of the numbers in base64.
//!
//! An answer holds a placeholder where an array belongs; [`super::document::Document`] writes the
//! numbers there. These types carry the schemas of the numbers.

use schemars::{Schema, json_schema};
use serde::{Serialize, Serializer};

use crate::model::schema::schema_of;

/// A placeholder for an array of a document.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArraySlot(pub(super) u8);

impl Serialize for ArraySlot {
    /// Serialised as bytes, which no other part of an answer is, so that the document recognises
    /// it.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&[self.0])
    }
}

/// A list of numbers.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(transparent)]
pub(super) struct NumberArray(pub(super) ArraySlot);

/// The knots of a direction. Only B-splines have some.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(transparent)]
pub(super) struct KnotArray(pub(super) Option<NumberArray>);

/// Points of a curve, or rows of points of a surface.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(transparent)]
pub(super) struct PointArray(pub(super) ArraySlot);

/// Weights of a curve, or rows of weights of a surface.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(transparent)]
pub(super) struct WeightArray(pub(super) ArraySlot);

fn number() -> Schema {
    json_schema!({"type": "number"})
}

fn numbers() -> Schema {
    json_schema!({"type": "array", "items": number()})
}

fn binary() -> Schema {
    json_schema!({"title": "Binary", "type": "string", "contentEncoding": "base64"})
}

/// A point of an answer.
pub(super) fn point() -> Schema {
    let coordinate = json_schema!({"type": ["number", "null"]});
    json_schema!({"type": "array", "items": coordinate, "minItems": 1, "maxItems": 3})
}

schema_of!(
    NumberArray,
    "NumberArray",
    json_schema!({
        "description": "Numbers as a list, or in base64.",
        "oneOf": [numbers(), binary()],
        "examples": [[0, 0.5, 1]],
    })
);

schema_of!(
    KnotArray,
    "KnotArray",
    json_schema!({
        "description": "Knots as a list, or in base64; null for the Ball bases, which have none.",
        "oneOf": [numbers(), binary(), {"type": "null"}],
        "examples": [[0, 0, 0, 0, 1, 2, 3, 3, 3, 3]],
    })
);

schema_of!(
    PointArray,
    "PointArray",
    json_schema!({
        "description": "Points: of a curve a list, of a surface rows of columns; coordinates at infinity are null. Or all of their numbers in base64.",
        "anyOf": [
            {"title": "Line", "type": "array", "items": point()},
            {"title": "Rows", "type": "array", "items": {"type": "array", "items": point()}},
            binary(),
        ],
        "examples": [[[0, 0], [1, 2], [3, 1], [4, 3]]],
    })
);

schema_of!(
    WeightArray,
    "WeightArray",
    json_schema!({
        "description": "Weights of control points: of a curve a list, of a surface rows of columns. Or all of them in base64.",
        "anyOf": [
            numbers(),
            {"title": "Rows", "type": "array", "items": numbers()},
            binary(),
        ],
        "examples": [[1, 1.5, 2, 1]],
    })
);
