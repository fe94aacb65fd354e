//! The shape of a curve.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use super::extremes::{self, Curvatures, ExtremesView, finite};
use crate::api::json::view::arrays::{NumberArray, PointArray};
use crate::api::json::view::document::Document;
use piad_fit::engine::curvature::{CurveShape, Joint};

/// The shape of a curve.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurveShape", extend("examples" = [curve_example()]))]
pub(crate) struct CurveShapeView {
    /// That of a curve.
    kind: CurveKind,
    /// The number of the iteration.
    iteration: usize,
    /// The length of the curve.
    length: Option<f64>,
    /// The places where the curvature is least and largest.
    curvature: ExtremesView,
    /// Parameters at which the derivative vanishes, and near which the curvature may be unbounded: up to 100 of those
    /// examined.
    degenerate: Vec<f64>,
    /// The continuity at inner knots, and where a closed curve returns to its start.
    continuity: Joints,
    /// Points with their curvature.
    samples: CurveSamplesView,
}

/// The kind of what has this shape.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
enum CurveKind {
    Curve,
}

/// The continuity of a curve at its knots.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurveContinuity", extend("examples" = [curve_example()["continuity"].clone()]))]
struct Joints {
    /// The number of these knots.
    count: usize,
    /// The knots in their order; of more than 10,000 those where the curve is least smooth.
    knots: Vec<JointView>,
}

/// The continuity of a curve at a knot: the guaranteed and the measured one.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "KnotContinuity", extend("examples" = [curve_example()["continuity"]["knots"][0].clone()]))]
struct JointView {
    /// The knot.
    parameter: f64,
    /// The point there.
    point: Vec<f64>,
    /// The multiplicity of the knot.
    multiplicity: usize,
    /// The order that the multiplicity m guarantees: C^(p − m) with the degree p; −1 allows a gap.
    guaranteed: i64,
    /// The measured order C: the number of derivatives that are equal on both sides. It is measured up to 2, and at
    /// least the guaranteed order.
    parametric: i64,
    /// The measured order G: 0 is a corner, 1 the same tangent (within 0.01 degrees), 2 the same curvature (within a
    /// thousandth); −1 is a gap.
    geometric: i64,
    /// The distance between both sides.
    gap: f64,
    /// The angle between the tangents in degrees; null where a derivative vanishes.
    angle: Option<f64>,
    /// The curvature before and behind the knot.
    curvature: [Option<f64>; 2],
    /// The distance between the curvature vectors of both sides.
    jump: Option<f64>,
}

/// Points of a curve with their curvature.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CurvatureSamples", extend("examples" = [curve_example()["samples"].clone()]))]
struct CurveSamplesView {
    /// The parameters.
    parameters: NumberArray,
    /// The points.
    points: PointArray,
    /// The curvature: in the plane positive where the curve turns left, otherwise never negative.
    curvature: Curvatures,
}

impl CurveShapeView {
    pub(super) fn new(document: &mut Document, iteration: usize, shape: CurveShape) -> Self {
        let samples = shape.samples;
        let count = samples.parameters.len();
        let dimension = samples.points.len() / count.max(1);
        Self {
            kind: CurveKind::Curve,
            iteration,
            length: finite(shape.length),
            curvature: ExtremesView::new(shape.extremes),
            degenerate: shape.degenerate,
            continuity: Joints {
                count: shape.joint_count,
                knots: shape.joints.into_iter().map(JointView::new).collect(),
            },
            samples: CurveSamplesView {
                parameters: document.numbers(count, samples.parameters),
                points: document.points(&[count, dimension], samples.points),
                curvature: Curvatures(document.weights(&[count], samples.curvature)),
            },
        }
    }
}

impl JointView {
    fn new(joint: Joint) -> Self {
        Self {
            parameter: joint.parameter,
            point: joint.point,
            multiplicity: joint.multiplicity,
            guaranteed: joint.guaranteed,
            parametric: joint.parametric,
            geometric: joint.geometric,
            gap: joint.gap,
            angle: finite(joint.angle.to_degrees()),
            curvature: joint.curvature.map(finite),
            jump: finite(joint.jump),
        }
    }
}

/// The shape of a parabola of two pieces.
pub(super) fn curve_example() -> serde_json::Value {
    json!({
        "kind": "curve", "iteration": 12, "length": 2.9579,
        "curvature": extremes::example(),
        "degenerate": [],
        "continuity": {"count": 1, "knots": [{
            "parameter": 1.0, "point": [0.0, 0.0], "multiplicity": 1, "guaranteed": 1, "parametric": 2, "geometric": 2,
            "gap": 0.0, "angle": 0.0, "curvature": [2.0, 2.0], "jump": 0.0,
        }]},
        "samples": {
            "parameters": [0.0, 1.0, 2.0],
            "points": [[-1.0, 1.0], [0.0, 0.0], [1.0, 1.0]],
            "curvature": [0.1789, 2.0, 0.1789],
        },
    })
}
