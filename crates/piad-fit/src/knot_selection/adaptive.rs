//! The best knots for a given number of control points: rounds of redistribution by the distances ([`super::monitor`])
//! converge to about equal distances in all spans; few knots then move, one by one, to where the sum of squares is
//! smallest ([`super::knot_step`]).

use std::sync::Arc;

use super::breaks::Breaks;
use super::equations::{LeastSquares, Minimum};
use super::monitor::Monitor;
use super::placement::place;
use super::values::Values;
use crate::data::distances::Distances;
use crate::data::points::{Points, normalizing_scale};
use crate::interrupt;

/// The most least-squares fits of redistribution.
pub(crate) const ROUNDS: usize = 30;

/// Redistribution ends after this number of fits that do not lower the largest distance.
const PATIENCE: usize = 6;

/// How far knots go towards equal distances in a round.
const DAMPING: f64 = 0.7;

/// Steps of single knots.
const STEPS: usize = 30;

/// How little each of them goes at first.
pub(super) const FIRST_DAMPING: f64 = 1e-3;

/// A fit over some knots.
struct Fitted {
    values: Values,
    control_points: Points,
    distances: Distances,
}

/// The knots, for this number of control points, that give the lowest largest distance found, from data at increasing
/// parameters. `None` if the data do not determine a fit with this number.
pub(crate) fn adapted(
    points: &Arc<Points>,
    weights: Option<Arc<Vec<f64>>>,
    t: &Arc<Vec<f64>>,
    coarsest: &Breaks,
    control_points: usize,
) -> Option<Breaks> {
    let minimum = LeastSquares {
        data_weights: weights,
        ..LeastSquares::of(points)
    };
    let fit = |line: &Breaks| {
        let values = Values::new(line, t);
        let control_points = minimum.minimum(&values, None)?;
        let unit = normalizing_scale(points.magnitude());
        let distances = values.distances(control_points.lanes(), points.lanes(), unit);
        Some(Fitted {
            values,
            control_points,
            distances,
        })
    };
    let monitor = |fitted: &Fitted, damping: f64| {
        let line = fitted.values.line();
        Monitor::new(
            line,
            fitted.values.starts(),
            &fitted.distances.each,
            damping,
        )
    };
    let even = Monitor::new(coarsest, &coarsest.starts(t), &vec![0.0; t.len()], 1.0);
    let mut now = fit(&place(&even, t, control_points)?)?;
    let mut best: Option<Fitted> = None;
    let mut without_gain = 0;
    for round in 0..ROUNDS {
        interrupt::check();
        let damping = if round == 0 { 1.0 } else { DAMPING };
        let next = place(&monitor(&now, damping), t, control_points);
        let lowest = best.as_ref().map_or(f64::INFINITY, |it| it.distances.max);
        let is_lower = now.distances.max < lowest;
        let Some(next) = next.and_then(|line| fit(&line)) else {
            break;
        };
        let before = std::mem::replace(&mut now, next);
        without_gain = if is_lower { 0 } else { without_gain + 1 };
        if is_lower {
            best = Some(before);
        }
        if without_gain == PATIENCE {
            break;
        }
    }
    let mut best = best
        .filter(|best| best.distances.max <= now.distances.max)
        .unwrap_or(now);
    let mut found = (best.distances.max, best.values.line().clone());
    let mut damping = FIRST_DAMPING;
    for _ in 0..STEPS {
        interrupt::check();
        let moved = minimum.moved_knots(&best.values, &best.control_points, damping);
        let Some(line) = moved else {
            break;
        };
        let next = Some(line).filter(|line| line.is_determined(t));
        let next = next.and_then(|line| fit(&line));
        match next.filter(|next| next.distances.rms < best.distances.rms) {
            Some(next) => (best, damping) = (next, damping / 10.0),
            None if damping > 1.0 => break,
            None => damping *= 10.0,
        }
        if best.distances.max < found.0 {
            found = (best.distances.max, best.values.line().clone());
        }
    }
    Some(found.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::knots;

    fn largest(points: &Arc<Points>, t: &Arc<Vec<f64>>, line: &Breaks) -> f64 {
        let minimum = LeastSquares::of(points);
        let values = Values::new(line, t);
        let control_points = minimum.minimum(&values, None).unwrap();
        let unit = normalizing_scale(points.magnitude());
        let distances = values.distances(control_points.lanes(), points.lanes(), unit);
        distances.max
    }

    /// A step needs its knots where it is steep.
    #[test]
    fn knots_go_where_a_step_is() {
        for (degree, count, gain) in [
            (2, 20, 50.0),
            (3, 40, 500.0),
            (3, 41, 500.0),
            (5, 30, 100.0),
        ] {
            let x = |i: usize| -1.0 + 2.0 * i as f64 / 1000.0;
            let lanes = [
                (0..=1000).map(x).collect::<Vec<f64>>(),
                (0..=1000).map(|i| (20.0 * x(i)).tanh()).collect(),
            ];
            let t = Arc::new(lanes[0].clone());
            let points = Arc::new(Points::from_lanes(lanes));
            let coarsest = Breaks::coarsest(degree, false, -1.0, 1.0).unwrap();
            let line = adapted(&points, None, &t, &coarsest, count).unwrap();
            assert_eq!(line.control_points(), count);
            let spread = knots::spread(&t, degree, count);
            let spread = Breaks::new(degree, false, spread[degree..=count].to_vec()).unwrap();
            let (found, before) = (largest(&points, &t, &line), largest(&points, &t, &spread));
            assert!(
                gain * found < before,
                "{degree} {count}: {found:e} {before:e}"
            );
        }
    }
}
