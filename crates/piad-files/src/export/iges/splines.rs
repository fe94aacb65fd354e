//! Rational B-spline curves (entity 126) and surfaces (entity 128).

use super::sections::ParameterData;
use crate::export::nurbs::{KnotVector, Nurbs};

/// The type of the entity of a curve or surface.
pub(super) fn entity(nurbs: &Nurbs) -> usize {
    match nurbs.v {
        None => 126,
        Some(_) => 128,
    }
}

/// Writes the parameters of a curve or surface.
pub(super) fn geometry(data: &mut ParameterData, nurbs: &Nurbs) {
    match &nurbs.v {
        None => curve(data, nurbs),
        Some(v) => surface(data, nurbs, v),
    }
}

/// Entity 126 (section 4.23).
fn curve(data: &mut ParameterData, nurbs: &Nurbs) {
    let u = &nurbs.u;
    let plane = plane(nurbs);
    data.integer(nurbs.rows() - 1);
    data.integer(u.degree);
    data.flag(plane.is_some());
    data.flag(u.closed);
    data.flag(nurbs.weights.is_none());
    data.flag(u.is_periodic());
    data.reals(&u.knots);
    net(data, nurbs, 0..nurbs.rows());
    domain(data, u);
    data.reals(&plane.unwrap_or_default());
}

/// Entity 128 (section 4.24). Control points run fastest in the first direction.
fn surface(data: &mut ParameterData, nurbs: &Nurbs, v: &KnotVector) {
    let u = &nurbs.u;
    let (rows, columns) = (nurbs.rows(), nurbs.columns());
    data.integer(rows - 1);
    data.integer(columns - 1);
    data.integer(u.degree);
    data.integer(v.degree);
    data.flag(u.closed);
    data.flag(v.closed);
    data.flag(nurbs.weights.is_none());
    data.flag(u.is_periodic());
    data.flag(v.is_periodic());
    data.reals(&u.knots);
    data.reals(&v.knots);
    let order = (0..columns).flat_map(|column| (0..rows).map(move |row| row * columns + column));
    net(data, nurbs, order);
    domain(data, u);
    domain(data, v);
}

/// All weights, then all control points. Polynomial ones have equal weights (section 4.23).
fn net(data: &mut ParameterData, nurbs: &Nurbs, order: impl Iterator<Item = usize> + Clone) {
    let factor = weight_factor(nurbs);
    for index in order.clone() {
        data.real(factor * nurbs.weight(index));
    }
    for index in order {
        data.reals(&nurbs.place(index));
    }
}

/// A power of two by which all weights are multiplied, which does not change the geometry, so that none is below 10⁻⁹:
/// otherwise OpenCASCADE reads the file as polynomial.
fn weight_factor(nurbs: &Nurbs) -> f64 {
    let weights = nurbs.weights.as_deref().unwrap_or_default();
    let smallest = weights.iter().copied().fold(1.0, f64::min);
    let largest = weights.iter().copied().fold(1.0, f64::max);
    let wanted = (1e-8 / smallest).log2().ceil();
    // One less, as logarithms are rounded.
    let possible = (f64::MAX / largest).log2().floor() - 1.0;
    wanted.min(possible).max(0.0).exp2()
}

/// Where the parameter starts and ends.
fn domain(data: &mut ParameterData, direction: &KnotVector) {
    let (low, high) = direction.domain();
    data.reals(&[low, high]);
}

/// The unit normal of the plane that a curve is in, if that is a plane of constant z.
fn plane(nurbs: &Nurbs) -> Option<[f64; 3]> {
    let height = nurbs.place(0)[2];
    let planar = (0..nurbs.rows()).all(|index| nurbs.place(index)[2] == height);
    planar.then_some([0.0, 0.0, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_weights_are_multiplied_by_a_power_of_two() {
        let mut nurbs = crate::export::cylinder::cylinder();
        assert_eq!(weight_factor(&nurbs), 1.0);
        for (smallest, largest) in [
            (1e-12, 1.0),
            (1e-200, 1e-190),
            (1e-300, 1e300),
            (5e-324, 1.0),
        ] {
            nurbs.weights = Some(vec![1.0, smallest, largest, 1.0, 1.0, 1.0]);
            let factor = weight_factor(&nurbs);
            assert_eq!(factor.log2().fract(), 0.0);
            assert!(factor > 1.0 && (factor * largest).is_finite());
            assert!(factor * smallest > 1e-9 || largest == 1e300 || smallest == 5e-324);
        }
        nurbs.weights = None;
        assert_eq!(weight_factor(&nurbs), 1.0);
    }
}
