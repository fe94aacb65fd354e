//! Robust fits, beside fits of the points that they do not leave out.

use std::f64::consts::TAU;

use crate::basis::Corners;
use crate::invalid::{Place, Setting};
use crate::method::{At, Constraint, EndPoints, LeastSquares, Method, Variant, Wanted};
use crate::parameters::Scattered;
use crate::{Curve, Fit, Prepared};

/// Points of an oval, of which some are moved.
fn oval(moved: &[usize]) -> Vec<[f64; 2]> {
    let at = |i: usize| {
        let angle = TAU * i as f64 / 90.0;
        let out = if moved.contains(&i) { 1.3 } else { 1.0 };
        [out * 3.0 * angle.cos(), out * 2.0 * angle.sin()]
    };
    (0..90).map(at).collect()
}

fn without<T: Copy>(points: &[T], some: &[usize]) -> Vec<T> {
    let points = points.iter().enumerate();
    let others = points.filter(|(i, _)| !some.contains(i));
    others.map(|(_, it)| *it).collect()
}

fn outliers(prepared: &Prepared<Curve>) -> Vec<usize> {
    let level = prepared.levels().next().unwrap();
    level.problem().outliers().to_vec()
}

/// The largest distance between two curves at the same parameters.
fn apart(one: &Curve, other: &Curve) -> f64 {
    let ((low, high), others) = (one.domain(), other.domain());
    assert!((low - others.0).abs() < 1e-12 && (high - others.1).abs() < 1e-12);
    let places = (0..=500).map(|k| low + (high - low) * f64::from(k) / 500.0);
    let distances = places.map(|t| {
        let pairs = one.eval(t).into_iter().zip(other.eval(t));
        pairs.fold(0.0, |sum: f64, (a, b)| sum.hypot(a - b))
    });
    distances.fold(0.0, f64::max)
}

/// With a given number of control points and with as few as a tolerance needs, open and closed, with corners, and where the
/// first and the last point are outliers.
#[test]
fn the_others_are_fitted_as_if_they_were_alone() {
    let direct = |fit: Fit<Curve>| {
        fit.method(Method::LeastSquares(LeastSquares {
            variant: Variant::Direct,
            ..LeastSquares::new(14, 14)
        }))
    };
    let auto = |fit: Fit<Curve>| fit.tolerance(0.01).fewest_control_points();
    let moved: &[&[usize]] = &[&[7, 40, 41, 63], &[0, 33, 89]];
    for moved in moved {
        let (all, others) = (oval(moved), without(&oval(moved), moved));
        for (closed, corners) in [(false, false), (true, false), (true, true), (false, true)] {
            let shaped = |fit: Fit<Curve>, corner: usize| {
                let fit = if closed { fit.closed() } else { fit };
                match corners {
                    true => fit.corners(Corners::At([corner].into())),
                    false => fit,
                }
            };
            let before = moved.iter().filter(|it| **it < 50).count();
            for (of, name) in [
                (&direct as &dyn Fn(Fit<Curve>) -> Fit<Curve>, "direct"),
                (&auto, "auto"),
            ] {
                let what = format!("{name} {moved:?} {closed} {corners}");
                let robust = of(shaped(Fit::curve(&all), 50)).robust().prepare().unwrap();
                assert_eq!(outliers(&robust), *moved, "{what}");
                let alone = of(shaped(Fit::curve(&others), 50 - before))
                    .prepare()
                    .unwrap();
                let (robust, alone) = (robust.solve().unwrap(), alone.solve().unwrap());
                assert!(
                    apart(&robust, &alone) < 1e-12,
                    "{what}: {:e}",
                    apart(&robust, &alone)
                );
                let (error, expected) = (robust.error(), alone.error());
                assert!((error.max - expected.max).abs() < 1e-12, "{what}");
                assert!(!moved.contains(&error.at), "{what}: {}", error.at);
            }
        }
    }
}

/// A point with a constraint, and a given corner, are not outliers.
#[test]
fn points_that_are_named_are_no_outliers() {
    let all = oval(&[20, 60]);
    let fit = |settings: LeastSquares| {
        let fit = Fit::curve(&all).method(Method::LeastSquares(settings));
        outliers(&fit.robust().prepare().unwrap())
    };
    assert_eq!(fit(LeastSquares::new(20, 20)), [20, 60]);
    let through = Constraint {
        at: At::Index(20),
        wanted: Wanted::DataPoint,
    };
    let settings = LeastSquares {
        constraints: [through].into(),
        ..LeastSquares::new(20, 20)
    };
    assert_eq!(fit(settings), [60]);
    let fit = Fit::curve(&all)
        .control_points(20)
        .corners(Corners::At([60].into()));
    assert_eq!(outliers(&fit.robust().prepare().unwrap()), [20]);
}

/// Data weights, free ends and a tolerance: points within it are no outliers.
#[test]
fn settings_are_those_of_all_points() {
    let moved = [7, 40];
    let all = oval(&moved);
    let settings = |count: usize| LeastSquares {
        ends: EndPoints::Free,
        variant: Variant::Direct,
        data_weights: Some((0..count).map(|i| 1.0 + (i % 3) as f64).collect()),
        ..LeastSquares::new(11, 11)
    };
    let mut alone = settings(90);
    let weights: Vec<f64> = alone
        .data_weights
        .iter()
        .flat_map(|it| it.to_vec())
        .collect();
    alone.data_weights = Some(without(&weights, &moved).into());
    let of = |points: &[[f64; 2]], settings: LeastSquares| {
        Fit::curve(points).method(Method::LeastSquares(settings))
    };
    let robust = of(&all, settings(90))
        .robust()
        .prepare()
        .unwrap()
        .solve()
        .unwrap();
    let alone = of(&without(&all, &moved), alone)
        .prepare()
        .unwrap()
        .solve()
        .unwrap();
    assert!(apart(&robust, &alone) < 1e-12);
    let far = Fit::curve(&all).control_points(11).robust().tolerance(2.0);
    assert_eq!(outliers(&far.prepare().unwrap()), [0; 0]);
}

/// Scattered points: the plane of the parameters is that of the others.
#[test]
fn scattered_points_are_fitted_without_outliers() {
    let mut state = 5_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state >> 40
    };
    let moved: Vec<usize> = (0..600).filter(|_| random() % 17 == 0).collect();
    let at = |i: usize| {
        let [x, y] = [0.754_877_67, 0.569_840_29].map(|step| (i as f64 * step).fract());
        let up = if moved.contains(&i) {
            40.5 - (i % 97) as f64
        } else {
            0.0
        };
        [x, y, 0.2 * (4.0 * x).sin() * (3.0 * y).cos() + up]
    };
    let all: Vec<[f64; 3]> = (0..600).map(at).collect();
    let others = without(&all, &moved);
    for count in [None, Some(7)] {
        let fit = |points: &[[f64; 3]]| {
            let fit = Fit::scattered(points, Scattered::Plane).tolerance(1e-2);
            match count {
                Some(count) => fit.control_points(count, count),
                None => fit,
            }
        };
        let robust = fit(&all).robust().prepare().unwrap();
        let level = robust.levels().next().unwrap();
        assert_eq!(level.problem().outliers(), moved);
        let (robust, alone) = (
            robust.solve().unwrap(),
            fit(&others).prepare().unwrap().solve().unwrap(),
        );
        let (low, high) = robust.domain()[0];
        for k in 0..=20 {
            let u = low + (high - low) * f64::from(k) / 20.0;
            let pairs = robust.eval(u, 0.1).into_iter().zip(alone.eval(u, 0.1));
            let off = pairs.fold(0.0, |sum: f64, (a, b)| sum.hypot(a - b));
            assert!(off < 1e-9, "{count:?}: {off:e}");
        }
    }
}

#[test]
fn fits_that_cannot_be_robust_are_named() {
    let place = |fit: Fit<Curve>| fit.prepare().unwrap_err().place;
    let robust = |points: &[[f64; 2]]| Fit::curve(points).control_points(4).robust();
    let setting = Place::Setting(Setting::Robust);
    assert_eq!(place(robust(&oval(&[])[..7])), setting);
    assert_eq!(place(robust(&oval(&[])).weights(vec![1.0; 90])), setting);
    assert_eq!(place(Fit::curve(&oval(&[])).polyline().robust()), setting);
    let grid = vec![vec![[0.0, 0.0, 1.0]; 9]; 9];
    let grid = Fit::surface(&grid).control_points(4, 4).robust();
    assert_eq!(grid.prepare().unwrap_err().place, setting);
    // More control points than are left.
    let few = Fit::curve(&oval(&[3, 30])[..40])
        .control_points(39)
        .robust();
    assert_eq!(place(few), Place::ControlPoints(crate::invalid::Axis::U));
}
