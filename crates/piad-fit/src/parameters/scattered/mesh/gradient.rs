//! How u and v change on a mesh.

use nalgebra::Vector3;

use super::sheet::Sheet;

/// Sums over the area of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gradients {
    area: f64,
    /// The lengths of the gradients of u and v.
    lengths: [f64; 2],
    /// These gradients.
    sums: [Vector3<f64>; 2],
    /// `∇u · ∇v` and `|∇v|²`.
    mixed: f64,
    square: f64,
}

impl Gradients {
    /// Those of values at the vertices, where u is larger by 1 at corners that are `left` of a cut.
    pub(super) fn new(sheet: &Sheet, values: &[[f64; 2]], left: Option<&[[bool; 3]]>) -> Self {
        let mut all = Self::default();
        for (t, &triangle) in sheet.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|vertex| sheet.places[vertex as usize]);
            let (p, q) = (b - a, c - a);
            let (e, f, g) = (p.dot(&p), p.dot(&q), q.dot(&q));
            let determinant = e * g - f * f;
            let area = determinant.max(0.0).sqrt();
            let value = |corner: usize, axis: usize| {
                let is_left = axis == 0 && left.is_some_and(|left| left[t][corner]);
                values[triangle[corner] as usize][axis] + f64::from(u8::from(is_left))
            };
            let gradients = [0, 1].map(|axis| {
                let from = value(0, axis);
                let (first, second) = (value(1, axis) - from, value(2, axis) - from);
                (p * (g * first - f * second) + q * (e * second - f * first)) / determinant
            });
            if !gradients.iter().all(|it| it.amax().is_finite()) {
                continue;
            }
            let [u, v] = gradients;
            all.area += area;
            for (axis, gradient) in gradients.into_iter().enumerate() {
                all.lengths[axis] += area * gradient.norm();
                all.sums[axis] += gradient * area;
            }
            all.mixed += area * u.dot(&v);
            all.square += area * v.dot(&v);
        }
        all
    }

    /// The lengths on the mesh, in the mean, of the steps from 0 to 1.
    pub(super) fn steps(&self) -> [f64; 2] {
        self.lengths.map(|length| self.area / length)
    }

    /// By how much v is to be added to u so that they are at right angles in the mean.
    pub(super) fn shear(&self) -> f64 {
        let shear = -self.mixed / self.square;
        if shear.is_finite() { shear } else { 0.0 }
    }

    /// True if u or v decreases along the coordinate in which it changes most.
    pub(super) fn decreases(&self, axis: usize) -> bool {
        let sum = self.sums[axis];
        super::super::normals::towards_largest(sum).dot(&sum) < 0.0
    }
}
