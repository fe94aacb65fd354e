//! Data of a spline with few knots need that number; smooth data do not need more for a larger tolerance.

use super::*;
use crate::knot_selection::values::Values;

/// Points of a plane cubic with these knots between its ends, at their parameters.
fn of_spline(count: usize, knots: &[f64], seed: f64) -> (Points, Vec<f64>) {
    let breaks = [&[0.0], knots, &[1.0]].concat();
    let line = Breaks::new(3, false, breaks).unwrap();
    let t: Vec<f64> = (0..count).map(|i| i as f64 / (count - 1) as f64).collect();
    let numbers = |seed: f64| {
        let count = line.control_points();
        (0..count).map(move |i| (seed * i as f64).sin() + 0.3 * i as f64)
    };
    let control_points =
        Points::from_lanes([seed, seed + 1.4].map(|seed| numbers(seed).collect::<Vec<f64>>()));
    let mut points = Points::zeros(2, count);
    Values::new(&line, &Arc::new(t.clone())).apply(control_points.lanes(), points.lanes_mut());
    (points, t)
}

/// The true number of control points, or one more.
#[test]
fn few_knots_are_found() {
    let five = [0.13, 0.31, 0.52, 0.58, 0.83];
    let ten = [0.08, 0.13, 0.21, 0.31, 0.4, 0.52, 0.58, 0.71, 0.83, 0.95];
    for (knots, seed) in [(&five[..], 3.7), (&five, 5.3), (&ten, 3.7), (&ten, 2.9)] {
        let (points, t) = of_spline(400, knots, seed);
        for tolerance in [1e-3, 1e-5, 1e-7] {
            let (levels, outcome) = levels(&points, t.clone(), cubic(tolerance));
            assert_eq!(outcome, Some(Outcome::Converged));
            valid(&points, &levels);
            let count = levels.last().unwrap().count();
            assert!(
                count <= knots.len() + 5,
                "{tolerance:e}: {count} for {}",
                knots.len() + 4
            );
        }
    }
}

/// Numbers that look like random ones, from 0 to 1.
fn uniform(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

/// Points of a sum of waves, some with a kink or a step.
fn random(seed: &mut u64, kind: usize) -> Points {
    let count = 40 + (uniform(seed) * 400.0) as usize;
    let mut wave = || {
        [
            uniform(seed),
            1.0 + 12.0 * uniform(seed),
            6.3 * uniform(seed),
        ]
    };
    let waves: Vec<[f64; 3]> = (0..4).map(|_| wave()).collect();
    let bend = uniform(seed);
    sampled(count, 0.0, 1.0, |x| {
        let smooth = |[height, f, phase]: &[f64; 3]| height / f * (f * x + phase).sin();
        let smooth: f64 = waves.iter().map(smooth).sum();
        let rough = match kind {
            0 => 0.0,
            1 => 0.3 * (x - bend).abs(),
            _ => 0.2 * (40.0 * (x - bend)).tanh(),
        };
        [x, smooth + rough]
    })
}

/// Ten tolerances each.
#[test]
fn a_larger_tolerance_never_takes_more_control_points() {
    let mut seed = 7;
    for kind in 0..30 {
        let points = random(&mut seed, kind % 3);
        let counts = (0..10).map(|k| {
            let tolerance = 1e-6 * 10_f64.powf(0.4 * f64::from(k));
            let (levels, _) = levels(&points, chord(&points), cubic(tolerance));
            levels.last().unwrap().count()
        });
        let counts: Vec<usize> = counts.collect();
        assert!(counts.is_sorted_by(|a, b| a >= b), "{kind}: {counts:?}");
    }
}

/// `splprep` of scipy 1.17.1 takes 378 control points, the best of ten smoothing factors.
#[test]
fn a_chirp_takes_fewer_control_points_than_with_scipy() {
    let points = sampled(1500, 0.0, 1.0, |x| [x, 0.2 * (60.0 * x * x).sin()]);
    let (levels, outcome) = levels(&points, chord(&points), cubic(1e-5));
    assert_eq!(outcome, Some(Outcome::Converged));
    let count = levels.last().unwrap().count();
    assert!(count <= 340, "{count}");
}
