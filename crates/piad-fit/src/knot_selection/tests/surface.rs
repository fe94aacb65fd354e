//! Surfaces, against those of scipy.

use super::*;
use crate::data::grid::Grid;
use crate::knot_selection::surface::{GridData, SurfaceSchedule};

/// Returns true if the second of two levels is the first one with more knots in one direction.
pub(super) fn is_inserted(pair: &[Arc<Level<2>>]) -> bool {
    let [coarse, fine] = [0, 1].map(|k| &pair[k].lines);
    (0..2).any(|axis| is_refined(&coarse[axis], &fine[axis]) && coarse[1 - axis] == fine[1 - axis])
}

/// Bicubic and open, with as many control points as needed.
pub(super) fn bicubic(tolerance: f64) -> Settings<2> {
    Settings::cubic(tolerance)
}

/// The points of a function at a grid of [0, 1]², without the end of closed directions, and its
/// parameters.
fn sampled_grid(
    counts: [usize; 2],
    periods: [Option<f64>; 2],
    f: impl Fn(f64, f64) -> [f64; 3],
) -> (Points, [Arc<Vec<f64>>; 2]) {
    let t = [0, 1].map(|axis| {
        let parts = counts[axis] - usize::from(periods[axis].is_none());
        let at = |i: usize| i as f64 / parts as f64;
        (0..counts[axis]).map(at).collect::<Vec<f64>>()
    });
    let mut points = Points::new(3);
    for &u in &t[0] {
        t[1].iter().for_each(|&v| points.push(&f(u, v)));
    }
    (points, t.map(Arc::new))
}

/// The fit of a function at a grid.
fn schedule(
    counts: [usize; 2],
    settings: Settings<2>,
    f: impl Fn(f64, f64) -> [f64; 3],
) -> (Points, SurfaceSchedule) {
    let (points, parameters) = sampled_grid(counts, settings.periods, f);
    let [rows, columns] = counts;
    let grid = Grid { rows, columns };
    let options = settings.options(&parameters);
    let data = GridData::new(&Arc::new(points.clone()), grid, parameters);
    (points, SurfaceSchedule::new(Box::new(data), options))
}

/// All levels, and how the fit has ended.
pub(super) fn all(mut schedule: SurfaceSchedule) -> (Vec<Arc<Level<2>>>, Option<Outcome>) {
    let levels = std::iter::from_fn(|| schedule.next_level()).collect();
    (levels, schedule.outcome())
}

/// All levels of the graph of a function over a grid of [0, 1]².
fn graph(
    rows: usize,
    columns: usize,
    tolerance: f64,
    f: impl Fn(f64, f64) -> f64,
) -> (Points, Vec<Arc<Level<2>>>, Option<Outcome>) {
    let f = |u, v| [u, v, f(u, v)];
    let (points, schedule) = schedule([rows, columns], bicubic(tolerance), f);
    let (levels, outcome) = all(schedule);
    (points, levels, outcome)
}

/// Franke's function: a smooth one with hills.
pub(super) fn franke(x: f64, y: f64) -> f64 {
    let (x, y) = (9.0 * x, 9.0 * y);
    let square = |a: f64| a * a;
    0.75 * (-(square(x - 2.0) + square(y - 2.0)) / 4.0).exp()
        + 0.75 * (-square(x + 1.0) / 49.0 - (y + 1.0) / 10.0).exp()
        + 0.5 * (-(square(x - 7.0) + square(y - 3.0)) / 4.0).exp()
        - 0.2 * (-square(x - 4.0) - square(y - 7.0)).exp()
}

/// Insertion keeps the surface, corners are interpolated, and the last level is within the
/// tolerance with fewer control points than growth has needed.
#[test]
fn levels_of_surfaces() {
    let (rows, columns) = (81, 61);
    // With scipy 1.17.1, `RectBivariateSpline`, the best of twenty smoothing factors; and ours.
    for (tolerance, scipy, ours) in [(1e-2, 169, 110), (1e-3, 420, 224), (1e-4, 1023, 504)] {
        let (points, levels, outcome) = graph(rows, columns, tolerance, franke);
        assert_eq!(outcome, Some(Outcome::Converged));
        assert_eq!(levels[0].count(), 16);
        let last = levels.last().unwrap();
        assert!(last.distances.max <= tolerance);
        let grown = levels.iter().map(|level| level.count()).max().unwrap();
        assert!(last.count() <= ours && ours < scipy, "{}", last.count());
        assert!(last.count() < grown);
        for pair in levels.windows(2).filter(|pair| is_inserted(pair)) {
            let mut each = pair[0].distances.each.iter().zip(&pair[1].distances.each);
            assert!(each.all(|(a, b)| (a - b).abs() < 1e-13));
        }
        for level in &levels {
            let (n, m) = (
                level.lines[0].control_points(),
                level.lines[1].control_points(),
            );
            for (x, p) in [
                (0, 0),
                (m - 1, columns - 1),
                ((n - 1) * m, (rows - 1) * columns),
                (n * m - 1, rows * columns - 1),
            ] {
                let mut pairs = level.control_points.point(x).zip(points.point(p));
                assert!(pairs.all(|(x, p)| (x - p).abs() < 1e-15));
            }
        }
    }
}

/// A cylinder needs knots in one direction only, and a plane none.
#[test]
fn knots_go_where_they_are_needed() {
    let (_, levels, _) = graph(40, 90, 1e-5, |_, v| (9.0 * v).sin());
    let last = levels.last().unwrap();
    assert_eq!(last.lines[0].control_points(), 4);
    assert!(last.lines[1].control_points() > 12);
    let (_, levels, outcome) = graph(20, 30, 1e-12, |u, v| 2.0 * u - v);
    assert_eq!((levels.len(), outcome), (1, Some(Outcome::Converged)));
}

/// The levels come one by one, the same again each time.
#[test]
fn levels_are_computed_when_they_are_asked_for() {
    let f = |u, v| [u, v, franke(u, v)];
    let make = || schedule([40, 37], bicubic(1e-3), f).1;
    let (mut one, (all, _)) = (make(), all(make()));
    for (i, expected) in all.iter().enumerate() {
        assert_eq!(one.outcome(), None, "before level {i}");
        let level = one.next_level().unwrap();
        assert_eq!(level.control_points, expected.control_points);
        assert_eq!(level.lines, expected.lines);
    }
    assert!(one.next_level().is_none());
    assert_eq!(one.outcome(), Some(Outcome::Converged));
}

/// A limit holds for every level; if the tolerance is out of reach with it, that is reported.
#[test]
fn a_limit_stops_the_fit() {
    let f = |u, v| [u, v, franke(u, v)];
    let fit = |tolerance, max_control_points| {
        let settings = Settings {
            max_control_points,
            ..bicubic(tolerance)
        };
        all(schedule([81, 61], settings, f).1)
    };
    let (free, _) = fit(1e-3, [usize::MAX; 2]);
    let counts = free.last().unwrap().counts();
    for (limit, outcome) in [
        ([9, 60], Outcome::Exhausted),
        ([60, 9], Outcome::Exhausted),
        ([1, 1], Outcome::Exhausted),
        ([counts[0] + 1, counts[1] + 1], Outcome::Converged),
    ] {
        let (levels, found) = fit(1e-3, limit);
        assert_eq!(found, Some(outcome), "{limit:?}");
        for level in &levels {
            let counts = level.counts();
            assert!((0..2).all(|axis| counts[axis] <= limit[axis].max(4)));
        }
        let smallest = levels.iter().map(|level| level.distances.max);
        let last = levels.last().unwrap().distances.max;
        if outcome == Outcome::Exhausted {
            assert_eq!(last, smallest.fold(f64::INFINITY, f64::min));
        }
    }
}

/// A torus, closed in both directions, with sides that share no factor: it needs fewer control
/// points than an open one, and is closed to rounding.
#[test]
fn closed_directions() {
    let torus = |u: f64, v: f64| {
        let (a, b) = (2.0 * PI * u, 2.0 * PI * v);
        let r = 3.0 + (1.0 + 0.3 * (3.0 * a).cos()) * b.cos();
        [r * a.cos(), r * a.sin(), b.sin()]
    };
    let fit = |periods, tolerance| {
        let settings = Settings {
            periods,
            ..bicubic(tolerance)
        };
        let (levels, outcome) = all(schedule([47, 31], settings, torus).1);
        assert_eq!(outcome, Some(Outcome::Converged), "{periods:?}");
        let last = Arc::clone(levels.last().unwrap());
        assert!(last.distances.max <= tolerance);
        assert_eq!(levels[0].counts(), [4, 4]);
        for pair in levels.windows(2).filter(|pair| is_inserted(pair)) {
            let mut each = pair[0].distances.each.iter().zip(&pair[1].distances.each);
            assert!(each.all(|(a, b)| (a - b).abs() < 1e-13));
        }
        last.counts()
    };
    for tolerance in [1e-1, 1e-2, 1e-3] {
        let both = fit([Some(1.0), Some(1.0)], tolerance);
        let along = fit([Some(1.0), None], tolerance);
        let across = fit([None, Some(1.0)], tolerance);
        let neither = fit([None, None], tolerance);
        let count = |counts: [usize; 2]| counts[0] * counts[1];
        assert!(count(both) <= count(along).min(count(across)));
        assert!(count(along).max(count(across)) <= count(neither));
    }
}

/// Sides that share no factor, down to as many control points as data; and far from the origin.
#[test]
fn any_sides_and_any_place() {
    let wave = |u: f64, v: f64| (7.0 * u).sin() * (11.0 * v).cos() + (40.0 * u * v).sin();
    let (_, levels, outcome) = graph(31, 47, 1e-9, wave);
    assert_eq!(outcome, Some(Outcome::Converged));
    assert!(levels.last().unwrap().distances.max <= 1e-9);
    let far = |offset: f64| {
        let f = |u: f64, v: f64| [u + offset, v - offset, franke(u, v) + offset];
        let (levels, outcome) = all(schedule([31, 47], bicubic(1e-3), f).1);
        assert_eq!(outcome, Some(Outcome::Converged));
        levels.last().unwrap().counts()
    };
    assert_eq!(far(0.0), far(1048576.0));
}

/// The smallest grids of each degree.
#[test]
fn tiny_grids() {
    for degree in [1, 2, 3] {
        let settings = Settings {
            degrees: [degree, degree],
            ..bicubic(1e-9)
        };
        let n = degree + 1;
        let f = |u: f64, v: f64| [u, v, (3.0 * u).exp() * v + u];
        let (levels, outcome) = all(schedule([n, n], settings, f).1);
        assert_eq!((levels.len(), outcome), (1, Some(Outcome::Converged)));
        assert_eq!(levels[0].count(), n * n);
    }
    // Fewer data than control points, open and closed.
    for (counts, periods) in [
        ([2, 2], [None, None]),
        ([2, 30], [None, None]),
        ([9, 3], [None, Some(1.0)]),
        ([3, 3], [Some(1.0), Some(1.0)]),
    ] {
        let settings = Settings {
            periods,
            ..bicubic(1e-3)
        };
        let f = |u: f64, v: f64| [u, v, (9.0 * u + 5.0 * v).sin()];
        let (levels, outcome) = all(schedule(counts, settings, f).1);
        assert_eq!(outcome, Some(Outcome::Converged), "{counts:?}");
        assert!(levels.last().unwrap().distances.max <= 1e-3);
    }
}

/// Across a crease knots are close together, and along it there are as few as possible.
#[test]
fn creases_take_few_lines() {
    let (_, levels, outcome) = graph(60, 200, 1e-6, |u, _| (u - 29.0 / 59.0).abs());
    assert_eq!(outcome, Some(Outcome::Converged));
    let [rows, columns] = levels.last().unwrap().counts();
    assert!(rows <= 20 && columns == 4, "{rows} × {columns}");
}
