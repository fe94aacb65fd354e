//! Every sweep must match the plain loop: control points and errors to the last bit.

use std::sync::Arc;

use proptest::prelude::*;

use super::{LEVELS, Plan, Sweep};
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::aligned::Lane;
use crate::data::blocks::BLOCK;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::iteration::system::System;
use crate::iteration::{Iteration, Level};
use crate::method::{Method, Weighted};
use crate::parameters::Parametrization;
use crate::problem::Problem;
use crate::problem::request::{Request, Tolerance};

/// B-splines of any degree up to 8, open with both kinds of knots or closed.
fn direction() -> impl Strategy<Value = DirectionChoice> {
    let knots = prop_oneof![Just(Knots::Data), Just(Knots::Averaged)];
    let parameters = prop_oneof![
        Just(Parametrization::Uniform),
        Just(Parametrization::ChordLength),
        Just(Parametrization::Centripetal),
    ];
    (1..=8_usize, knots, parameters, any::<bool>()).prop_map(
        |(degree, knots, parameters, closed)| DirectionChoice {
            closed,
            ..DirectionChoice::new(
                BasisChoice::BSpline {
                    degree,
                    knots: if closed { Knots::Data } else { knots },
                },
                parameters,
            )
        },
    )
}

/// All methods that can be swept.
fn method() -> impl Strategy<Value = Method> {
    prop_oneof![
        Just(Method::Global),
        Just(Method::Chebyshev),
        Just(Method::Direct),
        Just(Method::Transpose),
        Just(Method::Weighted(Weighted { omega: None })),
        (0.1..1.9).prop_map(|omega| Method::Weighted(Weighted { omega: Some(omega) })),
    ]
}

/// Curves, small surfaces, and surfaces with lines that are longer or shorter than a block.
fn grid() -> impl Strategy<Value = Grid> {
    prop_oneof![
        (2..4000_usize).prop_map(|rows| Grid { rows, columns: 1 }),
        (2..40_usize, 2..40_usize).prop_map(|(rows, columns)| Grid { rows, columns }),
        (2..8_usize, 200..2400_usize).prop_map(|(rows, columns)| Grid { rows, columns }),
        (200..600_usize, 2..8_usize).prop_map(|(rows, columns)| Grid { rows, columns }),
    ]
}

prop_compose! {
    fn request()(
        (grid, u, v, method) in (grid(), direction(), direction(), method()),
        dimension in 1..=3_usize,
        unevenness in 0.0..0.9_f64,
        seed in 0.0..1000.0_f64,
        exponent in -3..5_i32,
    ) -> Request {
        let noise = |i: usize, c: usize| (seed + 12.9898 * i as f64 + 78.233 * c as f64).sin() * 43_758.545_3 % 1.0;
        let mut points = Points::new(dimension);
        for i in 0..grid.count() {
            let (row, column) = ((i / grid.columns) as f64, (i % grid.columns) as f64);
            let base = if dimension == 1 { [row + column, 0.0, 0.0] } else { [row, column, 0.0] };
            let point: Vec<f64> = (0..dimension).map(|c| base[c] + unevenness * noise(i, c)).collect();
            points.push(&point);
        }
        Request { method, tolerance: Some(Tolerance::Relative(10f64.powi(-exponent))), max_iterations: 23, ..Request::new(points, grid, u, (grid.columns > 1).then_some(v)) }
    }
}

/// The system of a request, if it is valid.
fn system(request: Request) -> Option<Arc<System>> {
    // Not all grids are large enough for all degrees, and one coordinate can repeat itself.
    let problem = Problem::new(request).ok()?;
    Some(Arc::new(System::new(Arc::new(problem))))
}

/// Each lane's bits.
fn bits(points: &Points) -> Vec<Vec<u64>> {
    let bits = |lane: &Lane| lane.iter().map(|x| x.to_bits()).collect();
    points.lanes().iter().map(bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Single steps, with any division of the work.
    #[test]
    fn steps_are_those_of_the_plain_loop(request in request(), parts in 1..5_usize) {
        let Some(system) = system(request) else { return Ok(()) };
        let plan = Plan { parts, levels: 1, tile: BLOCK };
        let started = Sweep::with_plan(&system, system.start(), plan);
        let mut sweep = Iteration::with_sweep(Arc::clone(&system), started.unwrap());
        let mut plain = Iteration::start_plain(system);
        for _ in 0..5 {
            prop_assert_eq!(sweep.level(), plain.level());
            prop_assert_eq!(bits(sweep.control_points()), bits(plain.control_points()));
            prop_assert_eq!(sweep.outcome(), plain.outcome());
            sweep.step();
            plain.step();
        }
    }

    /// Several steps at once, to wherever the fit ends.
    #[test]
    fn levels_at_once_are_those_of_single_steps(
        request in request(),
        parts in 1..5_usize,
        levels in 2..=LEVELS,
        tiles in 1..3_usize,
        counts in prop::collection::vec(1..20_usize, 1..6),
    ) {
        let Some(system) = system(request) else { return Ok(()) };
        let is_curve = system.problem().v().is_none();
        let plan = Plan { parts, levels: if is_curve { levels } else { 1 }, tile: BLOCK * tiles };
        let started = Sweep::with_plan(&system, system.start(), plan);
        let mut sweep = Iteration::with_sweep(Arc::clone(&system), started.unwrap());
        let mut plain = Iteration::start_plain(system);
        for count in counts {
            let mut seen: Vec<Level> = Vec::new();
            let mut expected = Vec::new();
            sweep.steps(count, &mut |level| seen.push(level));
            plain.steps(count, &mut |level| expected.push(level));
            prop_assert_eq!(&seen, &expected);
            prop_assert_eq!(bits(sweep.control_points()), bits(plain.control_points()));
            prop_assert_eq!(sweep.outcome(), plain.outcome());
            if sweep.outcome().is_some() {
                break;
            }
        }
    }
}
