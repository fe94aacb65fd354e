//! The places where curvatures are least and largest, and lists of curvatures.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::json;

use crate::api::json::view::arrays::WeightArray;
use crate::model::schema::schema_of;
use piad_fit::engine::curvature::{Extreme, Extremes};

/// The least and the largest value of a curvature, from both sides of knots; null if there is no curvature at all.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurvatureExtremes", extend("examples" = [example()]))]
pub(super) struct ExtremesView {
    /// The least.
    smallest: Option<ExtremeView>,
    /// The largest.
    largest: Option<ExtremeView>,
}

/// A place with a curvature.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurvatureExtreme")]
#[schemars(extend("examples" = [{"parameter": 0.5, "point": [1.0, 2.0], "value": 2.0}]))]
struct ExtremeView {
    /// Its parameter; of a surface two, u and v.
    parameter: Parameter,
    /// The point there.
    point: Vec<f64>,
    /// The curvature there.
    value: f64,
}

/// A parameter of a curve, or two of a surface.
#[derive(Serialize)]
#[serde(untagged)]
enum Parameter {
    One(f64),
    Two([f64; 2]),
}

impl JsonSchema for Parameter {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Parameter".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"oneOf": [
            {"type": "number"},
            {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
        ]})
    }
}

/// Curvatures, of a surface in rows; null where there is none.
#[derive(Serialize)]
#[serde(transparent)]
pub(super) struct Curvatures(pub(super) WeightArray);

schema_of!(
    Curvatures,
    "Curvatures",
    json_schema!({
        "description": "Curvatures: of a curve a list, of a surface rows of columns; null where there is none.",
        "anyOf": [
            {"type": "array", "items": {"type": ["number", "null"]}},
            {"title": "Rows", "type": "array", "items": {"type": "array", "items": {"type": ["number", "null"]}}},
        ],
        "examples": [[0.5, 2, null]],
    })
);

impl ExtremesView {
    pub(super) fn new(extremes: Extremes) -> Self {
        Self {
            smallest: extremes.smallest.map(ExtremeView::new),
            largest: extremes.largest.map(ExtremeView::new),
        }
    }
}

impl ExtremeView {
    fn new(extreme: Extreme) -> Self {
        Self {
            parameter: match extreme.v {
                None => Parameter::One(extreme.u),
                Some(v) => Parameter::Two([extreme.u, v]),
            },
            point: extreme.point,
            value: extreme.value,
        }
    }
}

/// A number, or null in JSON.
pub(super) fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Those of a parabola.
pub(super) fn example() -> serde_json::Value {
    json!({
        "smallest": {"parameter": 0.0, "point": [-1.0, 1.0], "value": 0.1789},
        "largest": {"parameter": 1.0, "point": [0.0, 0.0], "value": 2.0},
    })
}
