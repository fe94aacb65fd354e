//! Principal curvatures of surfaces.
//!
//! With the unit normal n = S_u × S_v / |S_u × S_v|, the second fundamental form in an orthonormal basis of the tangent
//! plane is a symmetric matrix `(a b; b c)`, of which the principal curvatures are the eigenvalues
//! `(a + c) / 2 ± √(((a − c) / 2)² + b²)`. No digits are lost where both are equal, as on a sphere, unlike in
//! `H ± √(H² − K)`. They are positive where the surface bends towards its normal.

use crate::data::vectors::{cross, dot, length};
use crate::geometry::nurbs::derivatives::SecondJet;

/// Tangents with a smaller sine between them span no plane.
const PARALLEL: f64 = 1e-9;

/// The unit normal, if derivatives longer than these limits span a plane.
pub(super) fn normal(jet: &SecondJet, limits: [f64; 2]) -> Option<[f64; 3]> {
    let (du, dv) = (unit(jet.jet.du, limits[0])?, unit(jet.jet.dv, limits[1])?);
    unit(cross(du, dv), PARALLEL)
}

/// The larger and the smaller principal curvature; NaN where the normal is undefined.
pub(super) fn principal(jet: &SecondJet, limits: [f64; 2]) -> [f64; 2] {
    let none = [f64::NAN; 2];
    let Some(normal) = normal(jet, limits) else {
        return none;
    };
    let (e, along) = (length(jet.jet.du), jet.jet.du);
    let first = along.map(|x| x / e);
    let second = cross(normal, first);
    // S_v = f e₁ + g e₂
    let (f, g) = (dot(jet.jet.dv, first), dot(jet.jet.dv, second));
    let [uu, uv, vv] = [jet.duu, jet.duv, jet.dvv].map(|d| dot(d, normal));
    let a = uu / e / e;
    let b = (uv / e - f * a) / g;
    let c = (vv / g - f * (2.0 * b + f * a / g)) / g;
    let (middle, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
    match middle.is_finite() && radius.is_finite() {
        true => [middle + radius, middle - radius],
        false => none,
    }
}

/// `a / |a|` if it is longer than the limit.
fn unit(a: [f64; 3], limit: f64) -> Option<[f64; 3]> {
    let length = length(a);
    (length > limit && length.is_finite()).then(|| a.map(|x| x / length))
}
