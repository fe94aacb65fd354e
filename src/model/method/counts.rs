//! Numbers of control points: given ones, or the fewest for the tolerance.

use schemars::json_schema;

use crate::model::per_direction::{Count, Pair, PerDirection};
use crate::model::schema::schema_of;
use crate::model::serde_helpers::{Whole, number_or_word};

number_or_word!(
    /// A number of control points, or `"auto"`: as few as the tolerance needs.
    ControlPointCount(Whole),
    "auto",
    "a number of control points, or \"auto\""
);

/// The forms of the number of control points in a request.
pub(crate) enum ControlPoints {}

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
pub(crate) enum MostControlPoints {}

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
    match counts.map(|count| count.0).split() {
        (Some(Whole(u)), Some(Whole(v))) => Ok(Some((u, v))),
        (None, None) => Ok(None),
        _ => Err("either both directions have a number of control points, or both are \"auto\""),
    }
}
