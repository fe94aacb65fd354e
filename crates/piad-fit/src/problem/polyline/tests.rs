//! Polylines, compared with known properties.

use std::f64::consts::FRAC_PI_2;

use crate::basis::Corners;
use crate::invalid::Place;
use crate::{Curve, Fit};

/// A rectangle with round corners: edges with two points, and arcs with one every 7.5 degrees.
fn rounded() -> Vec<[f64; 2]> {
    let (width, height, radius) = (120.0, 70.0, 15.0);
    let centres = [
        [width - radius, radius],
        [width - radius, height - radius],
        [radius, height - radius],
        [radius, radius],
    ];
    let arc = |corner: usize| {
        let [x, y] = centres[corner];
        (0..=12).map(move |k| {
            let angle = (corner as f64 - 1.0 + f64::from(k) / 12.0) * FRAC_PI_2;
            [x + radius * angle.cos(), y + radius * angle.sin()]
        })
    };
    (0..4).flat_map(arc).collect()
}

/// How far a point is from a polyline.
fn distance(point: &[f64], polyline: &[[f64; 2]], closed: bool) -> f64 {
    let edges = polyline.len() - usize::from(!closed);
    let to_edge = |i: usize| {
        let (a, b) = (polyline[i], polyline[(i + 1) % polyline.len()]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy);
        let along = along.clamp(0.0, 1.0);
        (point[0] - a[0] - along * dx).hypot(point[1] - a[1] - along * dy)
    };
    (0..edges).map(to_edge).fold(f64::INFINITY, f64::min)
}

/// The largest distances of a curve from a polyline, and of its edges from the curve.
fn distances(curve: &Curve, polyline: &[[f64; 2]], closed: bool) -> [f64; 2] {
    let (low, high) = curve.nurbs().u.domain();
    let places = (0..=4000).map(|k| low + (high - low) * f64::from(k) / 4000.0);
    let samples: Vec<[f64; 2]> = places
        .map(|t| curve.eval(t))
        .map(|p| [p[0], p[1]])
        .collect();
    let from_polyline = samples
        .iter()
        .map(|point| distance(point, polyline, closed));
    let edges = polyline.len() - usize::from(!closed);
    let along = (0..edges * 10).map(|k| {
        let (i, part) = (k / 10, (k % 10) as f64 / 10.0);
        let (a, b) = (polyline[i], polyline[(i + 1) % polyline.len()]);
        [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
    });
    let from_curve = along.map(|point| distance(&point, &samples, false));
    [
        from_polyline.fold(0.0, f64::max),
        from_curve.fold(0.0, f64::max),
    ]
}

/// All edges are within the tolerance, in both directions, with few control points.
#[test]
fn edges_are_within_the_tolerance() {
    let outline = rounded();
    for (tolerance, most) in [(0.1, 32), (0.01, 180)] {
        let fit = Fit::curve(&outline)
            .closed()
            .polyline()
            .tolerance(tolerance);
        let curve = fit.prepare().unwrap().solve().unwrap();
        let count = curve.nurbs().points.len();
        assert!(count <= most, "{tolerance}: {count}");
        let off = distances(&curve, &outline, true);
        assert!(
            off.iter().all(|off| *off <= 1.001 * tolerance),
            "{tolerance}: {off:?}"
        );
        assert!(curve.error().max <= tolerance);
    }
}

/// Vertices that turn by more than 30 degrees are kept, whatever those around them do.
#[test]
fn corners_of_polylines_are_kept() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let fit = || Fit::curve(&square).closed().polyline().tolerance(1e-9);
    let curve = fit().prepare().unwrap().solve().unwrap();
    assert_eq!(curve.nurbs().points.len(), 13);
    let off = distances(&curve, &square, true);
    assert!(off.iter().all(|off| *off < 1e-12), "{off:?}");
    // Stairs: all vertices are corners, and so are none of them.
    let stairs: Vec<[f64; 2]> = (0..21)
        .map(|i| [f64::from((i + 1) / 2), f64::from(i / 2)])
        .collect();
    let fit = |corners: Option<Corners>| {
        let fit = Fit::curve(&stairs).polyline().tolerance(0.05);
        match corners {
            Some(corners) => fit.corners(corners),
            None => fit,
        }
    };
    let curve = fit(None).prepare().unwrap().solve().unwrap();
    assert_eq!(curve.nurbs().points.len(), 61);
    let smooth = fit(Some(Corners::Found(100.0)))
        .prepare()
        .unwrap()
        .solve()
        .unwrap();
    let off = distances(&smooth, &stairs, false);
    assert!(off.iter().all(|off| *off <= 0.0501), "{off:?}");
}

/// Every kind of validation error at its location.
#[test]
fn invalid_polylines_are_named() {
    let place = |points: &[[f64; 2]]| Fit::curve(points).polyline().prepare().unwrap_err().place;
    assert_eq!(place(&[[0.0, 0.0], [1.0, 0.0]]), Place::Points);
    assert_eq!(
        place(&[[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]),
        Place::Point(1)
    );
    let bend = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    let fit = || Fit::curve(&bend).polyline();
    let invalid = [
        fit().control_points(3),
        fit().method(crate::method::Method::Global),
        fit().weights(vec![1.0; 3]),
    ];
    for fit in invalid {
        assert_eq!(fit.prepare().unwrap_err().place, Place::Polyline);
    }
    let values = Fit::curve(&[[0.0], [1.0], [0.0]]).polyline();
    assert_eq!(values.prepare().unwrap_err().place, Place::Polyline);
    let angle = fit().corners(Corners::Found(0.0)).prepare().unwrap_err();
    assert_eq!(angle.place, Place::Corners(crate::invalid::Axis::U));
}
