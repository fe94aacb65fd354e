//! One knot in place of two neighbours, or of a cluster.
//!
//! Growth surrounds a place where the p-th derivative jumps with knots on either side, although one at that place would
//! suffice. With jumps `J_a` and `J_b` at a and b the knot that replaces both is at `(J_a a + J_b b) / (J_a + J_b)`:
//! then the change of the curve is of second order in b − a.

use std::ops::Range;

use super::breaks::Breaks;
use super::pruning::jumps;
use crate::data::points::Points;

/// The knots with one in place of two, the smallest changes of the curve first.
pub(super) fn merged<'a>(
    line: &'a Breaks,
    control_points: &Points,
) -> impl Iterator<Item = Breaks> + use<'a> {
    let jumps = jumps(line, control_points);
    let size = |jump: &[f64]| jump.iter().copied().fold(0.0, f64::hypot);
    let mut pairs: Vec<(f64, usize, f64)> = (1..line.spans() - 1)
        .map(|q| {
            let [before, after] = [&jumps[q - 1], &jumps[q]];
            let sum: Vec<f64> = before.iter().zip(after).map(|(a, b)| a + b).collect();
            let all = size(&sum);
            // The share of the second knot in the sum.
            let unit = sum.iter().map(|x| x / all);
            let part: f64 = unit.zip(after).map(|(unit, b)| unit * b).sum::<f64>() / all;
            let part = Some(part)
                .filter(|it| (0.0..=1.0).contains(it))
                .unwrap_or(0.5);
            let (low, high) = (line.breaks()[q], line.breaks()[q + 1]);
            let place = (1.0 - part) * low + part * high;
            (cost(line, q, part, all), q, place)
        })
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    pairs.into_iter().filter_map(|(_, q, place)| {
        let mut breaks = line.breaks().to_vec();
        breaks.remove(q);
        breaks[q] = place;
        Breaks::new(line.degree(), line.is_closed(), breaks)
    })
}

/// About how much the curve changes, but for a factor that is the same for all pairs.
fn cost(line: &Breaks, q: usize, part: f64, jump: f64) -> f64 {
    let breaks = line.breaks();
    let length = breaks[line.spans()] - breaks[0];
    let apart = (breaks[q + 1] - breaks[q]) / length;
    let around = (breaks[q + 2] - breaks[q - 1]) / length;
    let power = line.degree() as i32 - 2;
    jump * part * (1.0 - part) * apart * apart * around.powi(power)
}

/// Knots form a cluster, which one knot may replace, if their spans are at least this many times shorter than the spans
/// on either side.
const CROWDED: f64 = 4.0;

/// The knots with one in place of each cluster, if there are clusters.
pub(super) fn thinned(line: &Breaks) -> Option<Breaks> {
    let breaks = line.breaks();
    let gaps: Vec<f64> = breaks.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut crowds: Vec<Range<usize>> = (0..gaps.len()).filter_map(|m| crowd(&gaps, m)).collect();
    crowds.dedup();
    let mut thinned = breaks.to_vec();
    for spans in crowds.iter().rev() {
        let shortest = gaps[spans.clone()]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let is_shortest = |span: &usize| gaps[*span] == shortest;
        let first = spans.clone().find(is_shortest)?;
        let last = spans.clone().rfind(is_shortest)?;
        let place = 0.5 * breaks[first] + 0.5 * breaks[last + 1];
        thinned.splice(spans.start..=spans.end, [place]);
    }
    let is_less = !crowds.is_empty();
    Breaks::new(line.degree(), line.is_closed(), thinned).filter(|_| is_less)
}

/// The spans around this one that are not as much longer, if it is the shortest of them and longer ones are on either
/// side.
fn crowd(gaps: &[f64], shortest: usize) -> Option<Range<usize>> {
    let own = gaps[shortest];
    let ends = |span: &usize| gaps[*span] < own || gaps[*span] >= CROWDED * own;
    let left = (0..shortest).rev().find(ends)?;
    let right = (shortest + 1..gaps.len()).find(ends)?;
    let is_long = |span: usize| gaps[span] > own;
    (is_long(left) && is_long(right)).then_some(left + 1..right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two knots around the only place where the third derivative jumps become one there.
    #[test]
    fn a_kink_between_two_knots_gets_one() {
        let breaks = vec![0.0, 1.0, 2.0, 2.4, 3.5, 5.0];
        let line = Breaks::new(3, false, breaks).unwrap();
        let coarse = Breaks::new(3, false, vec![0.0, 1.0, 2.2, 3.5, 5.0]).unwrap();
        let numbers: Vec<f64> = (0..7).map(|i| (3.7 * i as f64).sin()).collect();
        let points = Points::from_lanes([numbers]);
        // Least squares of the curve with one knot, over the two.
        let t: Vec<f64> = (0..=500).map(|i| i as f64 / 100.0).collect();
        let t = std::sync::Arc::new(t);
        let values = super::super::values::Values::new(&coarse, &t);
        let data = values.points(&points);
        let minimum = super::super::equations::LeastSquares::of(&std::sync::Arc::new(data));
        let values = super::super::values::Values::new(&line, &t);
        let control_points =
            super::super::equations::Minimum::minimum(&minimum, &values, None).unwrap();
        let first = merged(&line, &control_points).next().unwrap();
        for (found, expected) in first.breaks().iter().zip(coarse.breaks()) {
            assert!((found - expected).abs() < 0.02, "{first:?}");
        }
    }
}
