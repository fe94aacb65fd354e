//! The density of knots: equal shares of a measure by the distances.
//!
//! The distance of a spline from a smooth curve on a span of length h is about `c h^(p+1)`. So a
//! span with the largest distance e would be within a tolerance τ if it were `(e/τ)^(1/(p+1))` times
//! shorter, and knots at equal shares of
//!
//! ```text
//! ∫ d(t) dt,   d = e_s^(1/(p+1)) / h_s on span s
//! ```
//!
//! have equal distances in all spans (the rule of de Boor's `newknt`, with measured distances in
//! place of a derivative that would have to be estimated; for data with steps and corners it needs
//! no derivative to exist). Repeated, it comes to rest at spans with equal distances, as long as it
//! is damped: neighbours share control points, and so their distances.
//!
//! The same density gives knots for any number of control points, and an estimate of how many a
//! tolerance needs: p and one for each share of τ^(1/(p+1)).

use super::breaks::{Breaks, control_points_beyond_spans};
use crate::data::bounds::Extent;

/// Spans count as if their distance were at least this part of the largest, so that none grows
/// without bound.
const LEAST: f64 = 0.02;

/// A density of knots, constant on spans.
#[derive(Clone, Debug)]
pub(crate) struct Monitor {
    line: Breaks,
    density: Vec<f64>,
}

impl Monitor {
    /// Of the distances at the parameters, which spans start at `starts`. With `damping` below one
    /// knots go only that part of the way.
    pub(crate) fn new(line: &Breaks, starts: &[usize], distances: &[f64], damping: f64) -> Self {
        let most = span_maxima(starts, distances);
        let largest = most.iter().copied().fold(0.0, f64::max);
        let power = damping / (line.degree() + 1) as f64;
        let raised: Vec<f64> = most.iter().map(|e| e.max(LEAST * largest)).collect();
        let lengths = line.breaks().windows(2).map(|pair| pair[1] - pair[0]);
        let density = smoothed(&raised, line.is_closed())
            .into_iter()
            .zip(lengths)
            .map(|(e, length)| {
                let share = if largest > 0.0 {
                    (e / largest).powf(power)
                } else {
                    1.0
                };
                share / length
            })
            .collect();
        let line = line.clone();
        Self { line, density }
    }

    /// The spans on which it is constant.
    pub(crate) fn line(&self) -> &Breaks {
        &self.line
    }

    /// Knots for this many control points, at equal shares; `None` if they are too close to be
    /// distinct.
    pub(crate) fn place(&self, control_points: usize) -> Option<Breaks> {
        let (degree, closed) = (self.line.degree(), self.line.is_closed());
        let spans = control_points.checked_sub(control_points_beyond_spans(degree, closed))?;
        let own = self.line.breaks();
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for (pair, density) in own.windows(2).zip(&self.density) {
            sum += density * (pair[1] - pair[0]);
            sums.push(sum);
        }
        let mut breaks = vec![own[0]];
        let mut s = 0;
        for k in 1..spans {
            let share = sum * (k as f64 / spans as f64);
            while s + 2 < sums.len() && sums[s + 1] <= share {
                s += 1;
            }
            let part = (share - sums[s]) / (sums[s + 1] - sums[s]);
            let (low, high) = (own[s], own[s + 1]);
            breaks.push((1.0 - part) * low + part * high);
        }
        breaks.push(own[self.line.spans()]);
        Breaks::new(degree, closed, breaks)
    }
}

/// The largest distance in each span.
pub(crate) fn span_maxima(starts: &[usize], distances: &[f64]) -> Vec<f64> {
    starts
        .windows(2)
        .map(|range| Extent::of(&distances[range[0]..range[1]]).high.max(0.0))
        .collect()
}

/// The number of control points with distances of at most `tolerance`, if each span were divided by
/// itself.
pub(crate) fn needed(line: &Breaks, maxima: &[f64], tolerance: f64) -> usize {
    let power = 1.0 / (line.degree() + 1) as f64;
    let shares: f64 = maxima.iter().map(|e| (e / tolerance).powf(power)).sum();
    let beyond = control_points_beyond_spans(line.degree(), line.is_closed());
    beyond + shares.ceil().min(1e15) as usize
}

/// Means of each value and its neighbours, which count half.
fn smoothed(values: &[f64], closed: bool) -> Vec<f64> {
    let n = values.len();
    if n < 3 {
        return values.to_vec();
    }
    let before = |i: usize| match i {
        0 if closed => Some(values[n - 1]),
        0 => None,
        _ => Some(values[i - 1]),
    };
    let behind = |i: usize| match values.get(i + 1) {
        None if closed => Some(values[0]),
        next => next.copied(),
    };
    (0..n)
        .map(|i| match (before(i), behind(i)) {
            // Symmetric, so that reversed data have reversed knots.
            (Some(a), Some(b)) => (2.0 * values[i] + (a + b)) / 4.0,
            (a, b) => (2.0 * values[i] + a.or(b).unwrap_or(0.0)) / 3.0,
        })
        .collect()
}
