//! A rational surface for tests.

use piad_fit::data::Points;
use piad_fit::geometry::{KnotVector, Nurbs};

use piad_fit::engine::vectors::{dot, length, minus};

/// An open direction.
pub(super) fn line_of(degree: usize, knots: &[f64]) -> KnotVector {
    KnotVector {
        degree,
        knots: knots.to_vec(),
        closed: false,
    }
}

/// A quarter of a cylinder of radius 2 around the z axis and height 3, in u as a rational
/// quarter circle of degree 2.
pub(super) fn cylinder() -> Nurbs {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let line = |degree: usize, ends: [f64; 2]| {
        let knots = ends.iter().flat_map(|&t| vec![t; degree + 1]);
        line_of(degree, &knots.collect::<Vec<f64>>())
    };
    let mut points = Points::new(3);
    for [x, y] in [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]] {
        points.push(&[x, y, 0.0]);
        points.push(&[x, y, 3.0]);
    }
    Nurbs {
        u: line(2, [0.0, 1.0]),
        v: Some(line(1, [5.0, 7.0])),
        points,
        weights: Some(vec![1.0, 1.0, half, half, 1.0, 1.0]),
    }
}

#[test]
fn a_rational_quarter_is_a_circle() {
    let nurbs = cylinder();
    let v = nurbs.v.clone().unwrap();
    let jets = nurbs.evaluate(&nurbs.u.sites(20), &v.sites(4));
    assert_eq!(jets.len(), 21 * 5);
    for (index, jet) in jets.iter().enumerate() {
        let [x, y, z] = jet.point;
        assert!((x.hypot(y) - 2.0).abs() < 1e-15);
        assert!((z - 0.75 * (index % 5) as f64).abs() < 1e-15);
        // Tangents to the circle, and along the axis at 3 per 2 units of v.
        assert!(dot(jet.du, [x, y, 0.0]).abs() < 1e-14);
        assert!(length(jet.du) > 1.0);
        assert!(length(minus(jet.dv, [0.0, 0.0, 1.5])) < 1e-15);
    }
}
