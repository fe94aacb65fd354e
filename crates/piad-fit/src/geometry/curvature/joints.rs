//! Continuity of a curve at its knots.

use std::cmp::Ordering;

use super::degenerate::Vanishing;
use super::jets::CurveJets;
use crate::geometry::nurbs::sampling::SpanParameter;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The most knots whose continuity is listed.
pub const MOST_JOINTS: usize = 10_000;

/// The knots that are examined at a time.
const TOGETHER: usize = 1 << 11;

/// Tangents within this angle have the same direction: a hundredth of a degree.
const SAME_DIRECTION: f64 = 0.01 * std::f64::consts::PI / 180.0;

/// Derivatives that differ by this part of them are equal.
const SAME_DERIVATIVE: f64 = 1e-6;

/// Curvatures that differ by this part of them are equal, and those that bend a curve by less than this part of its
/// extent.
const SAME_CURVATURE: f64 = 1e-3;
const STRAIGHT: f64 = 1e-6;

/// The highest order of continuity that is measured.
const MEASURED: i64 = 2;

/// The two sides of a knot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    /// The parameters before and behind it: both are the knot, but where a closed direction returns to its start.
    pub before: SpanParameter,
    /// The one behind it.
    pub behind: SpanParameter,
    /// The multiplicity of the knot; at most p + 1.
    pub multiplicity: usize,
    /// The order of continuity that the multiplicity m guarantees, p − m; −1 allows a gap.
    pub guaranteed: i64,
}

/// The continuity of a curve at a knot.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The knot.
    pub parameter: f64,
    /// The point there.
    pub point: Vec<f64>,
    /// The multiplicity of the knot.
    pub multiplicity: usize,
    /// The order of continuity that the multiplicity guarantees.
    pub guaranteed: i64,
    /// The order of parametric continuity that was measured: the number of derivatives that are equal on both sides. At
    /// least what is guaranteed; orders above 2 are not tested.
    pub parametric: i64,
    /// The order of geometric continuity that was found: 0 a corner, 1 the same tangent, 2 the same curvature.
    pub geometric: i64,
    /// The distance between both sides.
    pub gap: f64,
    /// The angle between the tangents, in radians; NaN where one vanishes.
    pub angle: f64,
    /// The curvatures before and behind the knot.
    pub curvature: [f64; 2],
    /// The length of the difference of the curvature vectors.
    pub jump: f64,
}

/// Both sides of each inner knot, and where a closed direction returns to its start.
pub(super) fn sides(knots: &KnotVector) -> Vec<Sides> {
    let degree = knots.degree;
    let spans = knots.spans();
    let order = |multiplicity: usize| degree as i64 - multiplicity as i64;
    let inner = spans.windows(2).map(|pair| Sides {
        before: knots.site(pair[0], 1.0),
        behind: knots.site(pair[1], 0.0),
        multiplicity: pair[1] - pair[0],
        guaranteed: order(pair[1] - pair[0]),
    });
    let seam = match (spans.first(), spans.last()) {
        (Some(&first), Some(&last)) if knots.closed => {
            let start = knots.knots[first];
            let equal = knots.knots.iter().filter(|t| **t == start).count();
            // Clamped ends coincide, as if their multiplicity were one less.
            let multiplicity = equal.min(degree);
            Some(Sides {
                before: knots.site(last, 1.0),
                behind: knots.site(first, 0.0),
                multiplicity,
                guaranteed: order(multiplicity),
            })
        }
        _ => None,
    };
    seam.into_iter().chain(inner).collect()
}

/// The continuity at inner knots and where a closed curve returns to its start, and how many there are.
pub(super) fn joints(nurbs: &Nurbs, vanishing: &Vanishing) -> (Vec<Joint>, usize) {
    let sides = sides(&nurbs.u);
    let sizes = Sizes {
        resolution: nurbs.resolution(),
        straight: STRAIGHT / nurbs.points.bounding_diagonal(),
    };
    let mut joints: Vec<Joint> = Vec::new();
    for some in sides.chunks(TOGETHER) {
        let sites: Vec<_> = some.iter().flat_map(|it| [it.before, it.behind]).collect();
        let jets = CurveJets::new(nurbs, vanishing, &sites);
        let joint = |(k, sides): (usize, &Sides)| joint(&jets, 2 * k, *sides, &sizes);
        joints.extend(some.iter().enumerate().map(joint));
        if joints.len() > 2 * MOST_JOINTS {
            keep_least_smooth(&mut joints);
        }
    }
    keep_least_smooth(&mut joints);
    joints.sort_unstable_by(|a, b| a.parameter.total_cmp(&b.parameter));
    (joints, sides.len())
}

/// What counts as nothing on a curve of some size.
struct Sizes {
    /// The distance within which points coincide.
    resolution: f64,
    /// The curvature of a line that is straight.
    straight: f64,
}

/// The continuity between places `i` and `i + 1`.
fn joint(jets: &CurveJets, i: usize, sides: Sides, sizes: &Sizes) -> Joint {
    let curvature = [jets.curvature(i), jets.curvature(i + 1)];
    let (gap, angle, jump) = (
        jets.gap(i, i + 1),
        jets.angle(i, i + 1),
        jets.bend_jump(i, i + 1),
    );
    let is_closed = gap <= sizes.resolution;
    let bend = curvature[0].abs().max(curvature[1].abs());
    let found = |second: bool, first: bool| match (is_closed, first, second) {
        (false, ..) => -1,
        (true, false, _) => 0,
        (true, true, false) => 1,
        (true, true, true) => MEASURED,
    };
    let parametric = found(
        jets.second_jump(i, i + 1) <= SAME_DERIVATIVE,
        jets.first_jump(i, i + 1) <= SAME_DERIVATIVE,
    );
    let geometric = found(
        jump <= SAME_CURVATURE * bend + sizes.straight,
        angle <= SAME_DIRECTION,
    );
    let parametric = parametric.max(sides.guaranteed);
    // Where the derivative vanishes, equal ones do not determine the tangents.
    let regular = if angle.is_nan() { -1 } else { parametric };
    Joint {
        parameter: sides.behind.t,
        point: jets.point(i + 1).collect(),
        multiplicity: sides.multiplicity,
        guaranteed: sides.guaranteed,
        parametric,
        geometric: geometric.max(regular),
        gap,
        angle,
        curvature,
        jump,
    }
}

/// Keeps at most as many joints as the list may have.
fn keep_least_smooth(joints: &mut Vec<Joint>) {
    if joints.len() > MOST_JOINTS {
        joints.sort_by(smoothness);
        joints.truncate(MOST_JOINTS);
    }
}

/// The order from corners to smooth knots.
fn smoothness(a: &Joint, b: &Joint) -> Ordering {
    let orders = a.geometric.cmp(&b.geometric);
    let angles = b.angle.total_cmp(&a.angle);
    orders.then(angles).then(b.jump.total_cmp(&a.jump))
}
