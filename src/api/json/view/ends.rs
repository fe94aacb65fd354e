//! How directions end, as it is shown.

use schemars::json_schema;
use serde::Serialize;
use serde_json::{Value, json};

use crate::api::json::per_direction::PerDirection;
use crate::api::json::schema::schema_of;
use crate::fit::ends::{End, Ends};
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// The JSON that asks for these ends.
pub(super) fn written(ends: Option<&Ends>, surface: bool) -> Value {
    let Some(Ends { start, end }) = ends else {
        return Value::Null;
    };
    let one = |vectors: &Points| {
        let vector = |index| json!(vectors.point(index).collect::<Vec<f64>>());
        match surface {
            false => vector(0),
            true => (0..vectors.len()).map(vector).collect(),
        }
    };
    let side = |end: &End| match end {
        End::Estimated | End::Repeated | End::Natural => json!(end.name()),
        End::Derivatives(orders) => {
            let orders: Vec<Value> = orders.iter().map(|it| one(it)).collect();
            json!({"derivatives": orders})
        }
        End::Tangent(vectors) => json!({"tangent": one(vectors)}),
    };
    match (side(start), side(end)) {
        (start, end) if start == end && start.is_string() => start,
        (start, end) => json!({"start": start, "end": end}),
    }
}

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

    /// Those of all directions.
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
