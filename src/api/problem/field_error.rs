//! Validation errors of single fields, each with its location.

use schemars::json_schema;
use serde::Serialize;

use crate::model::schema::schema_of;
use piad_files::text;

/// The most characters of a detail. What clients have written is repeated in part only; this is a last safeguard.
pub(super) const LONGEST_DETAIL: usize = 1000;

/// The most characters of a location.
const LONGEST_PLACE: usize = 300;

/// A single validation error.
#[derive(Clone, Debug, Serialize)]
pub struct FieldError {
    /// The location: one of the names of [`Location`] with its value.
    #[serde(flatten)]
    pub place: Location,
    /// The reason.
    pub detail: String,
}

/// The location of an error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Location {
    /// At a JSON pointer (RFC 6901) into the body; the empty one is the whole of it.
    Pointer(String),
    /// In a query parameter.
    Parameter(String),
    /// In a header.
    Header(&'static str),
    /// In a line of a file, counted from 1.
    Line(usize),
    /// In a field of a protobuf message, such as `curve.points[34]`; the empty one is the message.
    Field(String),
}

impl FieldError {
    /// An error at a location; long texts are cut.
    pub(super) fn new(place: Location, detail: &str) -> Self {
        let cut = |text: String| text::cut(&text, LONGEST_PLACE).into_owned();
        Self {
            place: match place {
                Location::Pointer(pointer) => Location::Pointer(cut(pointer)),
                Location::Parameter(name) => Location::Parameter(cut(name)),
                place => place,
            },
            detail: text::cut(detail, LONGEST_DETAIL).into_owned(),
        }
    }

    /// Location and reason.
    pub(super) fn description(&self) -> String {
        let detail = &self.detail;
        match &self.place {
            Location::Pointer(pointer) if pointer.is_empty() => format!("/: {detail}"),
            Location::Pointer(pointer) => format!("{pointer}: {detail}"),
            Location::Parameter(name) => format!("query parameter {name}: {detail}"),
            Location::Header(name) => format!("header {name}: {detail}"),
            Location::Line(line) => format!("line {line}: {detail}"),
            Location::Field(field) if field.is_empty() => detail.clone(),
            Location::Field(field) => format!("{field}: {detail}"),
        }
    }
}

// One object with a field for each kind of location, so that generated clients need no choice of types.
schema_of!(
    FieldError,
    "FieldError",
    json_schema!({
        "type": "object",
        "properties": {
            "pointer": {
                "type": "string",
                "description": "A JSON pointer (RFC 6901) into the body.",
                "format": "json-pointer",
            },
            "parameter": {
                "type": "string",
                "description": "The query parameter.",
            },
            "header": {
                "type": "string",
                "description": "The header.",
            },
            "line": {
                "type": "integer",
                "minimum": 1,
                "description": "The line of a file of points, counted from 1.",
            },
            "field": {
                "type": "string",
                "description": "The path of a field of a protobuf message, such as `curve.points[34]`.",
            },
            "detail": {
                "type": "string",
                "description": "Why it is wrong.",
            },
        },
        "required": ["detail"],
        "description": "One thing that is wrong. It names its place in one way.",
        "examples": [{"pointer": "/curve/points/2", "detail": "point 2 equals point 1"}],
    })
);
