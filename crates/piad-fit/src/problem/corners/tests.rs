//! Curves with corners, compared with known properties.

use std::sync::Arc;

use crate::basis::{BasisChoice, Corners, Knots};
use crate::invalid::{Axis, Invalid, Place};
use crate::method::{LeastSquares, Method, Variant};
use crate::{Curve, Fit};

fn at(indices: &[usize]) -> Corners {
    Corners::At(Arc::from(indices))
}

/// Six edges with five points each, but for the last one, which has four.
fn zigzag() -> Vec<[f64; 2]> {
    (0..24)
        .map(|i| [f64::from(i), f64::from((i % 8 - 4_i32).abs())])
        .collect()
}

/// The largest distance of a curve from the zigzag.
fn from_zigzag(curve: &Curve, t: &[f64]) -> f64 {
    let (low, high) = (t[0], t[t.len() - 1]);
    let places = (0..=2000).map(|k| low + (high - low) * f64::from(k) / 2000.0);
    let height = |x: f64| (x.rem_euclid(8.0) - 4.0).abs();
    let points = places.map(|t| curve.eval(t));
    let distances = points.map(|point| (point[1] - height(point[0])).abs());
    distances.fold(0.0, f64::max)
}

/// Edges are straight to rounding, by each method, and as many control points as data or as edges need.
#[test]
fn edges_between_corners_are_straight() {
    let methods = [
        Method::Direct,
        Method::Global,
        Method::Chebyshev,
        Method::Transpose,
        Method::LeastSquares(LeastSquares::new(16, 0)),
        Method::LeastSquares(LeastSquares {
            variant: Variant::Direct,
            ..LeastSquares::new(16, 0)
        }),
        // Each edge with two control points.
        Method::LeastSquares(LeastSquares {
            variant: Variant::Direct,
            ..LeastSquares::new(7, 0)
        }),
    ];
    for method in methods {
        for degree in [1, 2, 3, 4, 5] {
            let fit = Fit::curve(&zigzag()).degree(degree).method(method.clone());
            let fit = fit
                .corners(Corners::USUAL)
                .tolerance(1e-10)
                .max_iterations(10_000);
            let fit = fit.prepare().unwrap();
            let curve = fit
                .solve()
                .unwrap_or_else(|error| panic!("{method:?} {degree}: {error}"));
            let off = from_zigzag(&curve, fit.parameters());
            assert!(off < 1e-9, "{method:?} {degree}: {off:e}");
        }
    }
}

/// A piece between two corners is the curve of its points alone.
#[test]
fn pieces_are_fitted_by_themselves() {
    let x = |i: usize| i as f64 + 0.3 * (i as f64).sin();
    let points: Vec<[f64; 2]> = (0..30)
        .map(|i| [x(i), (0.7 * x(i)).sin() + f64::from(u8::from(i > 11))])
        .collect();
    let whole = Fit::curve(&points)
        .corners(at(&[12, 14, 17]))
        .method(Method::Direct)
        .prepare()
        .unwrap();
    let t = whole.parameters().to_vec();
    let curve = whole.solve().unwrap();
    for (from, to) in [(0, 12), (12, 14), (14, 17), (17, 29)] {
        // Few points have the polynomial through them.
        let degree = 3.min(to - from);
        let averaged = BasisChoice::BSpline {
            degree,
            knots: Knots::Averaged,
        };
        let part = Fit::curve(&points[from..=to])
            .basis(averaged)
            .method(Method::Direct)
            .prepare()
            .unwrap();
        let s = part.parameters().to_vec();
        let part = part.solve().unwrap();
        for k in 0..=50 {
            let share = f64::from(k) / 50.0;
            let on_whole = curve.eval(t[from] + share * (t[to] - t[from]));
            let on_part = part.eval(s[0] + share * (s[to - from] - s[0]));
            for (a, b) in on_whole.iter().zip(&on_part) {
                assert!((a - b).abs() < 1e-12, "{from} {to} {share}");
            }
        }
    }
}

/// The corners of a square, which is a cubic of thirteen control points.
#[test]
fn squares_are_squares() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let fit = Fit::curve(&square)
        .corners(at(&[1, 2, 3]))
        .method(Method::Global)
        .prepare()
        .unwrap();
    let curve = fit.solve().unwrap();
    assert_eq!(curve.nurbs().points.len(), 13);
    for k in 0..=400 {
        let point = curve.eval(fit.parameters()[4] * f64::from(k) / 400.0);
        let off = (0..4).map(|side| match side {
            0 => point[0].abs(),
            1 => point[1].abs(),
            2 => (1.0 - point[0]).abs(),
            _ => (1.0 - point[1]).abs(),
        });
        assert!(off.fold(f64::INFINITY, f64::min) < 1e-15, "{point:?}");
    }
}

/// A closed curve is the open one from its first corner to itself, whichever point is the first.
#[test]
fn closed_curves_begin_at_a_corner() {
    let angle = angle_of;
    let radius = |i: usize| {
        1.0 + 0.2 * (3.0 * angle(i)).cos() + 0.2 * f64::from(u8::from(i == 5 || i == 17))
    };
    let points: Vec<[f64; 2]> = (0..24)
        .map(|i| [radius(i) * angle(i).cos(), radius(i) * angle(i).sin()])
        .collect();
    let turned: Vec<[f64; 2]> = (5..=29).map(|i| points[i % 24]).collect();
    let few = LeastSquares {
        variant: Variant::Direct,
        ..LeastSquares::new(14, 0)
    };
    let fewer = LeastSquares {
        variant: Variant::Direct,
        ..LeastSquares::new(13, 0)
    };
    for (closed, open) in [
        (Method::Direct, Method::Direct),
        (Method::Global, Method::Global),
        (Method::Chebyshev, Method::Direct),
        // One of the open curve is there twice.
        (Method::LeastSquares(fewer), Method::LeastSquares(few)),
    ] {
        let name = format!("{closed:?}");
        for degree in [1, 2, 3, 4] {
            let with = |fit: Fit<Curve>, method: &Method, corners: &[usize]| {
                let fit = fit
                    .degree(degree)
                    .method(method.clone())
                    .corners(at(corners));
                // Without a tolerance least squares ends at its minimum.
                let fit = match method {
                    Method::LeastSquares(_) => fit,
                    _ => fit.tolerance(1e-9).max_iterations(5000),
                };
                fit.prepare().unwrap()
            };
            let whole = with(Fit::curve(&points).closed(), &closed, &[5, 17]);
            let part = with(Fit::curve(&turned), &open, &[12]);
            let (t, s) = (whole.parameters()[5], part.parameters().to_vec());
            let [whole, part] = [whole, part].map(|fit| fit.solve().unwrap());
            assert_eq!(whole.nurbs().points.len(), part.nurbs().points.len());
            for k in 0..=100 {
                let share = f64::from(k) / 100.0;
                let on_part = part.eval(s[0] + share * (s[24] - s[0]));
                let on_whole = whole.eval(t + share * (s[24] - s[0]));
                for (a, b) in on_whole.iter().zip(&on_part) {
                    assert!((a - b).abs() < 1e-7, "{name} {degree} {share}: {a} {b}");
                }
            }
        }
    }
    // A drop, and a square of which no edge has points.
    let drop: Vec<[f64; 2]> = (0..24)
        .map(angle_of)
        .map(|a| [a.cos(), a.sin() * (a / 2.0).sin().powi(3)])
        .collect();
    let drop = Fit::curve(&drop)
        .closed()
        .corners(Corners::USUAL)
        .tolerance(1e-9)
        .prepare()
        .unwrap();
    assert_eq!(drop.solve().unwrap().nurbs().points.len(), 25);
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let square = Fit::curve(&square)
        .closed()
        .corners(at(&[0, 1, 2, 3]))
        .prepare()
        .unwrap()
        .solve()
        .unwrap();
    assert_eq!(square.nurbs().points.len(), 13);
}

/// Fits that choose their knots have the fewest control points on each piece: p + 1 on straight edges.
#[test]
fn pieces_have_as_few_control_points_as_they_need() {
    for degree in [1, 2, 3, 5] {
        let fit = Fit::curve(&zigzag()).degree(degree).corners(Corners::USUAL);
        let fit = fit
            .fewest_control_points()
            .tolerance(1e-9)
            .prepare()
            .unwrap();
        let t = fit.parameters().to_vec();
        let curve = fit.solve().unwrap();
        // Six edges; five corners are shared.
        assert_eq!(curve.nurbs().points.len(), 6 * degree + 1, "{degree}");
        assert!(from_zigzag(&curve, &t) < 1e-12);
    }
    // A drop, closed at its only corner; in each turn of its points the same curve.
    let drop: Vec<[f64; 2]> = (0..120)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 120.0)
        .map(|a| [a.cos(), a.sin() * (a / 2.0).sin().powi(3)])
        .collect();
    let counts = [0, 7, 60].map(|turn| {
        let mut points = drop.clone();
        points.rotate_right(turn);
        let fit = Fit::curve(&points).closed().corners(at(&[turn]));
        let fit = fit
            .fewest_control_points()
            .tolerance(1e-4)
            .prepare()
            .unwrap();
        let t = fit.parameters().to_vec();
        let curve = fit.solve().unwrap();
        for (t, point) in t.iter().zip(&points) {
            let off = curve.eval(*t);
            assert!(
                (off[0] - point[0]).hypot(off[1] - point[1]) <= 1e-4,
                "{turn} {t}"
            );
        }
        let net = &curve.nurbs().points;
        let ends = [0, net.len() - 1].map(|i| net.point(i).collect::<Vec<_>>());
        assert_eq!(ends[0], ends[1]);
        assert_eq!(ends[0], points[turn]);
        net.len()
    });
    assert!(counts[0] < 25, "{counts:?}");
    assert!(
        counts.iter().all(|count| count.abs_diff(counts[0]) <= 1),
        "{counts:?}"
    );
}

/// Levels have a level of each piece, numbers of control points that do not exceed what is allowed, and errors of all data.
#[test]
fn levels_of_pieces_continue_together() {
    let wave = |x: f64| (x * 1.3).sin() + if x > 5.0 { 2.0 * (x - 5.0) } else { 0.0 };
    let points: Vec<[f64; 2]> = (0..=200)
        .map(|i| f64::from(i) * 0.05)
        .map(|x| [x, wave(x)])
        .collect();
    let fit = |most: usize| {
        let settings = LeastSquares::automatic(most, most);
        let fit = Fit::curve(&points)
            .corners(at(&[100]))
            .method(Method::LeastSquares(settings));
        fit.tolerance(1e-5).prepare()
    };
    let prepared = fit(usize::MAX).unwrap();
    let (curve, t) = (prepared.solve().unwrap(), prepared.parameters());
    let off = |t: f64, point: &[f64; 2]| {
        let at = curve.eval(t);
        (at[0] - point[0]).hypot(at[1] - point[1])
    };
    let distances: Vec<f64> = t
        .iter()
        .zip(&points)
        .map(|(t, point)| off(*t, point))
        .collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    let rms = (distances.iter().map(|x| x * x).sum::<f64>() / 201.0).sqrt();
    let error = curve.error();
    assert!((error.max - largest).abs() < 1e-14 && (error.rms - rms).abs() < 1e-14);
    assert_eq!(distances[error.at], largest);
    assert!(distances[100] < 1e-15);
    let count = curve.nurbs().points.len();
    assert!(count < 60, "{count}");
    let limited = fit(9).unwrap().solve().unwrap_err();
    assert!(limited.best.nurbs().points.len() <= 9);
    assert_eq!(fit(6).unwrap_err().place, Place::ControlPoints(Axis::U));
}

fn angle_of(i: usize) -> f64 {
    i as f64 * std::f64::consts::TAU / 24.0
}

fn refused(fit: Fit<Curve>) -> Invalid {
    fit.prepare().unwrap_err()
}

#[test]
fn what_has_no_corners_is_named() {
    let fit = || Fit::curve(&zigzag());
    let corner = |index| Place::Corner(Axis::U, index);
    for (indices, place) in [
        (&[0_usize, 4][..], corner(0)),
        (&[4, 23], corner(1)),
        (&[4, 24], corner(1)),
        (&[8, 4], corner(1)),
        (&[4, 4], corner(1)),
    ] {
        assert_eq!(
            refused(fit().corners(at(indices))).place,
            place,
            "{indices:?}"
        );
    }
    for angle in [0.0, 180.0, -1.0, f64::NAN] {
        assert_eq!(
            refused(fit().corners(Corners::Found(angle))).place,
            Place::Corners(Axis::U)
        );
    }
    let corners = || fit().corners(at(&[4]));
    let bernstein = BasisChoice::Polynomial(crate::basis::Polynomial::Bernstein);
    let given = |knots| BasisChoice::BSpline { degree: 3, knots };
    for wrong in [
        corners().basis(bernstein),
        corners().basis(given(Knots::Data)),
        corners().ends(crate::basis::Ends::both(crate::basis::End::Natural)),
        Fit::curve(&[[0.0], [1.0], [0.0]]).corners(Corners::USUAL),
    ] {
        assert_eq!(refused(wrong).place, Place::Corners(Axis::U));
    }
    for count in [2, 25] {
        assert_eq!(
            refused(corners().control_points(count)).place,
            Place::ControlPoints(Axis::U),
            "{count}"
        );
    }
    // Where none are found the curve is as without.
    let line: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i), 0.0]).collect();
    let [with, without] = [true, false].map(|with| {
        let fit = Fit::curve(&line);
        let fit = if with {
            fit.corners(Corners::USUAL)
        } else {
            fit
        };
        fit.prepare().unwrap().solve().unwrap()
    });
    assert_eq!(with, without);
}
