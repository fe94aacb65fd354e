//! Curves with closed forms.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::{bezier, curve, line_of, near, quarters};
use crate::data::points::Points;
use crate::geometry::curvature::{CurveShape, Joint, MOST_JOINTS};
use crate::geometry::nurbs::Nurbs;

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
fn knots_show_the_measured_continuity() {
    // A polygon with a corner of 90 degrees, and a knot where it continues straight on with another
    // speed.
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
    // A curve that is a single point.
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
