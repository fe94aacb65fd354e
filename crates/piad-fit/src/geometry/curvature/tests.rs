use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::*;
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

fn circle(radius: f64) -> Nurbs {
    let (knots, corners, weights) = quarters();
    let places = corners.map(|corner| corner.map(|x| 100.0 + radius * x));
    Nurbs {
        weights: Some(weights.to_vec()),
        ..curve(knots, &places)
    }
}

fn shape_of(nurbs: &Nurbs) -> CurveShape {
    CurveShape::new(nurbs, &nurbs.u.sites(64))
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} {expected}");
}

/// The curvature is 1/r all around, and double knots are smoother than they have to be.
#[test]
fn circles_have_one_curvature() {
    for radius in [0.25, 3.0] {
        let shape = shape_of(&circle(radius));
        near(shape.length, 2.0 * PI * radius, 1e-11 * radius);
        for curvature in &shape.samples.curvature {
            near(*curvature, 1.0 / radius, 1e-12 / radius);
        }
        for extreme in [&shape.extremes.smallest, &shape.extremes.largest] {
            near(
                extreme.as_ref().unwrap().value,
                1.0 / radius,
                1e-12 / radius,
            );
        }
        assert_eq!((shape.joints.len(), shape.joint_count), (4, 4));
        let knots: Vec<f64> = shape.joints.iter().map(|joint| joint.parameter).collect();
        assert_eq!(knots, [0.0, 1.0, 2.0, 3.0]);
        for joint in &shape.joints {
            assert_eq!((joint.multiplicity, joint.guaranteed), (2, 0));
            assert_eq!(joint.geometric, 2);
            assert!(joint.angle < 1e-13 && joint.jump < 1e-11 / radius);
        }
        assert!(shape.degenerate.is_empty());
    }
    // The other way round it turns right.
    let mut points = Points::new(2);
    let forth = circle(2.0);
    for i in (0..9).rev() {
        points.push(&forth.points.point(i).collect::<Vec<f64>>());
    }
    let shape = shape_of(&Nurbs { points, ..forth });
    near(shape.samples.curvature[7], -0.5, 1e-13);
}

/// y = x² has the curvature 2 / (1 + 4 x²)^(3/2), largest at its vertex, which is between samples.
#[test]
fn parabolas_turn_most_at_their_vertex() {
    let parabola = curve(bezier(2), &[[-1.0, 1.0], [0.3, -1.6], [1.6, 2.56]]);
    let shape = shape_of(&parabola);
    let largest = shape.extremes.largest.unwrap();
    near(largest.value, 2.0, 1e-13);
    near(largest.point[0], 0.0, 1e-6);
    near(largest.u, 1.0 / 2.6, 1e-6);
    let smallest = shape.extremes.smallest.unwrap();
    assert_eq!(smallest.u, 1.0);
    near(
        smallest.value,
        2.0 / (1.0 + 4.0 * 2.56_f64).powf(1.5),
        1e-14,
    );
    for (curvature, point) in shape
        .samples
        .curvature
        .iter()
        .zip(shape.samples.points.chunks(2))
    {
        near(
            *curvature,
            2.0 / (1.0 + 4.0 * point[0] * point[0]).powf(1.5),
            1e-13,
        );
    }
}

/// A cubic with an inflection has curvatures of both signs in the plane, and of one in space.
#[test]
fn only_plane_curves_turn_left_or_right() {
    let plane = [[0.0, 0.0], [1.0, 1.0], [2.0, -1.0], [3.0, 0.0]];
    let found = shape_of(&curve(bezier(3), &plane)).extremes;
    let (least, largest) = (found.smallest.unwrap().value, found.largest.unwrap().value);
    near(least, -largest, 1e-10);
    assert!(least < 0.0);
    let space = plane.map(|[x, y]| [x, y, 7.0]);
    let found = shape_of(&curve(bezier(3), &space)).extremes;
    near(found.smallest.unwrap().value, 0.0, 1e-9);
    near(found.largest.unwrap().value, largest, 1e-12);
}

/// The twisted cubic (t, t², t³), and the same in five dimensions, turned.
#[test]
fn curves_have_any_dimension() {
    let cubic = [
        [0.0; 3],
        [1.0 / 3.0, 0.0, 0.0],
        [2.0 / 3.0, 1.0 / 3.0, 0.0],
        [1.0; 3],
    ];
    let expected = |t: f64| {
        let [a, b, c] = [1.0 + 4.0 * t * t + 9.0 * t.powi(4), 2.0, 6.0 * t];
        let cross = [2.0 * t * c - 3.0 * t * t * b, -c, b];
        (cross.iter().map(|x| x * x).sum::<f64>() / a.powi(3)).sqrt()
    };
    let in_five = cubic.map(|[x, y, z]| {
        let half = FRAC_1_SQRT_2;
        [half * x, half * y, half * x, z, half * y]
    });
    for shape in [
        shape_of(&curve(bezier(3), &cubic)),
        shape_of(&curve(bezier(3), &in_five)),
    ] {
        for (t, curvature) in shape
            .samples
            .parameters
            .iter()
            .zip(&shape.samples.curvature)
        {
            near(*curvature, expected(*t), 1e-13);
        }
    }
}

/// Lines do not bend, whatever the speed along them.
#[test]
fn lines_are_straight() {
    for places in [[[0.0, 0.0], [1.0, 2.0], [5.0, 10.0], [6.0, 12.0]]] {
        let shape = shape_of(&curve(bezier(3), &places));
        near(shape.length, 180_f64.sqrt(), 1e-12);
        for curvature in &shape.samples.curvature {
            near(*curvature, 0.0, 1e-14);
        }
    }
    let two = shape_of(&curve(bezier(1), &[[1.0, 1.0], [4.0, 5.0]]));
    assert_eq!(two.length, 5.0);
    assert_eq!(two.extremes.largest.unwrap().value, 0.0);
    assert_eq!(two.joint_count, 0);
}

/// Corners, tangents and curvatures that agree or not.
#[test]
fn knots_show_what_is_there() {
    // A polygon with a corner of 90 degrees, and a knot where it goes on straight with another speed.
    let polygon = curve(
        line_of(1, &[0.0, 0.0, 1.0, 2.0, 3.0, 3.0]),
        &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 5.0]],
    );
    let joints = shape_of(&polygon).joints;
    assert_eq!(joints.len(), 2);
    let orders = |joint: &Joint| (joint.guaranteed, joint.parametric, joint.geometric);
    assert_eq!(orders(&joints[0]), (0, 0, 0));
    near(joints[0].angle.to_degrees(), 90.0, 1e-12);
    assert_eq!(joints[0].point, [2.0, 0.0]);
    assert_eq!(orders(&joints[1]), (0, 0, 2));
    // A quadratic spline: tangents agree, and curvatures jump.
    let spline = curve(
        line_of(2, &[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]),
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [2.0, 5.0]],
    );
    let joints = shape_of(&spline).joints;
    assert_eq!(orders(&joints[0]), (1, 1, 1));
    let [before, behind] = joints[0].curvature;
    near(joints[0].jump, (before - behind).abs(), 1e-13);
    assert!(joints[0].jump > 0.1);
    // A cubic one has continuous curvature whatever its control points.
    let spline = curve(
        line_of(3, &[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0]),
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [2.0, 5.0], [0.0, 5.0]],
    );
    let joints = shape_of(&spline).joints;
    assert_eq!(orders(&joints[0]), (2, 2, 2));
    assert!(joints[0].jump < 1e-13);
    // A knot of multiplicity p + 1 may be a gap.
    let apart = curve(
        line_of(1, &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0]),
        &[[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [4.0, 3.0]],
    );
    let joints = shape_of(&apart).joints;
    assert_eq!(orders(&joints[0]), (-1, -1, -1));
    near(joints[0].gap, 3.0, 1e-15);
}

/// Where the derivative vanishes there is no curvature, no tangent and no NaN among the extremes.
#[test]
fn degenerate_places_have_no_curvature() {
    let places = [[1.0, 1.0], [1.0, 1.0], [2.0, 4.0], [5.0, 4.0]];
    let shape = shape_of(&curve(bezier(3), &places));
    assert_eq!(shape.degenerate, [0.0]);
    assert!(shape.samples.curvature[0].is_nan());
    assert!(shape.samples.curvature[1..].iter().all(|x| x.is_finite()));
    assert!(shape.extremes.largest.unwrap().value.is_finite());
    // A point that is one all along.
    let shape = shape_of(&curve(bezier(2), &[[1e6, 1.1]; 3]));
    assert_eq!(shape.extremes.largest, None);
    near(shape.length, 0.0, 1e-9);
    assert!(shape.samples.curvature.iter().all(|x| x.is_nan()));
    // A cusp at a knot.
    let cusp = curve(
        line_of(2, &[0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]),
        &[[0.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [3.0, 1.0]],
    );
    let joint = shape_of(&cusp).joints.remove(0);
    assert!(joint.angle.is_nan());
    assert_eq!(joint.geometric, 0);
}

/// Of more knots than are listed those with corners are listed.
#[test]
fn the_least_smooth_knots_are_listed() {
    let count = MOST_JOINTS + 500;
    let u: Vec<f64> = (0..count + 2).map(|i| i as f64).collect();
    let knots = [vec![0.0], u.clone(), vec![(count + 1) as f64]].concat();
    let places: Vec<[f64; 2]> = (0..count + 2)
        .map(|i| [i as f64, if i == 10_300 { 1.0 } else { 0.0 }])
        .collect();
    let shape = shape_of(&curve(line_of(1, &knots), &places));
    assert_eq!(
        (shape.joint_count, shape.joints.len()),
        (count, MOST_JOINTS)
    );
    let corners = shape.joints.iter().filter(|joint| joint.geometric == 0);
    let corners: Vec<f64> = corners.map(|joint| joint.parameter).collect();
    assert_eq!(corners, [10_299.0, 10_300.0, 10_301.0]);
}

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
