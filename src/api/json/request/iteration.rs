//! The JSON of the iteration that an edit starts from.

use schemars::json_schema;

use crate::api::json::read::{Numeral, Of, Reader, Reading};
use crate::api::json::schema::schema_of;
use crate::model::short::quoted;

/// The level of the parent to start from: a number or `"last"`.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) struct IterationRequest(pub(in crate::api) Option<usize>);

impl Reader for Of<IterationRequest> {
    type Value = IterationRequest;

    fn expected(&self) -> String {
        "the number of an iteration, or \"last\"".to_owned()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<IterationRequest> {
        let iteration = value.whole();
        if iteration.is_none() {
            at.mismatch(&self.expected(), &value.to_string());
        }
        // Too large for this machine is beyond every job.
        iteration.map(|k| IterationRequest(Some(usize::try_from(k).unwrap_or(usize::MAX))))
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<IterationRequest> {
        if value == "last" {
            return Some(IterationRequest(None));
        }
        at.mismatch(&self.expected(), &quoted(value));
        None
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
