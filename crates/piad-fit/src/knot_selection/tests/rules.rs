//! Guarantees, for usual and unusual data.

use super::*;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::insertion::refine;
use crate::knot_selection::values::Values;

/// The same fit twice, to the last bit.
#[test]
fn levels_are_pure_functions_of_the_data() {
    let points = profile();
    let fit = || levels(&points, chord(&points), cubic(1e-4)).0;
    for (a, b) in fit().iter().zip(fit()) {
        assert_eq!(a.lines, b.lines);
        assert_eq!(a.control_points, b.control_points);
        assert_eq!(a.distances.each, b.distances.each);
    }
}

/// And by any number of threads, where they share the data.
#[test]
fn levels_do_not_depend_on_the_number_of_threads() {
    let points = rose(40_000);
    let fit = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let fit = || levels(&points, chord(&points), cubic(1e-2)).0;
        pool.build().unwrap().install(fit)
    };
    let (one, three) = (fit(1), fit(3));
    assert_eq!(one.len(), three.len());
    for (a, b) in one.iter().zip(three) {
        assert_eq!(a.control_points, b.control_points);
        assert_eq!(a.distances.each, b.distances.each);
    }
}

/// Level by level the reversed curve.
#[test]
fn reversed_data_have_the_reversed_curve() {
    for (points, tolerance) in [(profile(), 1e-4), (rose(1501), 1e-3), (helix(), 1e-3)] {
        let t = chord(&points);
        let total = t[t.len() - 1];
        let lanes = points.lanes().iter();
        let reversed =
            Points::from_lanes(lanes.map(|x| x.iter().rev().copied().collect::<Vec<_>>()));
        let back: Vec<f64> = t.iter().rev().map(|t| total - t).collect();
        let (forth, _) = levels(&points, t, cubic(tolerance));
        let (back, _) = levels(&reversed, back, cubic(tolerance));
        assert_eq!(forth.len(), back.len());
        let (forth, back) = (forth.last().unwrap(), back.last().unwrap());
        let count = forth.count();
        assert_eq!(count, back.count());
        for j in 0..count {
            let a: Vec<f64> = forth.control_points.point(j).collect();
            let b: Vec<f64> = back.control_points.point(count - 1 - j).collect();
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-7, "{tolerance:e}, {j}: {a} {b}");
            }
        }
    }
}

/// Values of the same curve at many parameters, open and closed, of several degrees.
#[test]
fn insertion_does_not_change_the_curve() {
    let t: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0 * 6.9).collect();
    let t = Arc::new(t);
    for closed in [false, true] {
        for degree in 1..=6 {
            let breaks = vec![0.0, 0.4, 1.0, 1.1, 2.5, 3.0, 4.0, 5.5, 6.0, 7.0];
            let mut finer = vec![0.2, 0.7, 1.05, 2.0, 2.1, 6.99];
            finer.extend(&breaks);
            finer.sort_by(f64::total_cmp);
            let coarse = Breaks::new(degree, closed, breaks).unwrap();
            let fine = Breaks::new(degree, closed, finer).unwrap();
            let x: Vec<f64> = (0..coarse.control_points())
                .map(|j| (j as f64 * 1.7).sin() * 3.0)
                .collect();
            let points = Points::from_lanes([x.clone()]);
            let refined = refine(&coarse, &fine, &points);
            assert_eq!(refined.len(), fine.control_points());
            let (mut before, mut after) = (vec![0.0; t.len()], vec![0.0; t.len()]);
            Values::new(&coarse, &t).apply(&[&x[..]], &mut [&mut before[..]]);
            Values::new(&fine, &t).apply(refined.lanes(), &mut [&mut after[..]]);
            for (a, b) in before.iter().zip(&after) {
                assert!((a - b).abs() < 1e-13, "degree {degree}, closed {closed}");
            }
        }
    }
}

/// Degrees from lines to quintics: the higher, the fewer for a smooth curve.
#[test]
fn every_degree() {
    let points = helix();
    let mut counts = Vec::new();
    for degree in 1..=6 {
        let settings = Settings {
            degrees: [degree],
            ..cubic(1e-3)
        };
        let (levels, outcome) = levels(&points, chord(&points), settings);
        assert_eq!(outcome, Some(Outcome::Converged), "degree {degree}");
        valid(&points, &levels);
        counts.push(levels.last().unwrap().count());
    }
    assert!(
        counts.windows(2).take(3).all(|pair| pair[1] < pair[0]),
        "{counts:?}"
    );
}

/// A closed curve needs no more than one that is cut open.
#[test]
fn closed_curves() {
    let open = rose(1501);
    let t = chord(&open);
    let count = open.len() - 1;
    let lanes = open.lanes().iter();
    let points = Points::from_lanes(lanes.map(|x| x[..count].to_vec()));
    for (tolerance, most) in [(1e-2, 28), (1e-4, 61)] {
        let settings = Settings {
            periods: [Some(t[count])],
            ..cubic(tolerance)
        };
        let (levels, outcome) = levels(&points, t[..count].to_vec(), settings);
        assert_eq!(outcome, Some(Outcome::Converged));
        valid(&points, &levels);
        let found = levels.last().unwrap().count();
        assert!(found <= most, "{tolerance:e}: {found}");
    }
}

/// As many data as a polynomial has coefficients, and fewer.
#[test]
fn a_few_points() {
    for count in [2, 3, 4, 5, 6] {
        let points = sampled(count, 0.0, 2.0, |x| [x, x.sin(), x * x]);
        let (levels, outcome) = levels(&points, chord(&points), cubic(1e-9));
        assert_eq!(outcome, Some(Outcome::Converged), "{count}");
        let last = levels.last().unwrap();
        assert!(last.distances.max <= 1e-9);
        assert_eq!(last.count(), count.max(4));
        valid(&points, &levels);
    }
}

/// No curve is at distance zero: one control point for each datum, and distances of rounding.
#[test]
fn nothing_is_within_a_tolerance_of_zero() {
    let points = sampled(60, 0.0, 5.0, |x| [x.cos(), (2.0 * x).sin()]);
    let (levels, outcome) = levels(&points, chord(&points), cubic(0.0));
    assert_eq!(outcome, Some(Outcome::Minimum));
    let last = levels.last().unwrap();
    assert!(last.distances.max < 1e-13, "{:e}", last.distances.max);
    valid(&points, &levels);
}

/// With too few control points the nearest curve that was found.
#[test]
fn fewer_control_points_than_needed() {
    let points = rose(1501);
    let settings = Settings {
        max_control_points: [30],
        ..cubic(1e-3)
    };
    let (levels, outcome) = levels(&points, chord(&points), settings);
    assert_eq!(outcome, Some(Outcome::Exhausted));
    let last = levels.last().unwrap();
    assert!(levels.iter().all(|it| it.count() <= 30));
    assert!(last.distances.max < 6e-3, "{:e}", last.distances.max);
    valid(&points, &levels);
}

/// Noise within the tolerance takes no control points, noise above it takes many.
#[test]
fn noise() {
    let noise = |x: f64| (1e4 * (x * 12.9898).sin() * 43758.5453).fract();
    let curve = |amplitude: f64| sampled(1000, 0.0, 6.0, |x| [x, x.sin() + amplitude * noise(x)]);
    let t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.006).collect();
    let clean = levels(&curve(0.0), t.clone(), cubic(1e-3));
    let below = levels(&curve(8e-4), t.clone(), cubic(1e-3));
    let above = levels(&curve(2e-3), t, cubic(1e-3));
    let count = |fit: &(Vec<Arc<Level<1>>>, _)| fit.0.last().unwrap().count();
    assert!(
        count(&below) <= 2 * count(&clean),
        "{} {}",
        count(&below),
        count(&clean)
    );
    assert_eq!(above.1, Some(Outcome::Converged));
    assert!(count(&above) <= 1000);
}

/// Points that are equal, at uniform parameters, and a corner with a vertical side.
#[test]
fn repeated_points_and_corners() {
    let stairs = sampled(300, 0.0, 3.0, |x| {
        [x.min(1.0) + (x - 2.0).max(0.0), (x - 1.0).clamp(0.0, 1.0)]
    });
    let stands = sampled(300, 0.0, 3.0, |x| [x.min(1.0) + (x - 2.0).max(0.0), 0.5]);
    let t: Vec<f64> = (0..300).map(f64::from).collect();
    for (points, most) in [(stairs, 40), (stands, 40)] {
        let (levels, outcome) = levels(&points, t.clone(), cubic(1e-4));
        assert_eq!(outcome, Some(Outcome::Converged));
        valid(&points, &levels);
        let found = levels.last().unwrap().count();
        assert!(found <= most, "{found}");
    }
    let point = sampled(50, 0.0, 1.0, |_| [3.0, 4.0]);
    let t = (0..50).map(f64::from).collect();
    let (levels, _) = levels(&point, t, cubic(1e-9));
    assert_eq!(levels.len(), 1);
}

/// Data of any magnitude, far away from the origin or not, have as many control points.
#[test]
fn magnitude_and_place_do_not_matter() {
    let count = |factor: f64, offset: f64| {
        let points = lemniscate();
        let lanes = points.lanes().iter();
        let moved = lanes.map(|x| x.iter().map(|x| factor * x + offset).collect::<Vec<_>>());
        let t: Vec<f64> = chord(&points).iter().map(|t| t * factor).collect();
        let (levels, _) = levels(&Points::from_lanes(moved), t, cubic(1e-4 * factor));
        levels.last().unwrap().count()
    };
    let usual = count(1.0, 0.0);
    assert_eq!(count(1e-200, 0.0), usual);
    assert_eq!(count(1e200, 0.0), usual);
    assert!(count(1.0, 1e8).abs_diff(usual) <= 1);
}

/// Parameters stay by default; moved to the foot points they take fewer control points.
#[test]
fn parameters_move_on_request() {
    let points = sampled(400, 0.0, 3.0, |x| [x, (3.0 * x).sin()]);
    let t: Vec<f64> = (0..400).map(f64::from).collect();
    let run = |correct_parameters| {
        let settings = Settings {
            correct_parameters,
            ..cubic(1e-4)
        };
        levels(&points, t.clone(), settings).0
    };
    let (fixed, moved) = (run(false), run(true));
    assert!(fixed.iter().all(|level| *level.parameters[0] == t));
    let (fixed, moved) = (fixed.last().unwrap(), moved.last().unwrap());
    assert!(moved.parameters[0].windows(2).all(|pair| pair[0] < pair[1]));
    assert!(moved.distances.max <= 1e-4);
    assert!(moved.count() < fixed.count());
}
