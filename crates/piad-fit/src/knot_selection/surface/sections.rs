//! Sections with points between theirs, so that a surface follows each of them also where it has few points.
//!
//! They are on the spline of degree 3, or less, that goes through all points of the section and has its knots at them: at
//! equal steps of v, about as long in all sections as a quarter of the mean step of that with the most points.

use std::iter;
use std::sync::Arc;

use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::equations::{LeastSquares, Minimum};
use crate::knot_selection::values::Values;

/// The number of parts between two points of the section with the most of them, and the most between any two.
const PARTS: usize = 4;
const MOST_PARTS: usize = 16;

/// The degree of the splines.
const DEGREE: usize = 3;

/// The most points that there are with those between.
pub(crate) fn most_points(counts: &[usize]) -> usize {
    let most = counts.iter().max().copied().unwrap_or_default();
    let of_section = |&count: &usize| {
        let by_step = PARTS.saturating_mul(most).saturating_add(2 * count);
        by_step.min(MOST_PARTS * count)
    };
    counts.iter().map(of_section).sum()
}

/// The points of sections, of which these are the numbers of points and the parameters, and behind them those between.
pub(crate) fn with_points_between(
    points: &Points,
    [u, v]: &[Arc<Vec<f64>>; 2],
    counts: &[usize],
    period: Option<f64>,
) -> (Points, [Arc<Vec<f64>>; 2]) {
    let most = counts.iter().max().copied().unwrap_or_default();
    let (low, high) = v
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
    let step = period.unwrap_or(high - low) / (PARTS * most) as f64;
    let (mut all, mut all_u, mut all_v) = (points.clone(), u.to_vec(), v.to_vec());
    let mut start = 0;
    for count in counts {
        let section = start..start + count;
        start += count;
        let Some((between, parameters)) = between(points, v, section.clone(), (period, step))
        else {
            continue;
        };
        all_u.extend(iter::repeat_n(u[section.start], between.len()));
        all_v.extend(parameters.iter());
        for k in 0..between.len() {
            all.push(&between.point(k).collect::<Vec<_>>());
        }
    }
    (all, [Arc::new(all_u), Arc::new(all_v)])
}

/// The points between those of one section, with their v.
fn between(
    points: &Points,
    v: &[f64],
    section: std::ops::Range<usize>,
    (period, step): (Option<f64>, f64),
) -> Option<(Points, Vec<f64>)> {
    let mut order: Vec<usize> = section.collect();
    order.sort_by(|a, b| v[*a].total_cmp(&v[*b]).then(a.cmp(b)));
    order.dedup_by(|a, b| v[*a] == v[*b]);
    let t: Arc<Vec<f64>> = Arc::new(order.iter().map(|&index| v[index]).collect());
    let ends = t.iter().copied().chain(period.map(|period| t[0] + period));
    let ends: Vec<f64> = ends.collect();
    let line = through(&t, &ends, period.is_some())?;
    let section = Arc::new(points.selected(order.iter().copied()));
    let spline = LeastSquares::of(&section);
    let control_points = spline.minimum(&Values::new(&line, &t), None)?;
    let of_gap = |gap: &[f64]| {
        let (from, to) = (gap[0], gap[1]);
        let parts = ((to - from) / step).ceil().clamp(1.0, MOST_PARTS as f64) as usize;
        (1..parts).map(move |k| from + (to - from) * (k as f64 / parts as f64))
    };
    let parameters: Arc<Vec<f64>> = Arc::new(ends.windows(2).flat_map(of_gap).collect());
    let between = Values::new(&line, &parameters).points(&control_points);
    // Those beyond the end of a period are in the one before.
    let low = v.iter().copied().fold(f64::INFINITY, f64::min);
    let inside = |t: &f64| match period {
        Some(period) if *t >= low + period => t - period,
        _ => *t,
    };
    Some((between, parameters.iter().map(inside).collect()))
}

/// The knots of a spline through data at these parameters: at them, but for the second and the last but one of an open
/// line.
fn through(t: &[f64], ends: &[f64], is_closed: bool) -> Option<Breaks> {
    let degree = DEGREE.min(t.len().checked_sub(1)?);
    let breaks = match is_closed {
        true => ends.to_vec(),
        false => {
            let inner = t
                .windows(degree)
                .skip(1)
                .take(t.len().saturating_sub(degree + 1));
            let means = inner.map(|window| window.iter().sum::<f64>() / degree as f64);
            let (first, last) = (t[0], t[t.len() - 1]);
            iter::once(first).chain(means).chain([last]).collect()
        }
    };
    Breaks::new(degree, is_closed, breaks)
}
