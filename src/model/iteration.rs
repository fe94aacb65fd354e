//! The iteration that an edit or foot points start from.

use schemars::json_schema;

use super::schema::schema_of;
use super::serde_helpers::{Whole, number_or_word};

number_or_word!(
    /// The level of another job to start from: a number or `"last"`.
    IterationChoice(Whole),
    "last",
    "the number of an iteration, or \"last\""
);

impl IterationChoice {
    /// The iteration with this number.
    pub(crate) fn of(number: u64) -> Self {
        // Too large for this machine is beyond every job.
        Self(Some(Whole(usize::try_from(number).unwrap_or(usize::MAX))))
    }

    /// The number; `None` for the last one.
    pub(crate) fn number(self) -> Option<usize> {
        self.0.map(|Whole(k)| k)
    }
}

schema_of!(
    IterationChoice,
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
