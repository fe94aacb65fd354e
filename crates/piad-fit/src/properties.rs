//! Properties of every fit: affine invariance, interpolation in the limit, independence of the order of magnitude.

use std::sync::Arc;

use proptest::prelude::*;

use super::basis::{Polynomial, knots::Knots};
use super::iteration::Iteration;
use super::parameters::Parametrization;
use super::problem::Problem;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::geometry::evaluation::Geometry;
use crate::iteration::system::System;
use crate::problem::request::{Request, Tolerance};
use crate::termination::Outcome;

/// A basis of one direction with which PIA converges quickly.
fn basis() -> impl Strategy<Value = BasisChoice> {
    let knots = prop_oneof![Just(Knots::Data), Just(Knots::Averaged)];
    prop_oneof![
        1 => Just(BasisChoice::Polynomial(Polynomial::Bernstein)),
        4 => (1..=4_usize, knots).prop_map(|(degree, knots)| BasisChoice::BSpline { degree, knots }),
    ]
}

/// An open direction without weights.
fn choice(basis: BasisChoice, parameters: Parametrization) -> DirectionChoice {
    DirectionChoice::new(basis, parameters)
}

/// A direction with any basis and any parameters by rule.
fn direction() -> impl Strategy<Value = DirectionChoice> {
    let parameters = prop_oneof![
        Just(Parametrization::Uniform),
        Just(Parametrization::ChordLength),
        Just(Parametrization::Centripetal),
    ];
    (basis(), parameters).prop_map(|(basis, parameters)| choice(basis, parameters))
}

/// Points near a regular grid, so that parameters are neither equal nor extremely uneven.
fn problem() -> impl Strategy<Value = Request> {
    let grid = prop_oneof![
        (5..40_usize).prop_map(|rows| Grid { rows, columns: 1 }),
        (5..9_usize, 5..9_usize).prop_map(|(rows, columns)| Grid { rows, columns }),
    ];
    (grid, direction(), direction(), 2..=3_usize).prop_flat_map(|(grid, u, v, dimension)| {
        let offsets = prop::collection::vec(-0.4..0.4, grid.count() * dimension);
        offsets.prop_map(move |offsets| {
            let mut points = Points::new(dimension);
            for (index, offset) in offsets.chunks(dimension).enumerate() {
                let base = [
                    (index / grid.columns) as f64,
                    (index % grid.columns) as f64,
                    0.0,
                ];
                let point: Vec<f64> = offset.iter().zip(base).map(|(a, b)| a + b).collect();
                points.push(&point);
            }
            Request {
                tolerance: Some(Tolerance::Relative(1e-9)),
                max_iterations: 300,
                ..Request::new(
                    points,
                    grid,
                    u.clone(),
                    (grid.columns > 1).then(|| v.clone()),
                )
            }
        })
    })
}

/// Level 0.
fn start(request: Request) -> Iteration {
    let problem = Problem::new(request).unwrap();
    Iteration::start(Arc::new(System::new(Arc::new(problem))))
}

/// The images of all points.
fn map(points: &Points, f: impl Fn(&[f64]) -> Vec<f64>) -> Points {
    let mut image = Points::new(points.dimension());
    for i in 0..points.len() {
        image.push(&f(&points.point(i).collect::<Vec<_>>()));
    }
    image
}

/// All coordinates differ by at most the tolerance.
fn assert_close(a: &Points, b: &Points, tolerance: f64) {
    for (a, b) in a.lanes().iter().flatten().zip(b.lanes().iter().flatten()) {
        assert!((a - b).abs() <= tolerance, "{a} {b}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// With the same parameters, fitting commutes with affine maps at every level.
    #[test]
    fn fits_are_affinely_invariant(
        mut request in problem(),
        matrix in prop::array::uniform9(-2.0..2.0),
        shift in prop::array::uniform3(-5.0..5.0),
    ) {
        request.u.parameters = Parametrization::Uniform;
        if let Some(v) = &mut request.v {
            v.parameters = Parametrization::Uniform;
        }
        let affine = |x: &[f64]| -> Vec<f64> {
            (0..x.len())
                .map(|r| shift[r] + x.iter().enumerate().map(|(c, x)| matrix[3 * r + c] * x).sum::<f64>())
                .collect()
        };
        let mut image = request.clone();
        image.points = Arc::new(map(&request.points, affine));
        let (mut original, mut image) = (start(request), start(image));
        for _ in 0..20 {
            let expected = map(original.control_points(), affine);
            // Rounding of coordinates below 200, times the growth of control points.
            assert_close(image.control_points(), &expected, 1e-10);
            original.step();
            image.step();
        }
    }

    /// When PIA stops, the curve passes through the data, to the error that it reports.
    #[test]
    fn the_limit_interpolates(request in problem()) {
        let mut iteration = start(request.clone());
        while iteration.outcome().is_none() {
            iteration.step();
        }
        let problem = Problem::new(request).unwrap();
        let geometry = Geometry::new(&problem, iteration.control_points());
        let v = problem.v().map_or(&[][..], |v| &v.parameters);
        let curve = geometry.evaluate(&problem.u().parameters, v);
        let error = iteration.level().error;
        // Two ways to sum up to 81 products of coordinates below 40.
        let rounding = 1e-12;
        let distance = |i: usize| {
            let square: f64 = curve.point(i).zip(problem.data().point(i)).map(|(a, b)| (a - b).powi(2)).sum();
            square.sqrt()
        };
        let largest = (0..curve.len()).map(distance).fold(0.0, f64::max);
        assert!((largest - error.max).abs() <= rounding);
        assert!((distance(error.at) - error.max).abs() <= rounding);
        if iteration.outcome() == Some(Outcome::Converged) {
            assert!(error.max <= problem.tolerance());
        }
    }

    /// Every place of the complete net belongs to the control point that it repeats or copies, and to no
    /// other.
    #[test]
    fn each_place_of_the_net_occurs_once(mut request in problem(), closed_u: bool, closed_v: bool) {
        request.u.closed = closed_u;
        if let Some(v) = &mut request.v {
            v.closed = closed_v;
        }
        // Not all bases can be closed.
        let Ok(problem) = Problem::new(request) else { return Ok(()) };
        let geometry = Geometry::new(&problem, problem.data());
        let mut found = 0;
        for index in 0..problem.control_grid().count() {
            for (row, column) in geometry.occurrences(index) {
                let equal = geometry.equal_to(row, column);
                prop_assert!(equal.is_none_or(|equal| equal == index));
                found += 1;
            }
        }
        prop_assert_eq!(found, geometry.rows() * geometry.columns().unwrap_or(1));
    }

    /// Scaling the data scales everything.
    #[test]
    fn every_order_of_magnitude_is_alike(request in problem(), exponent in -290..290) {
        let scale = 10f64.powi(exponent);
        let mut scaled = request.clone();
        let scale_all = |x: &[f64]| x.iter().map(|x| x * scale).collect();
        scaled.points = Arc::new(map(&request.points, scale_all));
        let (mut original, mut scaled) = (start(request), start(scaled));
        for _ in 0..10 {
            let expected = map(original.control_points(), |x| x.iter().map(|x| x * scale).collect());
            assert_close(scaled.control_points(), &expected, 1e-10 * scale);
            let (a, b) = (original.level().error, scaled.level().error);
            for (a, b) in [(a.max, b.max), (a.rms, b.rms), (a.sum, b.sum)] {
                assert!((a - b / scale).abs() < 1e-10, "{a} {}", b / scale);
            }
            original.step();
            scaled.step();
        }
    }
}

/// With well-conditioned bases global PIA always converges: rate 2/3 for cubics (LBW05, Thm 2.1).
#[test]
fn cubic_splines_converge_within_the_expected_iterations() {
    for n in [10, 100, 1000] {
        let mut points = Points::new(2);
        for i in 0..n {
            let x = f64::from(i);
            points.push(&[x, (x * 0.7).sin()]);
        }
        let basis = BasisChoice::BSpline {
            degree: 3,
            knots: Knots::Data,
        };
        let direction = choice(basis, Parametrization::Uniform);
        let mut iteration = start(Request {
            tolerance: Some(Tolerance::Absolute(1e-9)),
            max_iterations: 1000,
            ..Request::new(
                points,
                Grid {
                    rows: n as usize,
                    columns: 1,
                },
                direction,
                None,
            )
        });
        let mut rates = Vec::new();
        while iteration.outcome().is_none() {
            let before = iteration.level().error.rms;
            rates.push(iteration.step().error.rms / before);
        }
        assert_eq!(iteration.outcome(), Some(Outcome::Converged));
        assert!(rates.iter().all(|&rate| rate < 2.0 / 3.0 + 1e-6));
        assert!(rates.len() < 50);
    }
}
