//! The ends of directions in answers.

use schemars::json_schema;
use serde::Serialize;

use crate::model::per_direction::PerDirection;
use crate::model::schema::schema_of;
use piad_fit::basis::{End, Ends};
use piad_fit::engine::Problem;

/// The rules by which a direction ends; null where there is nothing to choose.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum EndRules {
    /// There is nothing to choose.
    None,
    /// The rules of both sides.
    Sides {
        start: &'static str,
        end: &'static str,
    },
}

schema_of!(
    EndRules,
    "EndRules",
    json_schema!({
        "description": "The rules by which a direction ends; null where there is nothing to choose, as in closed directions and with other knots than those at the data.",
        "type": ["object", "null"],
        "properties": {
            "start": {"description": "The rule at its first parameter.", "type": "string", "enum": End::NAMES},
            "end": {"description": "The rule at its last parameter.", "type": "string", "enum": End::NAMES},
        },
        "required": ["start", "end"],
        "additionalProperties": false,
        "examples": [{"start": "estimated", "end": "estimated"}],
    })
);

impl EndRules {
    fn new(ends: Option<&Ends>) -> Self {
        ends.map_or(Self::None, |Ends { start, end }| Self::Sides {
            start: start.name(),
            end: end.name(),
        })
    }

    /// The rules of all directions.
    pub(super) fn of(problem: &Problem) -> PerDirection<Self> {
        let request = problem.request();
        let u = Self::new(request.u.ends.as_ref());
        match &request.v {
            None => PerDirection::Both(u),
            Some(v) => PerDirection::Each {
                u,
                v: Self::new(v.ends.as_ref()),
            },
        }
    }
}
