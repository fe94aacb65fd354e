mod curves;
mod surfaces;

use std::f64::consts::FRAC_1_SQRT_2;

use crate::data::points::Points;
use crate::geometry::nurbs::{KnotVector, Nurbs};

fn line_of(degree: usize, knots: &[f64]) -> KnotVector {
    KnotVector {
        degree,
        knots: knots.to_vec(),
        closed: false,
    }
}

fn bezier(degree: usize) -> KnotVector {
    line_of(
        degree,
        &[vec![0.0; degree + 1], vec![1.0; degree + 1]].concat(),
    )
}

fn curve<const D: usize>(u: KnotVector, places: &[[f64; D]]) -> Nurbs {
    let mut points = Points::new(D);
    places.iter().for_each(|place| points.push(place));
    Nurbs {
        u,
        v: None,
        points,
        weights: None,
    }
}

/// The knots, control points and weights of a circle in four quarters of degree 2.
fn quarters() -> (KnotVector, [[f64; 2]; 9], [f64; 9]) {
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let corners = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    let weights = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| match i % 2 {
        0 => 1.0,
        _ => FRAC_1_SQRT_2,
    });
    let knots = KnotVector {
        closed: true,
        ..line_of(2, &knots)
    };
    (knots, corners, weights)
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} {expected}");
}
