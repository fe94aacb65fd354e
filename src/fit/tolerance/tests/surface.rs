//! Surfaces, against those of scipy.

use super::*;
use crate::fit::points::Grid;
use crate::fit::tolerance::surface::{Request, SurfaceLevel, SurfaceSchedule};

/// All levels of the graph of a function over a grid of [0, 1]².
fn graph(
    rows: usize,
    columns: usize,
    tolerance: f64,
    f: impl Fn(f64, f64) -> f64,
) -> (Points, Vec<Arc<SurfaceLevel>>, Option<Outcome>) {
    let at = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    let mut points = Points::new(3);
    for i in 0..rows {
        for j in 0..columns {
            let (u, v) = (at(i, rows), at(j, columns));
            points.push(&[u, v, f(u, v)]);
        }
    }
    let parameters = [rows, columns].map(|n| Arc::new((0..n).map(|i| at(i, n)).collect()));
    let mut schedule = SurfaceSchedule::new(Request {
        points: Arc::new(points.clone()),
        grid: Grid { rows, columns },
        parameters,
        degrees: [3, 3],
        tolerance,
    });
    let outcome = schedule.outcome();
    let levels = std::iter::from_fn(|| schedule.next_level()).collect();
    (points, levels, outcome)
}

/// Franke's function: a smooth one with hills.
fn franke(x: f64, y: f64) -> f64 {
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
        for pair in levels
            .windows(2)
            .filter(|pair| pair[1].phase == Phase::Insertion)
        {
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
