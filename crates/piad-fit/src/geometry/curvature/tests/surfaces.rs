//! Surfaces with closed forms.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::{bezier, curve, line_of, near, quarters};
use crate::geometry::curvature::SurfaceShape;
use crate::geometry::nurbs::{KnotVector, Nurbs};

fn surface(u: KnotVector, v: KnotVector, places: &[[f64; 3]], weights: &[f64]) -> Nurbs {
    Nurbs {
        v: Some(v),
        weights: Some(weights.to_vec()),
        ..curve(u, places)
    }
}

fn surface_shape(nurbs: &Nurbs) -> SurfaceShape {
    let v = nurbs.v.as_ref().unwrap();
    SurfaceShape::new(nurbs, &nurbs.u.sites(12), &v.sites(16)).unwrap()
}

/// The surface of revolution of a rational quadratic arc in the x-z plane around the z axis.
fn revolved(profile: &[([f64; 2], f64); 3]) -> Nurbs {
    let (v, corners, around) = quarters();
    let (mut places, mut weights) = (Vec::new(), Vec::new());
    for ([r, z], weight) in profile {
        for ([x, y], w) in corners.iter().zip(around) {
            places.push([r * x, r * y, *z]);
            weights.push(weight * w);
        }
    }
    surface(bezier(2), v, &places, &weights)
}

/// A half of a sphere, whose pole is a point.
#[test]
fn spheres_bend_alike_in_all_directions() {
    let r = 2.5;
    let half = FRAC_1_SQRT_2;
    let sphere = revolved(&[([r, 0.0], 1.0), ([r, r], half), ([0.0, r], 1.0)]);
    let shape = surface_shape(&sphere);
    near(shape.area, 2.0 * PI * r * r, 1e-10);
    let columns = 17;
    // u goes up and v around, so that the normal points inwards.
    for (index, [k1, k2]) in shape.samples.principal[0]
        .iter()
        .zip(&shape.samples.principal[1])
        .map(|(a, b)| [*a, *b])
        .enumerate()
    {
        if index / columns == 12 {
            assert!(k1.is_nan() && k2.is_nan(), "the pole has a normal");
        } else {
            near(k1, 1.0 / r, 1e-12);
            near(k2, 1.0 / r, 1e-12);
        }
    }
    assert_eq!(shape.degenerate[0], [1.0, 0.0]);
    let [k1, _, gaussian, mean] = &shape.extremes;
    near(k1.largest.as_ref().unwrap().value, 1.0 / r, 1e-10);
    near(
        gaussian.smallest.as_ref().unwrap().value,
        1.0 / (r * r),
        1e-10,
    );
    near(mean.largest.as_ref().unwrap().value, 1.0 / r, 1e-10);
    let [none, around] = &shape.lines;
    assert!(none.is_empty());
    assert_eq!((shape.line_counts, around.len()), ([0, 4], 4));
    for line in around {
        assert_eq!((line.multiplicity, line.guaranteed), (2, 0));
        assert!(line.angle.unwrap() < 1e-12);
    }
}

/// A cylinder, whose seam and quarters are smooth.
#[test]
fn cylinders_bend_in_one_direction() {
    let (u, corners, around) = quarters();
    let (mut places, mut weights) = (Vec::new(), Vec::new());
    for ([x, y], w) in corners.iter().zip(around) {
        for z in [0.0, 3.0] {
            places.push([2.0 * x, 2.0 * y, z]);
            weights.push(w);
        }
    }
    let shape = surface_shape(&surface(u, bezier(1), &places, &weights));
    near(shape.area, 12.0 * PI, 1e-10);
    for (k1, k2) in shape.samples.principal[0]
        .iter()
        .zip(&shape.samples.principal[1])
    {
        // u goes around to the left and v up: the normal points outwards.
        near(*k1, 0.0, 1e-13);
        near(*k2, -0.5, 1e-13);
    }
    let [_, _, gaussian, mean] = &shape.extremes;
    near(gaussian.largest.as_ref().unwrap().value, 0.0, 1e-12);
    near(mean.largest.as_ref().unwrap().value, -0.25, 1e-12);
}

/// The outer half of a torus: k = 1/r along the tube, and cos φ / (R + r cos φ) around the axis.
#[test]
fn tori_bend_less_around_than_along() {
    let (big, r) = (3.0, 1.0);
    let half = FRAC_1_SQRT_2;
    let torus = revolved(&[([big + r, 0.0], 1.0), ([big + r, r], half), ([big, r], 1.0)]);
    let shape = surface_shape(&torus);
    // A quarter of the tube: ∫ 2π (R + r cos φ) r dφ.
    near(shape.area, 2.0 * PI * r * (big * 0.5 * PI + r), 1e-10);
    let points = shape.samples.points.chunks(3);
    for (k, point) in points.enumerate() {
        let cosine = (point[0].hypot(point[1]) - big) / r;
        near(shape.samples.principal[0][k], 1.0 / r, 1e-12);
        near(
            shape.samples.principal[1][k],
            cosine / (big + r * cosine),
            1e-12,
        );
    }
    let [_, smaller, ..] = &shape.extremes;
    let (least, largest) = (
        smaller.smallest.as_ref().unwrap(),
        smaller.largest.as_ref().unwrap(),
    );
    near(least.value, 0.0, 1e-12);
    assert_eq!(least.u, 1.0);
    near(largest.value, 0.25, 1e-12);
    assert_eq!(largest.u, 0.0);
}

/// z = a x² + b y² at its vertex, which is between samples, and a fold between two planes.
#[test]
fn extremes_and_folds_of_surfaces() {
    let (a, b) = (1.0, -0.5);
    // Bernstein coefficients of x² from −1 to 1.4 and of y² from −0.7 to 1.
    let squares = |low: f64, high: f64| [low * low, low * high, high * high];
    let (xs, ys) = ([-1.0, 0.2, 1.4], [-0.7, 0.15, 1.0]);
    let (xx, yy) = (squares(-1.0, 1.4), squares(-0.7, 1.0));
    let mut places = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            places.push([xs[i], ys[j], a * xx[i] + b * yy[j]]);
        }
    }
    let saddle = surface(bezier(2), bezier(2), &places, &[1.0; 9]);
    let [k1, k2, gaussian, _] = surface_shape(&saddle).extremes;
    let (k1, k2) = (k1.largest.unwrap(), k2.smallest.unwrap());
    near(k1.value, 2.0, 1e-12);
    near(k2.value, -1.0, 1e-12);
    near(gaussian.smallest.unwrap().value, -2.0, 1e-12);
    for extreme in [k1, k2] {
        near(extreme.point[0].hypot(extreme.point[1]), 0.0, 1e-5);
    }
    // A roof with an angle of 90 degrees at its ridge.
    let mut places = Vec::new();
    for [x, z] in [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]] {
        places.push([x, 0.0, z]);
        places.push([x, 5.0, z]);
    }
    let ridge = line_of(1, &[0.0, 0.0, 1.0, 2.0, 2.0]);
    let shape = surface_shape(&surface(ridge, bezier(1), &places, &[1.0; 6]));
    near(shape.area, 10.0 * 2_f64.sqrt(), 1e-12);
    let line = &shape.lines[0][0];
    assert_eq!((line.parameter, line.guaranteed), (1.0, 0));
    near(line.angle.unwrap().to_degrees(), 90.0, 1e-12);
}
