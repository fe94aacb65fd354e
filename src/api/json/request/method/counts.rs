//! Numbers of control points in JSON: given ones, or as few as will do.

use schemars::json_schema;
use serde::Serialize;

use crate::api::json::per_direction::{Pair, PerDirection};
use crate::api::json::read::values::Count;
use crate::api::json::read::{Numeral, Of, Read as _, Reader, Reading};
use crate::api::json::schema::schema_of;
use crate::model::short::quoted;

/// A number of control points, or `"auto"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(in crate::api) enum ControlPointCount {
    /// So many.
    Number(usize),
    /// As few as the tolerance needs.
    Auto(Auto),
}

/// The word `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::api) enum Auto {
    /// The only one.
    Auto,
}

impl Reader for Of<ControlPointCount> {
    type Value = ControlPointCount;

    fn expected(&self) -> String {
        "a number of control points, or \"auto\"".to_owned()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<ControlPointCount> {
        let count = usize::reader().number(value, at);
        count.map(ControlPointCount::Number)
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<ControlPointCount> {
        if value == "auto" {
            return Some(ControlPointCount::Auto(Auto::Auto));
        }
        at.mismatch(&self.expected(), &quoted(value));
        None
    }
}

/// What a request can say of the number of control points.
pub(in crate::api::json) enum ControlPoints {}

schema_of!(ControlPoints, "ControlPointCount", generator => {
    let count = json_schema!({"type": "integer", "minimum": 2});
    json_schema!({
        "description": "A number of control points, not greater than that of data points; on surfaces of both directions, or one for each. Or `auto`: as few as keep the largest distance within the tolerance, with knots that the fit chooses.",
        "oneOf": [
            count,
            {"type": "string", "const": "auto"},
            generator.subschema_for::<Pair<Count>>(),
        ],
        "examples": [12, "auto", {"u": 8, "v": 6}],
    })
});

/// The most control points.
pub(in crate::api::json) enum MostControlPoints {}

schema_of!(MostControlPoints, "MostControlPoints", generator => {
    let count = json_schema!({"type": "integer", "minimum": 2});
    json_schema!({
        "description": "The most control points of an automatic fit; on surfaces of both directions, or one for each.",
        "oneOf": [count, generator.subschema_for::<Pair<Count>>()],
        "examples": [200, {"u": 40, "v": 30}],
    })
});

/// The numbers of both directions, or `None` where both are automatic; mixed ones are an error.
pub(super) fn given(
    counts: PerDirection<ControlPointCount>,
) -> Result<Option<(usize, usize)>, &'static str> {
    use ControlPointCount::{Auto, Number};
    match counts.split() {
        (Number(u), Number(v)) => Ok(Some((u, v))),
        (Auto(_), Auto(_)) => Ok(None),
        _ => Err("either both directions have a number of control points, or both are \"auto\""),
    }
}
