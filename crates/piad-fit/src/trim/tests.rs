//! Outlines of points whose region is known.

use std::f64::consts::PI;

use super::*;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::fit::Fit;
use crate::geometry::outline::polyline;
use crate::geometry::trimmed_area::trimmed_area;
use crate::method::{LeastSquares, Method};
use crate::parameters::Parametrization;
use crate::parameters::scattered::{CoordinatePlane, Cylinder, Scattered, Sphere};
use crate::problem::request::Request;
use crate::shape::Surface;

/// Points of the square from −1 to 1 that a sequence of low discrepancy gives, where they are `inside`.
fn points(count: usize, inside: impl Fn(f64, f64) -> bool) -> Vec<[f64; 3]> {
    let part = |k: usize, step: f64| 2.0 * (k as f64 * step).fract() - 1.0;
    let all = (0..count).map(|k| [part(k, 0.754_877_666), part(k, 0.569_840_29)]);
    let kept = all.filter(|[x, y]| inside(*x, *y));
    kept.map(|[x, y]| [x, y, 0.1 * x * y]).collect()
}

fn plan() -> Scattered {
    Scattered::Coordinates(CoordinatePlane::Xy)
}

fn outline_of(fit: Fit<Surface>) -> Result<Outline, Invalid> {
    let fit = fit.degree(1).control_points(2, 2).prepare()?;
    let surface = fit.solve().unwrap();
    Ok(surface.outline().unwrap().clone())
}

fn of_points(points: &[[f64; 3]]) -> Outline {
    outline_of(Fit::scattered(points, plan()).trimmed()).unwrap()
}

/// The areas that the loops go around, counter-clockwise ones first.
fn areas(outline: &Outline) -> Vec<f64> {
    let area = |curve: &Nurbs| {
        let line = polyline(curve, [1.0; 2], 1e-3);
        let twice = line
            .windows(2)
            .map(|p| p[0][0] * p[1][1] - p[0][1] * p[1][0]);
        0.5 * twice.sum::<f64>()
    };
    let mut areas: Vec<f64> = outline.loops.iter().map(area).collect();
    areas.sort_by(|a, b| b.total_cmp(a));
    areas
}

/// True if a point is on the left of all loops.
fn is_inside(outline: &Outline, [x, y]: [f64; 2]) -> bool {
    let lines = outline.loops.iter().map(|it| polyline(it, [1.0; 2], 1e-2));
    let crossings = lines.flat_map(|line| {
        let above = line.windows(2).filter(|p| (p[0][1] > y) != (p[1][1] > y));
        let right = above.filter(|p| {
            let part = (y - p[0][1]) / (p[1][1] - p[0][1]);
            p[0][0] + part * (p[1][0] - p[0][0]) > x
        });
        right.map(|_| ()).collect::<Vec<()>>()
    });
    crossings.count() % 2 == 1
}

/// The distance of a point from the nearest loop.
fn distance(outline: &Outline, [x, y]: [f64; 2]) -> f64 {
    let points = outline
        .loops
        .iter()
        .flat_map(|it| polyline(it, [1.0; 2], 1e-2));
    let distances = points.map(|[a, b]| (a - x).hypot(b - y));
    distances.fold(f64::INFINITY, f64::min)
}

/// Loops are closed, clamped and within the rectangle; no point is further outside than the distance.
fn check(outline: &Outline, points: &[[f64; 3]]) {
    for curve in &outline.loops {
        let (knots, count) = (&curve.u.knots, curve.points.len());
        assert_eq!(knots.len(), count + 4);
        assert!(knots[0] == knots[3] && knots[count] == knots[count + 3]);
        for axis in 0..2 {
            let lane = curve.points.lane(axis);
            assert_eq!(lane[0], lane[count - 1]);
            let along = points.iter().map(|it| it[axis]);
            let (low, high) = along.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            assert!(lane.iter().all(|x| (low..=high).contains(x)));
        }
    }
    for &[x, y, _] in points {
        let is_near = is_inside(outline, [x, y]) || distance(outline, [x, y]) < outline.distance;
        assert!(is_near, "({x}, {y})");
    }
}

#[test]
fn a_disc_has_one_round_loop() {
    let points = points(4000, |x, y| x.hypot(y) < 0.9);
    let outline = of_points(&points);
    check(&outline, &points);
    assert_eq!(outline.faces.len(), 1);
    let area = areas(&outline)[0];
    assert!((area / (0.81 * PI) - 1.0).abs() < 0.05, "{area}");
    assert!(
        outline.loops[0].points.len() < 120,
        "{}",
        outline.loops[0].points.len()
    );
}

#[test]
fn a_ring_has_a_hole() {
    let points = points(6000, |x, y| (0.4..0.9).contains(&x.hypot(y)));
    let outline = of_points(&points);
    check(&outline, &points);
    assert_eq!((outline.loops.len(), outline.faces.len()), (2, 1));
    assert_eq!(outline.faces[0].holes, 1..2);
    let [outer, hole] = areas(&outline)[..] else {
        panic!()
    };
    assert!((outer / (0.81 * PI) - 1.0).abs() < 0.05, "{outer}");
    assert!((hole / (-0.16 * PI) - 1.0).abs() < 0.15, "{hole}");
}

#[test]
fn islands_are_pieces_of_their_own() {
    let inside = |x: f64, y: f64| (x - 0.5).hypot(y) < 0.3 || (x + 0.5).hypot(y) < 0.35;
    let points = points(6000, inside);
    let outline = of_points(&points);
    check(&outline, &points);
    assert_eq!((outline.loops.len(), outline.faces.len()), (2, 2));
    for (area, radius) in areas(&outline).iter().zip([0.35, 0.3]) {
        assert!((area / (radius * radius * PI) - 1.0).abs() < 0.12, "{area}");
    }
}

#[test]
fn a_full_rectangle_is_not_trimmed() {
    let outline = of_points(&points(3000, |_, _| true));
    assert!(outline.is_whole() && outline.faces.is_empty());
    let three = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.3, 1.0, 0.0],
        [0.9, 0.8, 0.0],
    ];
    assert!(of_points(&three).is_whole());
}

#[test]
fn half_a_rectangle_keeps_its_straight_sides() {
    let points = points(4000, |x, y| x + 0.2 * (9.0 * y).sin() < 0.1);
    let outline = of_points(&points);
    check(&outline, &points);
    let curve = &outline.loops[0];
    let corners = curve.u.multiplicities();
    let corners = corners.iter().filter(|(_, times)| *times >= 3).count();
    assert!((6..=11).contains(&corners), "{corners}");
    assert!((areas(&outline)[0] - 2.2).abs() < 0.1);
}

#[test]
fn distances_are_returned_on_request() {
    let points = points(4000, |x, y| x.hypot(y) < 0.9);
    let fit = |distance| Fit::scattered(&points, plan()).trimmed_within(distance);
    let outline = outline_of(fit(0.2)).unwrap();
    assert_eq!(outline.distance, 0.2);
    check(&outline, &points);
    for (distance, words) in [
        (0.0, "greater than 0"),
        (-1.0, "greater than 0"),
        (f64::NAN, "greater than 0"),
        (1e-3, "leaves nothing between neighbouring points"),
    ] {
        let error = outline_of(fit(distance)).unwrap_err();
        assert_eq!(error.place, Place::TrimDistance);
        assert!(error.to_string().contains(words), "{error}");
    }
    assert!(outline_of(fit(1e300)).unwrap().is_whole());
}

/// Lines of points far from each other are no stripes.
#[test]
fn lines_of_points_belong_together() {
    let lines =
        (0..12).flat_map(|j| (0..400).map(move |i| [f64::from(i) / 200.0, f64::from(j) / 6.0]));
    let points: Vec<[f64; 3]> = lines
        .filter(|[x, y]| x + y < 2.0)
        .map(|[x, y]| [x, y, 0.0])
        .collect();
    let outline = of_points(&points);
    assert_eq!(outline.loops.len(), 1);
    assert!(
        (areas(&outline)[0] - 1.85).abs() < 0.4,
        "{:?}",
        areas(&outline)
    );
}

#[test]
fn a_grid_with_a_gap_has_a_hole() {
    let (rows, columns) = (40, 30);
    let mut points = Points::new(3);
    (0..rows * columns)
        .for_each(|k| points.push(&[(k / columns) as f64, 2.0 * (k % columns) as f64, 0.0]));
    let is_gap = |k: &usize| (10..20).contains(&(k / columns)) && (8..16).contains(&(k % columns));
    let direction = || {
        let basis = BasisChoice::BSpline {
            degree: 1,
            knots: Knots::Usual,
        };
        DirectionChoice::new(basis, Parametrization::Uniform)
    };
    let request = Request {
        missing: (0..rows * columns).filter(is_gap).collect(),
        method: Method::LeastSquares(LeastSquares::new(3, 3)),
        trim: Some(Trim::default()),
        ..Request::new(
            points,
            Grid { rows, columns },
            direction(),
            Some(direction()),
        )
    };
    let problem = trimmed(Problem::new(request).unwrap()).unwrap();
    let outline = problem.outline().unwrap();
    assert_eq!((outline.loops.len(), outline.faces.len()), (2, 1));
    let [outer, hole] = areas(outline)[..] else {
        panic!()
    };
    assert!((outer - 1.0).abs() < 1e-12, "{outer}");
    assert!((hole * 39.0 * 29.0 + 80.0).abs() < 12.0, "{hole}");
    assert!((outline.distance - 2.0).abs() < 1e-9);
}

/// The ends of a tube are cut obliquely: its outline goes along both sides of the seam.
#[test]
fn a_tube_is_cut_at_its_seam() {
    let points: Vec<[f64; 3]> = (0..8000)
        .map(|k| {
            [
                (k as f64 * 0.754_877_666).fract(),
                (k as f64 * 0.569_840_29).fract(),
            ]
        })
        .map(|[a, b]| [2.0 * PI * a, 6.0 * b])
        .filter(|[a, z]| *z > 1.0 + 0.5 * a.cos())
        .map(|[a, z]| [a.cos(), a.sin(), z])
        .collect();
    let cylinder = Scattered::Cylinder(Cylinder {
        axis: Some([0.0, 0.0, 1.0]),
        center: None,
    });
    let fit = Fit::scattered(&points, cylinder).trimmed();
    let fit = fit.control_points(8, 4).prepare().unwrap();
    let surface = fit.solve().unwrap();
    let outline = surface.outline().unwrap();
    assert_eq!((outline.loops.len(), outline.faces.len()), (1, 1));
    let area = areas(outline)[0];
    assert!((area / (2.0 * PI * 5.0) - 1.0).abs() < 0.03, "{area}");
    let [(low, high), _] = surface.domain();
    let u = outline.loops[0].points.lane(0);
    assert!(u.contains(&low) && u.contains(&high));
}

/// The area of a plane disc, and of a rectangle that is not trimmed.
#[test]
fn areas_are_those_of_the_surface() {
    for radius in [0.9, 2.0] {
        let points = points(4000, |x, y| x.hypot(y) < radius);
        let flat: Vec<[f64; 3]> = points.iter().map(|&[x, y, _]| [x, y, 0.75 * x]).collect();
        let fit = Fit::scattered(&flat, plan()).trimmed();
        let surface = fit.control_points(5, 6).prepare().unwrap().solve().unwrap();
        let outline = surface.outline().unwrap();
        let [(a, b), (c, d)] = surface.domain();
        let plan = match outline.is_whole() {
            true => (b - a) * (d - c),
            false => areas(outline)[0],
        };
        let area = trimmed_area(surface.nurbs(), outline).unwrap();
        assert!((area / (1.25 * plan) - 1.0).abs() < 1e-4, "{area} {plan}");
    }
}

/// A ball is whole, although its parameters are far apart near the poles; with a bite in its side it has a hole.
#[test]
fn a_ball_has_its_poles() {
    for bite in [false, true] {
        let points: Vec<[f64; 3]> = (0..6000)
            .map(|k| {
                [
                    (k as f64 * 0.754_877_666).fract(),
                    (k as f64 * 0.569_840_29).fract(),
                ]
            })
            .map(|[a, z]| (2.0 * PI * a, 2.0 * z - 1.0))
            .map(|(a, z)| (a, z, (1.0 - z * z).sqrt()))
            .map(|(a, z, r)| [10.0 * r * a.cos(), 10.0 * r * a.sin(), 10.0 * z])
            .filter(|[x, y, z]| !bite || *x < 0.0 || y.hypot(*z) > 4.0)
            .collect();
        let sphere = Scattered::Sphere(Sphere {
            axis: Some([0.0, 0.0, 1.0]),
            center: Some([0.0; 3]),
        });
        let fit = Fit::scattered(&points, sphere).trimmed();
        let surface = fit.tolerance(0.5).prepare().unwrap().solve().unwrap();
        let outline = surface.outline().unwrap();
        let area = trimmed_area(surface.nurbs(), outline).unwrap();
        // A cap, seen from the middle.
        let cap = 2.0 * PI * 100.0 * (1.0 - 0.84_f64.sqrt());
        let expected = 400.0 * PI - if bite { cap } else { 0.0 };
        assert!((area / expected - 1.0).abs() < 0.03, "{area} {expected}");
        assert_eq!(outline.is_whole(), !bite);
    }
}
