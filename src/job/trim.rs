//! The remaining part of a trimmed surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::frame::Frame;
use piad_fit::engine::outline::trimmed_area;
use piad_fit::geometry::{Face, Nurbs, Outline};

/// The remaining part of a trimmed surface: where its parameters are on the left of all loops.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{
    "area": 2.9, "distance": 0.1, "faces": [{"outer": 0, "holes": []}],
    "loops": [{"degree": 3, "knots": [0, 0, 0, 0, 2, 2, 2, 2], "control_points": [[0, 0], [3, 0], [0, 3], [0, 0]]}],
}]))]
pub(crate) struct Trimmed {
    /// The area of the remaining part, of surfaces in the plane and in space.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    pub(crate) area: Option<f64>,
    /// The largest distance of the outline from the data, in the unit of the points.
    pub(crate) distance: f64,
    /// The pieces that it is in; none if it is all of the surface.
    pub(crate) faces: Vec<TrimmedFace>,
    /// Closed curves in u and v; none if it is all of the surface.
    pub(crate) loops: Vec<TrimLoop>,
}

/// A piece of a trimmed surface, by indices of loops.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"outer": 0, "holes": [1]}]))]
pub(crate) struct TrimmedFace {
    /// The loop around it, counter-clockwise.
    pub(crate) outer: usize,
    /// Those around its holes, clockwise.
    pub(crate) holes: Vec<usize>,
}

/// A closed B-spline curve in the parameters of a surface, which is on its left. It can turn at knots of multiplicity 3.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"degree": 3, "knots": [0, 0, 0, 0, 2, 2, 2, 2], "control_points": [[0, 0], [3, 0], [0, 3], [0, 0]]}]))]
pub(crate) struct TrimLoop {
    /// The degree.
    pub(crate) degree: usize,
    /// The knots, clamped.
    pub(crate) knots: Vec<f64>,
    /// u and v of the control points; the last one is the first.
    pub(crate) control_points: Vec<[f64; 2]>,
}

impl Trimmed {
    /// The remaining part of the surface of a level, if it is trimmed.
    pub(crate) fn of(frame: &Frame) -> Option<Self> {
        let outline: &Outline = frame.problem.outline()?;
        let nurbs = Nurbs::of(&frame.problem, &frame.control_points);
        let area = trimmed_area(&nurbs, outline);
        Some(Self {
            area: area.filter(|area| area.is_finite()),
            distance: outline.distance,
            faces: outline.faces.iter().map(TrimmedFace::of).collect(),
            loops: outline.loops.iter().map(TrimLoop::of).collect(),
        })
    }
}

impl TrimmedFace {
    fn of(face: &Face) -> Self {
        Self {
            outer: face.outer,
            holes: face.holes.clone().collect(),
        }
    }
}

impl TrimLoop {
    fn of(curve: &Nurbs) -> Self {
        let [u, v] = [0, 1].map(|axis| curve.points.lane(axis).iter());
        Self {
            degree: curve.u.degree,
            knots: curve.u.knots.clone(),
            control_points: u.zip(v).map(|(&u, &v)| [u, v]).collect(),
        }
    }
}
