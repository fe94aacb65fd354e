//! Levels of the extended method against those of a dense QR decomposition, and where they end.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::*;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::end_conditions::{End, Ends};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::iteration::Iteration;
use crate::iteration::system::System;
use crate::method::Method;
use crate::parameters::Parametrization;
use crate::problem::Problem;
use crate::problem::request::{Request, Tolerance};

/// Uneven points around a closed curve, which an open one goes through once.
fn request(count: usize, degree: usize, closed: bool, tolerance: f64) -> Request {
    let mut points = Points::new(2);
    for i in 0..count {
        let t = std::f64::consts::TAU * (i as f64 + 0.2 * (3.0 * i as f64).sin()) / count as f64;
        points.push(&[t.cos() + 0.3 * (2.0 * t).sin(), 2.0 * t.sin()]);
    }
    let knots = Knots::Data;
    Request {
        method: Method::Extended(Extended::default()),
        tolerance: Some(Tolerance::Relative(tolerance)),
        max_iterations: 10_000,
        ..Request::new(
            points,
            Grid {
                rows: count,
                columns: 1,
            },
            DirectionChoice {
                closed,
                ends: (!closed).then(|| Ends::both(End::Repeated)),
                ..DirectionChoice::new(
                    BasisChoice::BSpline { degree, knots },
                    Parametrization::ChordLength,
                )
            },
            None,
        )
    }
}

/// The curve at level 0, with its collocation matrix.
fn start(request: Request) -> (Iteration, DMatrix<f64>) {
    let problem = Problem::new(request).unwrap();
    let system = Arc::new(System::new(Arc::new(problem)));
    let matrix = system.collocation().tensor().unwrap().u.to_dense();
    (Iteration::start(system), matrix)
}

/// Points as the rows of a matrix.
fn matrix(points: &Points) -> DMatrix<f64> {
    let lanes = points.lanes();
    DMatrix::from_fn(points.len(), points.dimension(), |i, c| lanes[c][i])
}

/// Level by level `X + H Qᵀ (P − B X)` of the thin QR decomposition with a positive diagonal, as long
/// as the rounding of larger levels before has not spoilt both.
#[test]
fn levels_are_those_of_the_thin_decomposition() {
    for closed in [false, true] {
        for (degree, count) in [(2, 9), (3, 4), (3, 30), (4, 11), (5, 6), (5, 30), (7, 16)] {
            if closed && count <= degree {
                continue;
            }
            let (mut iteration, b) = start(request(count, degree, closed, 0.0));
            let data = matrix(iteration.system().problem().data());
            let qr = b.clone().qr();
            let (mut q, mut r) = (qr.q(), qr.r());
            for i in (0..count).filter(|&i| r[(i, i)] < 0.0).collect::<Vec<_>>() {
                q.column_mut(i).neg_mut();
                r.row_mut(i).neg_mut();
            }
            let mut u = q.transpose();
            (0..count).for_each(|i| u.row_mut(i).unscale_mut(r[(i, i)]));
            let mut x = &u * &data;
            let mut largest = x.amax();
            for level in 0..count {
                let found = matrix(iteration.control_points());
                largest = x.amax().max(largest);
                let wrong = (&found - &x).amax();
                let allowed = (1e-10 * x.amax()).max(1e-13 * largest);
                let place = format!("degree {degree}, {count} points, level {level}");
                assert!(wrong < allowed, "{place}: {wrong} of {}", x.amax());
                x += &u * (&data - &b * &x);
                iteration.step();
            }
        }
    }
}

/// The largest error of all levels, and that of the level at which the fit is exact.
fn run(count: usize, degree: usize, closed: bool) -> (f64, f64) {
    let (mut iteration, _) = start(request(count, degree, closed, 0.0));
    let mut largest = iteration.level().error.max;
    for _ in 1..count {
        largest = largest.max(iteration.step().error.max);
    }
    (largest, iteration.level().error.max)
}

/// Exact to rounding after as many levels as the highest index, however many points there are:
/// errors between do not grow with their number for closed curves up to degree 4, and open ones with
/// knots at the data up to degree 3.
#[test]
fn low_degrees_are_exact_after_n_levels() {
    for count in [30, 100, 300, 1000] {
        let closed = (2..=4).map(|degree| (degree, true));
        for (degree, closed) in closed.chain([(1, false), (2, false), (3, false)]) {
            let (largest, last) = run(count, degree, closed);
            let place = format!("degree {degree}, {count} points, closed: {closed}");
            assert!(largest < 10.0, "{place}: {largest}");
            assert!(last < 1e-13, "{place}: {last}");
        }
    }
}

/// Of higher degrees errors between grow exponentially, and what is left is their rounding.
#[test]
fn high_degrees_leave_the_rounding_of_large_errors() {
    for (closed, degree, count) in [(false, 4, 30), (false, 5, 30), (true, 5, 30), (true, 6, 30)] {
        let (largest, last) = run(count, degree, closed);
        let place = format!("degree {degree}, {count} points, closed: {closed}");
        assert!(largest > 100.0, "{place}: {largest}");
        assert!(last < 1e-12 * largest, "{place}: {last}");
    }
}
