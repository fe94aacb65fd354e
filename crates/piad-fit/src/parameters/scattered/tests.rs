//! Cylinders and spheres near points, what unfolds them, and fits with these parameters.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::{Fit, Surface};

/// Numbers in [0, 1) that spread evenly, another sequence for each step.
fn spread(i: usize, step: f64) -> f64 {
    (0.5 + i as f64 * step).fract()
}

const STEPS: [f64; 3] = [0.819_172_513, 0.671_043_607, 0.549_700_478];

/// An error of one of the points, within the noise.
fn error(i: usize, axis: usize, noise: f64) -> f64 {
    noise * (2.0 * spread(i * 3 + axis, 0.618_033_989) - 1.0)
}

/// Points of a surface over the unit square.
fn scan(count: usize, noise: f64, place: impl Fn(f64, f64) -> [f64; 3]) -> Points {
    let mut points = Points::new(3);
    for i in 0..count {
        let [x, y, z] = place(spread(i, STEPS[0]), spread(i, STEPS[1]));
        points.push(&[
            x + error(i, 0, noise),
            y + error(i, 1, noise),
            z + error(i, 2, noise),
        ]);
    }
    points
}

/// Turned about two axes and moved.
fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (a, b) = (0.7_f64, 0.4_f64);
    let [x, y] = [a.cos() * x - a.sin() * y, a.sin() * x + a.cos() * y];
    let [y, z] = [b.cos() * y - b.sin() * z, b.sin() * y + b.cos() * z];
    [x + 100.0, y - 40.0, z + 7.0]
}

fn tube(s: f64, t: f64) -> [f64; 3] {
    let (angle, height) = (TAU * s, 80.0 * t);
    let radius = 15.0 + 1.5 * (3.0 * angle).sin() + 0.05 * height;
    [radius * angle.cos(), radius * angle.sin(), height]
}

/// A sector of a pipe with radius 20.
fn pipe(degrees: f64) -> impl Fn(f64, f64) -> [f64; 3] {
    move |s, t| {
        let angle = degrees.to_radians() * s;
        [20.0 * angle.cos(), 20.0 * angle.sin(), 60.0 * t]
    }
}

/// A sphere of radius 25 from the north pole to a latitude.
fn dome(lowest: f64) -> impl Fn(f64, f64) -> [f64; 3] {
    move |s, t| {
        let height = lowest.sin() + (1.0 - lowest.sin()) * t;
        let (angle, out) = (TAU * s, (1.0 - height * height).max(0.0).sqrt());
        [
            25.0 * out * angle.cos(),
            25.0 * out * angle.sin(),
            25.0 * height,
        ]
    }
}

/// Distances between neighbours around a cylinder are arcs, whatever its place and the magnitude of the points.
#[test]
fn cylinders_are_found() {
    for degrees in [90.0, 220.0, 360.0] {
        let place = |s, t| turned(pipe(degrees)(s, t));
        for scale in [1.0, 1e-120, 1e120] {
            let points = scan(900, 0.0, |s, t| place(s, t).map(|x| x * scale));
            let Pairs { values, domains } = Scattered::Cylinder(Cylinder::default())
                .parameters(&points, [false; 2])
                .unwrap();
            for i in 1..900 {
                let [around, along] =
                    [0, 1].map(|k| (values.lane(k)[i] - values.lane(k)[0]).abs() / scale);
                let angle =
                    degrees.to_radians() * (spread(i, STEPS[0]) - spread(0, STEPS[0])).abs();
                let arcs = [20.0 * angle, 20.0 * (TAU - angle)];
                assert!(
                    arcs.iter().any(|arc| (around - arc).abs() < 1e-9),
                    "{around} {arcs:?}"
                );
                let height = 60.0 * (spread(i, STEPS[1]) - spread(0, STEPS[1])).abs();
                assert!((along - height).abs() < 1e-9, "{along} {height}");
            }
            let is_closed = matches!(domains[0], Domain::Closed(period) if (period / scale - 40.0 * PI).abs() < 1e-9);
            assert_eq!(is_closed, degrees == 360.0);
        }
    }
}

/// A given axis and centre are used; a direction that is requested as closed is closed.
#[test]
fn cylinders_are_taken_as_they_are_given() {
    let points = scan(500, 0.5, pipe(200.0));
    let given = Cylinder {
        axis: Some([0.0, 0.0, -2.0]),
        center: Some([0.0, 0.0, 9.0]),
    };
    let pairs = Scattered::Cylinder(given)
        .parameters(&points, [true, false])
        .unwrap();
    let heights = points.lane(2);
    let along = pairs.values.lane(1);
    assert!((0..500).all(|i| (along[i] - along[0] + heights[i] - heights[0]).abs() < 1e-10));
    assert!(
        matches!(pairs.domains, [Domain::Closed(period), Domain::Data] if (period - 40.0 * PI).abs() < 0.5)
    );
    let no_axis = Cylinder {
        axis: Some([0.0; 3]),
        ..given
    };
    let found = Scattered::Cylinder(no_axis).parameters(&points, [false; 2]);
    assert!(found.unwrap_err().to_string().contains("direction"));
}

/// Longitudes and latitudes of a whole sphere, of most of it, of half of it and of a small part.
#[test]
fn spheres_are_found() {
    let of = |lowest: f64| {
        let points = scan(2_000, 0.0, |s, t| turned(dome(lowest)(s, t)));
        Scattered::Sphere(Sphere::default())
            .parameters(&points, [false; 2])
            .unwrap()
    };
    let half = 12.5 * PI;
    for (lowest, both) in [(-PI / 2.0, [true, true]), (-0.5, [false, true])] {
        let Pairs { domains, .. } = of(lowest);
        assert!(matches!(domains[0], Domain::Closed(period) if (period - 50.0 * PI).abs() < 1e-9));
        let Domain::Between { ends, poles } = domains[1] else {
            panic!("{domains:?}");
        };
        assert_eq!(poles, both);
        let low = if both[0] { -half } else { 25.0 * lowest };
        assert!(
            (ends[0] - low).abs() < 0.1 && (ends[1] - half).abs() < 1e-9,
            "{ends:?}"
        );
    }
    assert_eq!(of(1.0).domains, [Domain::Data; 2]);
}

/// Points on a line, on a plane and all equal have no cylinder and no sphere; those of a plane none either.
#[test]
fn points_without_a_surface_are_refused() {
    let refused = |points: &Points| {
        for rule in [
            Scattered::Cylinder(Cylinder::default()),
            Scattered::Sphere(Sphere::default()),
        ] {
            let found = rule.parameters(points, [false; 2]).unwrap_err().to_string();
            assert!(
                found.contains("cylinder") || found.contains("sphere"),
                "{found}"
            );
        }
    };
    refused(&scan(50, 0.0, |s, _| [s, 2.0 * s, 3.0 * s]));
    refused(&scan(50, 0.0, |_, _| [1.0, 2.0, 3.0]));
    refused(&Points::from_lanes([
        vec![0.0, 1.0, 0.0],
        vec![0.0, 0.0, 1.0],
    ]));
    let flat = scan(50, 0.0, |s, t| [s, t, 0.0]);
    let sphere = Scattered::Sphere(Sphere::default()).parameters(&flat, [false; 2]);
    assert!(sphere.unwrap_err().to_string().contains("plane"));
}

/// Steep heights have one place each over x and y, and fold on the plane nearest to them (Franke's function).
#[test]
fn heights_that_fold_on_the_nearest_plane_have_those_of_x_and_y() {
    let franke = |x: f64, y: f64| {
        let hill = |a: f64, b: f64| (-(9.0 * x - a).powi(2) - (9.0 * y - b).powi(2)) / 4.0;
        0.75 * hill(2.0, 2.0).exp()
            + 0.75 * (-(9.0 * x + 1.0).powi(2) / 49.0 - (9.0 * y + 1.0) / 10.0).exp()
            + 0.5 * hill(7.0, 3.0).exp()
            - 0.2 * (4.0 * hill(4.0, 7.0)).exp()
    };
    for (height, is_steep) in [(0.2, false), (0.8, true), (1.0, true), (1.5, true)] {
        let points = scan(5_000, 0.0, |x, y| [x, y, height * franke(x, y)]);
        let rule = Scattered::Auto.chosen(&points).unwrap();
        let expected = match is_steep {
            true => Scattered::Coordinates(CoordinatePlane::Xy),
            false => Scattered::Plane,
        };
        assert_eq!(rule, expected, "{height}");
    }
    let points = scan(1_500, 0.0, |x, y| [x, y, franke(x, y)]);
    let surface = fitted(&points, 0.01);
    assert!(surface.error().max <= 0.01);
}

/// Hills are unfolded by a plane, tubes and pipes by a cylinder, balls by a sphere.
#[test]
fn what_unfolds_best_is_chosen() {
    let name = |points: &Points| match Scattered::Auto.chosen(points).unwrap() {
        Scattered::Plane => "plane",
        Scattered::Cylinder(_) => "cylinder",
        Scattered::Sphere(_) => "sphere",
        other => panic!("{other:?}"),
    };
    let hills = |s: f64, t: f64| [100.0 * s, 60.0 * t, 5.0 * (7.0 * s).sin() * (5.0 * t).cos()];
    assert_eq!(
        name(&scan(3_000, 0.05, |s, t| turned(hills(s, t)))),
        "plane"
    );
    assert_eq!(
        name(&scan(3_000, 0.05, |s, t| turned(tube(s, t)))),
        "cylinder"
    );
    assert_eq!(
        name(&scan(3_000, 0.05, |s, t| turned(pipe(220.0)(s, t)))),
        "cylinder"
    );
    assert_eq!(name(&scan(3_000, 0.05, dome(-PI / 2.0))), "sphere");
    let flat = scan(500, 0.0, |s, t| [s, t, 0.0]);
    assert_eq!(name(&flat), "plane");
}

/// The fit of a scan by parameters of its own, within a tolerance.
fn fitted(points: &Points, tolerance: f64) -> Surface {
    let points: Vec<[f64; 3]> = (0..points.len())
        .map(|i| [0, 1, 2].map(|axis| points.lane(axis)[i]))
        .collect();
    let fit = Fit::scattered(&points, Scattered::Auto).tolerance(tolerance);
    fit.prepare().unwrap().solve().unwrap()
}

/// A tube is closed without a seam: points and derivatives there are the same on both sides.
#[test]
fn a_tube_is_fitted_closed() {
    let noise = 0.03;
    let surface = fitted(&scan(3_000, noise, tube), 4.0 * noise);
    let [(start, end), (low, high)] = surface.domain();
    for k in 0..=20 {
        let v = low + (high - low) * f64::from(k) / 20.0;
        let [here, there] = [start, end].map(|u| (surface.eval(u, v), surface.derivatives(u, v)));
        for c in 0..3 {
            assert!((here.0[c] - there.0[c]).abs() < 1e-10);
            for d in 0..2 {
                assert!((here.1[d][c] - there.1[d][c]).abs() < 1e-10);
            }
        }
        // Between the points it is as near to the tube.
        for u in (0..40).map(|k| start + (end - start) * f64::from(k) / 40.0) {
            let [x, y, z]: [f64; 3] = surface.eval(u, v).try_into().unwrap();
            let [a, b, _] = tube(y.atan2(x).rem_euclid(TAU) / TAU, z / 80.0);
            assert!((a - x).hypot(b - y) < 5.0 * noise, "{x} {y} {z}");
        }
    }
}

/// A pipe of 220 degrees is open, and a ball has poles at which all points are one.
#[test]
fn pipes_and_balls_are_fitted() {
    let pipe = fitted(&scan(3_000, 0.02, pipe(220.0)), 0.08);
    let distance = |u: f64, v: f64| {
        let place = pipe.eval(u, v);
        place[0].hypot(place[1]) - 20.0
    };
    let ball = fitted(&scan(3_000, 0.0, dome(-PI / 2.0)), 0.01);
    let [(start, end), (low, high)] = ball.domain();
    let [(from, to), (bottom, top)] = pipe.domain();
    for (i, j) in (0..=30).flat_map(|i| (0..=30).map(move |j| (i, j))) {
        let [s, t] = [i, j].map(|k| f64::from(k) / 30.0);
        assert!(distance(from + (to - from) * s, bottom + (top - bottom) * t).abs() < 0.15);
        let place = ball.eval(start + (end - start) * s, low + (high - low) * t);
        let radius = place.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
        assert!((radius - 25.0).abs() < 0.03, "{radius}");
    }
    for v in [low, high] {
        let pole = ball.eval(start, v);
        for k in 1..10 {
            let place = ball.eval(start + (end - start) * f64::from(k) / 10.0, v);
            let pairs = place.iter().zip(&pole);
            assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }
}
