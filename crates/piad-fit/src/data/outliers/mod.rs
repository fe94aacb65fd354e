//! Outliers: points that are far from where their neighbours predict them.
//!
//! Each point is compared with a prediction by its neighbours: it is *off* by its distance from the prediction, and the
//! *doubt* is the disagreement of its neighbours. It is an outlier if
//!
//! ```text
//! off > 4.685 · 1.4826 · median of all distances + c · doubt,
//! ```
//!
//! beyond which Tukey's biweight is zero (Beaton, Tukey 1974; 1.4826 times the median is the standard deviation of
//! normal errors). Neighbours that were outliers in the round before are left out, so that the comparison improves in
//! each round; after a few rounds nothing changes.
//!
//! - [`along`] a curve, where each point has neighbours before and behind it;
//! - [`scattered`] over a surface, where neighbours have the nearest parameters, without those that are [`isolated`] in
//!   space.

mod along;
mod isolated;
mod scattered;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::data::points::{Points, ROUNDING};
use crate::interrupt;

pub(crate) use along::Along;
pub(crate) use isolated::isolated;
pub(crate) use scattered::Cloud;

/// With fewer points, outliers cannot be identified.
pub(crate) const FEWEST_POINTS: usize = 8;

/// The most rounds.
const ROUNDS: usize = 6;

/// The standard deviation of normal errors over the median of their distances.
const DEVIATION: f64 = 1.4826;

/// Tukey's biweight is zero beyond this number of standard deviations.
const ZERO_WEIGHT: f64 = 4.685;

/// A combination of points, by index, whose factors have the sum one.
type Combination = Vec<(usize, f64)>;

/// The first coefficient of the combination of three functions that is nearest to points, given by their values at each of
/// these; `None` if the points do not determine it.
fn fitted(rows: impl Iterator<Item = (usize, [f64; 3])>) -> Option<Combination> {
    let rows: Vec<(usize, Vector3<f64>)> = rows.map(|(i, row)| (i, row.into())).collect();
    let moments: Matrix3<f64> = rows.iter().map(|(_, row)| row * row.transpose()).sum();
    let first = moments.cholesky()?.solve(&Vector3::x());
    Some(rows.iter().map(|(i, row)| (*i, first.dot(row))).collect())
}

/// The distance between two combinations, or of one and a point; `None` is a point itself.
fn apart(points: &Points, index: usize, one: &[(usize, f64)], other: &[(usize, f64)]) -> f64 {
    let differences = points.lanes().iter().map(|lane| {
        let sum = |terms: &[(usize, f64)]| -> f64 {
            let terms = terms.iter();
            terms
                .map(|&(j, factor)| factor * (lane[j] - lane[index]))
                .sum()
        };
        sum(one) - sum(other)
    });
    differences.fold(0.0, f64::hypot)
}

/// Points with neighbours.
pub(crate) trait Neighbourhood: Sync {
    /// The factor c of doubt.
    const DOUBT: f64;

    /// The number of points.
    fn count(&self) -> usize;

    /// The distance of a point from the prediction of its neighbours, of which some are left out; `None` if there are
    /// too few.
    fn off(&self, index: usize, is_left_out: &[bool]) -> Option<f64>;

    /// The disagreement of these neighbours.
    fn doubt(&self, index: usize, is_left_out: &[bool]) -> f64;
}

/// The outliers, in order. Points that are off by at most `least`, or that `is_kept`, are not outliers.
pub(crate) fn find<N: Neighbourhood>(
    points: &N,
    least: f64,
    is_kept: impl Fn(usize) -> bool + Sync,
) -> Vec<usize> {
    let mut outliers = vec![false; points.count()];
    for _ in 0..ROUNDS {
        interrupt::check();
        let all = (0..points.count()).into_par_iter();
        let off: Vec<f64> = all
            .clone()
            .map(|index| points.off(index, &outliers).unwrap_or(0.0))
            .collect();
        let usual = ZERO_WEIGHT * DEVIATION * median(off.clone());
        let is_outlier = |index: usize| {
            off[index] > least.max(usual)
                && !is_kept(index)
                && off[index] > usual + N::DOUBT * points.doubt(index, &outliers)
        };
        let found: Vec<bool> = all.map(is_outlier).collect();
        if found == outliers {
            break;
        }
        outliers = found;
    }
    (0..points.count())
        .filter(|&index| outliers[index])
        .collect()
}

/// With fewer points of a curve only spikes are searched.
const MOST_WITH_SPIKES: usize = 100_000;

/// Spikes are at most one point in this number.
const ONE_IN: usize = 10;

/// A spike is this number of times further from its neighbours than they are from each other.
const SPIKE_RATIO: f64 = 2.0;

/// The spikes of a curve with few points, which are outliers whatever the noise is: their neighbours on either side are
/// nearer to each other than to them.
pub(crate) fn spikes(points: &Points, closed: bool) -> Vec<usize> {
    let count = points.len();
    if !(FEWEST_POINTS..=MOST_WITH_SPIKES).contains(&count) {
        return Vec::new();
    }
    let along = Along {
        points,
        parameters: None,
        closed,
    };
    let found = find(&along, points.magnitude() * ROUNDING, |_| false);
    if found.len() * ONE_IN > count {
        return Vec::new();
    }
    let is_spike = |&index: &usize| {
        let right = |places: &mut dyn Iterator<Item = usize>| {
            places
                .map(|it| it % count)
                .find(|it| found.binary_search(it).is_err())
        };
        let before = right(&mut (index + 1..index + count).rev());
        let behind = right(&mut (index + 1..index + count));
        before.zip(behind).is_some_and(|(a, b)| {
            let nearest = points.distance(a, index).min(points.distance(index, b));
            nearest > SPIKE_RATIO * points.distance(a, b)
        })
    };
    found.iter().copied().filter(is_spike).collect()
}

/// The middle of some values in their order; zero of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests;
