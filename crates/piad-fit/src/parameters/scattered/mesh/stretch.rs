//! Stretch of the triangles of a mesh by their parameters, and which of them are turned over.

use nalgebra::Vector3;

use super::super::normals::Cloud;
use super::super::pairs::{Domain, Pairs};
use super::super::unfolding::unrolled;

/// A triangle that keeps less than this part of its area has none.
const NO_AREA: f64 = 1e-6;

/// The largest weight of a triangle.
const MAX_WEIGHT: f64 = 100.0;

/// The result for triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    /// The triangles that are turned over, or have no area, and the first of them.
    pub folded: usize,
    pub first: usize,
    /// The part of the area of the mesh that they have.
    pub share: f64,
    /// The mean over the area of `(σ₁² + σ₂² + 1/σ₁² + 1/σ₂²) / 4 − 1`, which is zero if no length changes.
    pub energy: f64,
}

impl Stretch {
    /// That of triangles of the points of a cloud, which are all in one sense.
    pub(super) fn new(cloud: &Cloud, triangles: &[[u32; 3]], pairs: &Pairs) -> Self {
        let mut senses = [Folded::default(), Folded::default()];
        let (mut energy, mut all) = (0.0, 0.0);
        for (t, &triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|vertex| cloud.points[vertex as usize]);
            let in_space = [b - a, c - a];
            let area = in_space[0].cross(&in_space[1]).norm();
            if area <= 0.0 {
                continue;
            }
            let (mapped, sense) = mapped(pairs, triangle);
            let mapped = mapped.map(|side| side * cloud.scaled(1.0));
            let after = mapped[0].cross(&mapped[1]).norm();
            all += area;
            energy += area * stretch(&in_space, &mapped, after / area).min(MAX_WEIGHT);
            let has_area = after > NO_AREA * area;
            senses[0].count(!has_area || sense <= 0.0, t, area);
            senses[1].count(!has_area || sense >= 0.0, t, area);
        }
        let [first, second] = senses;
        let folded = if first.area <= second.area {
            first
        } else {
            second
        };
        Self {
            folded: folded.count,
            first: folded.first,
            share: folded.area / all.max(f64::MIN_POSITIVE),
            energy: energy / all.max(f64::MIN_POSITIVE),
        }
    }
}

/// Triangles that are not in one sense.
#[derive(Default)]
struct Folded {
    count: usize,
    first: usize,
    area: f64,
}

impl Folded {
    fn count(&mut self, is_folded: bool, triangle: usize, area: f64) {
        if is_folded {
            if self.count == 0 {
                self.first = triangle;
            }
            self.count += 1;
            self.area += area;
        }
    }
}

/// Two sides of a triangle by its parameters, on the surface that these unroll; and its sense.
fn mapped(pairs: &Pairs, triangle: [u32; 3]) -> ([Vector3<f64>; 2], f64) {
    let indices = triangle.map(|vertex| vertex as usize);
    if let [Domain::Closed(_), Domain::Between { .. }] = pairs.domains {
        let [a, b, c] = indices.map(|i| Vector3::from(unrolled(pairs, i)));
        return ([b - a, c - a], a.dot(&b.cross(&c)));
    }
    let lanes = [0, 1].map(|axis| pairs.values.lane(axis));
    let difference = |axis: usize, i: usize| {
        let along = lanes[axis][i] - lanes[axis][indices[0]];
        match pairs.domains[axis].period() {
            Some(period) => along - period * (along / period).round(),
            None => along,
        }
    };
    let side = |i: usize| Vector3::new(difference(0, i), difference(1, i), 0.0);
    let [first, second] = [indices[1], indices[2]].map(side);
    ([first, second], first.cross(&second).z)
}

/// `(σ₁² + σ₂² + 1/σ₁² + 1/σ₂²) / 4 − 1` of the linear map of two sides, which changes areas by a factor.
fn stretch(before: &[Vector3<f64>; 2], after: &[Vector3<f64>; 2], factor: f64) -> f64 {
    let gram = |[a, b]: &[Vector3<f64>; 2]| [a.dot(a), a.dot(b), b.dot(b)];
    let ([e, f, g], [p, q, r]) = (gram(before), gram(after));
    let determinant = e * g - f * f;
    if determinant <= 0.0 || factor <= 0.0 {
        return MAX_WEIGHT;
    }
    // The trace of G⁻¹ H.
    let trace = (g * p - 2.0 * f * q + e * r) / determinant;
    let stretch = (trace + trace / (factor * factor)) / 4.0 - 1.0;
    if stretch.is_finite() {
        stretch.max(0.0)
    } else {
        MAX_WEIGHT
    }
}
