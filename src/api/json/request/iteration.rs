//! The JSON of the iteration that an edit starts from.

use schemars::json_schema;

use crate::api::json::schema::schema_of;
use crate::model::either::{Whole, number_or_word};

number_or_word!(
    /// The level of the parent to start from: a number or `"last"`.
    IterationRequest(Whole),
    "last",
    "the number of an iteration, or \"last\""
);

impl IterationRequest {
    /// The number; none of the last one.
    pub fn number(self) -> Option<usize> {
        self.0.map(|Whole(k)| k)
    }
}

schema_of!(
    IterationRequest,
    "IterationChoice",
    json_schema!({
        "description": "The number of an iteration, or the last one.",
        "oneOf": [
            {"type": "integer", "minimum": 0},
            {"type": "string", "const": "last"},
        ],
        "default": "last",
        "examples": ["last", 5],
    })
);
