//! The choice of fairness, beside dense matrices and the truth behind noise.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::{Equations, SymmetricBand, entries};
use crate::Fit;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::method::{EndPoints, Fairness, LeastSquares, Method};
use crate::parameters::Parametrization;
use crate::parameters::scattered::{CoordinatePlane, Scattered};
use crate::problem::Problem;
use crate::problem::request::Request;

/// Normal deviates, the same in each run.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of twelve uniform ones.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn truth(s: f64) -> [f64; 2] {
    [
        40.0 * s + 4.0 * (7.0 * s).sin(),
        6.0 * (9.0 * s).sin() + 3.0 * (23.0 * s).cos(),
    ]
}

/// Samples of the truth, and with noise of some size in each coordinate.
fn noisy(count: usize, size: f64, seed: u64) -> [Vec<[f64; 2]>; 2] {
    let mut noise = Noise(seed);
    let exact: Vec<[f64; 2]> = (0..count)
        .map(|i| truth(i as f64 / (count - 1) as f64))
        .collect();
    let with_noise = exact
        .iter()
        .map(|point| point.map(|x| x + size * noise.normal()));
    let with_noise = with_noise.collect();
    [exact, with_noise]
}

fn settings(count: usize, fairness: Fairness, ends: EndPoints) -> LeastSquares {
    LeastSquares {
        fairness: Some(fairness),
        ends,
        ..LeastSquares::new(count, count)
    }
}

/// The rms of the distances of a fit from points at its parameters.
fn rms(problem: Fit<crate::Curve>, from: &[[f64; 2]]) -> f64 {
    let fit = problem.prepare().unwrap();
    let curve = match fit.solve() {
        Ok(curve) => curve,
        Err(error) => error.best,
    };
    let squares = fit.parameters().iter().zip(from).map(|(t, point)| {
        let at = curve.eval(*t);
        (at[0] - point[0]).powi(2) + (at[1] - point[1]).powi(2)
    });
    (squares.sum::<f64>() / from.len() as f64).sqrt()
}

/// For noise of several sizes on several numbers of points nearly as near to the truth as the best fairness there is, on
/// average of five. What is flat about the minimum makes the curve a little smoother than that, more so of many data.
#[test]
fn the_choice_is_near_the_best() {
    for (count, size, most) in [(60, 0.15, 1.05), (150, 1.0, 1.15), (600, 1.0, 1.15)] {
        let ratio = |seed: u64| {
            let [exact, points] = noisy(count, size, seed);
            let fit = |fairness: Fairness| {
                let settings = settings(60.min(count), fairness, EndPoints::Free);
                let fit = Fit::curve(&points).method(Method::LeastSquares(settings));
                // Chord lengths would have noise of their own.
                rms(fit.parameters(Parametrization::Uniform), &exact)
            };
            let value = |k: u32| Fairness {
                value: 10_f64.powf(-12.0 + f64::from(k) / 2.0),
                by_data: false,
                order: 2,
            };
            let best = (0..20).map(|k| fit(value(k))).fold(f64::INFINITY, f64::min);
            fit(Fairness::BY_DATA) / best
        };
        let mean = (1..=5).map(ratio).sum::<f64>() / 5.0;
        assert!(mean <= most, "{count} points, noise {size}: {mean}");
    }
}

/// The banded score is that of dense matrices, with ends free and interpolated, weights, open and closed.
#[test]
fn scores_are_those_of_dense_matrices() {
    let [_, points] = noisy(40, 0.5, 7);
    let weights: Vec<f64> = (0..40).map(|i| f64::from(i % 3)).collect();
    for (closed, ends, weighted) in [
        (false, EndPoints::Free, false),
        (false, EndPoints::Interpolated, false),
        (false, EndPoints::Free, true),
        (true, EndPoints::Free, false),
    ] {
        let settings = LeastSquares {
            data_weights: weighted.then(|| weights.clone().into()),
            ..settings(12, Fairness::BY_DATA, ends)
        };
        let spline = BasisChoice::BSpline {
            degree: 3,
            knots: Knots::Usual,
        };
        let choice = DirectionChoice {
            closed,
            ..DirectionChoice::new(spline, Parametrization::ChordLength)
        };
        let grid = Grid {
            rows: 40,
            columns: 1,
        };
        let request = Request {
            method: Method::LeastSquares(settings.clone()),
            ..Request::new(Points::from_flat(2, &points.concat()), grid, choice, None)
        };
        let problem = Problem::new(request).unwrap();
        let equations = Equations::new(problem.setup(), &settings).unwrap();
        let (n, m) = (40, 12);
        let entries: Vec<Vec<(usize, f64)>> =
            (0..n).map(|i| entries(&equations.matrix, i)).collect();
        let a = DMatrix::from_fn(n, m, |i, j| {
            entries[i]
                .iter()
                .filter(|(k, _)| *k == j)
                .map(|(_, x)| x)
                .sum()
        });
        let omega = |i: usize| if weighted { weights[i] } else { 1.0 };
        let sum: f64 = (0..n).map(omega).sum();
        let scaled = DMatrix::from_fn(n, m, |i, j| a[(i, j)] * omega(i) / sum);
        let dense = |band: &SymmetricBand| {
            DMatrix::from_fn(m, m, |i, j| {
                let (i, j) = (equations.places[i], equations.places[j]);
                let (i, j) = (i.max(j), i.min(j));
                if i - j < band.width {
                    band.at(i, j)
                } else {
                    0.0
                }
            })
        };
        let (data, energy) = (dense(&equations.data), dense(&equations.energy));
        assert!((&data - scaled.transpose() * &a).norm() < 1e-14);
        let p = DMatrix::from_fn(n, 2, |i, c| points[i][c]);
        for fairness in [1e-8, 1e-4, 1.0] {
            let fixed = ends == EndPoints::Interpolated;
            let free: Vec<usize> = if fixed {
                (1..m - 1).collect()
            } else {
                (0..m).collect()
            };
            let whole = (&data + fairness * &energy)
                .select_rows(&free)
                .select_columns(&free);
            let mut x = DMatrix::zeros(m, 2);
            if fixed {
                x.set_row(0, &p.row(0));
                x.set_row(m - 1, &p.row(n - 1));
            }
            let pull = scaled.transpose() * &p - (&data + fairness * &energy) * &x;
            let inverse = whole.try_inverse().unwrap();
            let solved = &inverse * pull.select_rows(&free);
            for (k, &j) in free.iter().enumerate() {
                x.set_row(j, &solved.row(k));
            }
            let left = &a * x - &p;
            let mean: f64 = (0..n)
                .map(|i| omega(i) * left.row(i).norm_squared())
                .sum::<f64>()
                / sum;
            let of_data = data.select_rows(&free).select_columns(&free);
            let trace = (inverse * of_data).trace() + (m - free.len()) as f64;
            let count = (0..n).filter(|&i| omega(i) > 0.0).count() as f64;
            let expected = mean / (1.0 - trace / count).powi(2);
            let score = equations.score(fairness).unwrap();
            assert!(
                (score.value / expected - 1.0).abs() < 1e-9,
                "{closed} {ends:?} {fairness}"
            );
            let largest = (0..n).map(|i| left.row(i).norm()).fold(0.0, f64::max);
            assert!((score.largest / largest - 1.0).abs() < 1e-9);
        }
    }
}

/// With a tolerance the fit is within it, if some fairness is.
#[test]
fn tolerances_are_kept() {
    let [_, points] = noisy(200, 1.0, 7);
    let fit = |tolerance: Option<f64>| {
        let settings = settings(60, Fairness::BY_DATA, EndPoints::Free);
        let fit = Fit::curve(&points).method(Method::LeastSquares(settings));
        match tolerance {
            Some(tolerance) => fit.tolerance(tolerance),
            None => fit,
        }
        .prepare()
        .unwrap()
    };
    let largest = |tolerance: Option<f64>| match fit(tolerance).solve() {
        Ok(curve) => curve.error().max,
        Err(error) => error.best.error().max,
    };
    let usual = largest(None);
    assert!(usual > 2.5, "{usual}");
    let within = largest(Some(0.9 * usual));
    assert!(within <= 0.9 * usual, "{within} of {usual}");
}

/// Heights of a surface with noise at scattered places, and without it.
fn scan(count: usize, size: f64, seed: u64) -> [Vec<[f64; 3]>; 2] {
    let mut noise = Noise(seed);
    let mut exact = Vec::new();
    for _ in 0..count {
        let [x, y] = [noise.uniform(), noise.uniform()];
        exact.push([x, y, 0.3 * (6.0 * x).sin() * (4.0 * y).cos()]);
    }
    let with_noise = exact
        .iter()
        .map(|&[x, y, z]| [x, y, z + size * noise.normal()]);
    let with_noise = with_noise.collect();
    [exact, with_noise]
}

/// The banded score of scattered points is that of dense matrices, with the usual stiffness where a part of the surface
/// has no points.
#[test]
fn scores_of_surfaces_are_those_of_dense_matrices() {
    let [_, all] = scan(300, 0.05, 3);
    let outside = |point: &[f64; 3]| point[0] > 0.7 || point[1] > 0.7;
    let with_hole: Vec<[f64; 3]> = all.iter().copied().filter(outside).collect();
    for (points, has_gaps) in [(all, false), (with_hole, true)] {
        compare_with_dense(&points, has_gaps);
    }
}

fn compare_with_dense(points: &[[f64; 3]], has_gaps: bool) {
    let settings = LeastSquares {
        fairness: Some(Fairness::BY_DATA),
        ends: EndPoints::Free,
        ..LeastSquares::new(7, 6)
    };
    let fit = Fit::scattered(points, Scattered::Coordinates(CoordinatePlane::Xy));
    let fit = fit.method(Method::LeastSquares(settings.clone()));
    let level = fit.prepare().unwrap().levels().next().unwrap();
    let problem = level.problem();
    let equations = Equations::new(problem.setup(), &settings).unwrap();
    let (n, m) = (points.len(), 42);
    let mut a = DMatrix::zeros(n, m);
    for i in 0..n {
        entries(&equations.matrix, i)
            .into_iter()
            .for_each(|(j, x)| a[(i, j)] += x);
    }
    let dense = |band: &SymmetricBand| {
        DMatrix::from_fn(m, m, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            if i - j < band.width {
                band.at(i, j)
            } else {
                0.0
            }
        })
    };
    let of_data = a.transpose() * &a / n as f64;
    assert!((dense(&equations.data) - &of_data).norm() < 1e-14);
    assert_eq!(equations.gaps.is_some(), has_gaps);
    let gaps = equations.gaps.as_ref().map_or(DMatrix::zeros(m, m), dense);
    assert_eq!(gaps.norm() > 0.0, has_gaps);
    for fairness in [1e-6, 1e-3] {
        let whole = &of_data + fairness * dense(&equations.energy) + &gaps;
        let inverse = whole.try_inverse().unwrap();
        let p = DMatrix::from_fn(n, 3, |i, c| points[i][c]);
        let left = &a * (&inverse * (a.transpose() * &p / n as f64)) - &p;
        let trace = (&inverse * &of_data).trace();
        let expected = left.norm_squared() / n as f64 / (1.0 - trace / n as f64).powi(2);
        let score = equations.score(fairness).unwrap();
        assert!((score.value / expected - 1.0).abs() < 1e-7, "{fairness}");
    }
}

/// Nearly as near to the truth as the best fairness there is.
#[test]
fn the_choice_for_a_scan_is_near_the_best() {
    for seed in 1..=3 {
        let [exact, points] = scan(1500, 0.05, seed);
        let off = |fairness: Fairness| {
            let settings = LeastSquares {
                fairness: Some(fairness),
                ends: EndPoints::Free,
                ..LeastSquares::new(15, 14)
            };
            let fit = Fit::scattered(&points, Scattered::Coordinates(CoordinatePlane::Xy));
            let fit = fit
                .method(Method::LeastSquares(settings))
                .prepare()
                .unwrap();
            let surface = match fit.solve() {
                Ok(surface) => surface,
                Err(error) => error.best,
            };
            let level = fit.levels().next().unwrap();
            let t = level
                .problem()
                .directions()
                .map(|it| Arc::clone(&it.parameters));
            let [u, v] = <[Arc<Vec<f64>>; 2]>::try_from(t.collect::<Vec<_>>()).unwrap();
            let squares = exact
                .iter()
                .enumerate()
                .map(|(i, point)| (surface.eval(u[i], v[i])[2] - point[2]).powi(2));
            (squares.sum::<f64>() / exact.len() as f64).sqrt()
        };
        let value = |k: i32| Fairness {
            value: 10_f64.powi(k),
            by_data: false,
            order: 2,
        };
        let best = (-9..0).map(|k| off(value(k))).fold(f64::INFINITY, f64::min);
        let found = off(Fairness::BY_DATA);
        assert!(found <= 1.15 * best, "{seed}: {found} {best}");
    }
}
