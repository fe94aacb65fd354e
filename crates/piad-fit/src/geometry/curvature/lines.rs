//! Continuity of a surface across its knot lines.

use super::degenerate::Vanishing;
use super::jets::angle;
use super::joints::{MOST_JOINTS, Sides, sides};
use super::principal::normal;
use crate::geometry::nurbs::sampling::SpanParameter;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The largest number of steps along a line, and the least in each knot span.
const MOST_STEPS: usize = 512;
const LEAST_STEPS: usize = 4;

/// A line of a surface at a knot of one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotLine {
    /// The knot.
    pub parameter: f64,
    /// The multiplicity of the knot.
    pub multiplicity: usize,
    /// The order of continuity across the line that the multiplicity guarantees.
    pub guaranteed: i64,
    /// If that is no tangent plane, the largest angle between the normals on both sides, in radians.
    pub angle: Option<f64>,
}

/// The inner knot lines of both directions of a surface, and how many there are; at most [`MOST_JOINTS`] of each, those
/// with the least continuity.
pub(super) fn lines(
    nurbs: &Nurbs,
    across: &KnotVector,
    vanishing: [&Vanishing; 2],
) -> [(Vec<KnotLine>, usize); 2] {
    let normals = |u: &[SpanParameter], v: &[SpanParameter]| {
        let jets = nurbs.second_jets(0, u, v);
        let sites = u.iter().flat_map(|u| v.iter().map(move |v| (*u, *v)));
        let normals = jets.iter().zip(sites).map(|(jet, (u, v))| {
            let limits = [vanishing[0].limit(u), vanishing[1].limit(v)];
            normal(jet, limits)
        });
        normals.collect::<Vec<_>>()
    };
    let (u, v) = (&nurbs.u, across);
    let (along_u, along_v) = (along(u), along(v));
    [
        each(u, |site| normals(&[site], &along_v)),
        each(v, |site| normals(&along_u, &[site])),
    ]
}

/// Parameters of a direction from one end to the other.
fn along(knots: &KnotVector) -> Vec<SpanParameter> {
    let spans = knots.spans().len().max(1);
    knots.sites(spans * (MOST_STEPS / spans).clamp(1, LEAST_STEPS * (knots.degree + 1)))
}

/// The lines of a direction, with the normals along the line at a parameter.
fn each(
    knots: &KnotVector,
    normals: impl Fn(SpanParameter) -> Vec<Option<[f64; 3]>>,
) -> (Vec<KnotLine>, usize) {
    let mut sides = sides(knots);
    let count = sides.len();
    if count > MOST_JOINTS {
        sides.sort_by_key(|sides| sides.guaranteed);
        sides.truncate(MOST_JOINTS);
        sides.sort_unstable_by(|a, b| a.behind.t.total_cmp(&b.behind.t));
    }
    let largest = |sides: &Sides| {
        let (before, behind) = (normals(sides.before), normals(sides.behind));
        let pairs = before.iter().zip(&behind);
        let angles = pairs.filter_map(|(a, b)| Some(angle(&[(*a)?], &[(*b)?])));
        angles.reduce(f64::max)
    };
    let lines = sides.iter().map(|sides| KnotLine {
        parameter: sides.behind.t,
        multiplicity: sides.multiplicity,
        guaranteed: sides.guaranteed,
        angle: (sides.guaranteed < 1).then(|| largest(sides)).flatten(),
    });
    (lines.collect(), count)
}
