//! New knots in the middle of the spans that need them.

use super::breaks::Breaks;
use super::monitor::span_maxima;

/// Spans whose distance is below this part of the largest wait: they mostly follow from their
/// neighbours.
const SHARE: f64 = 0.05;

/// A knot in the middle of every span whose largest distance is above the tolerance and not far
/// below the worst. If that exceeds the requested maximum of `most` control points, only the worst
/// spans get one. `None` if no knot can be inserted: if the data would not determine the fit, or
/// there would be more than `limit` control points.
pub(crate) fn grown(
    line: &Breaks,
    t: &[f64],
    distances: &[f64],
    tolerance: f64,
    (limit, most): (usize, usize),
) -> Option<Breaks> {
    let starts = line.starts(t);
    let maxima = span_maxima(&starts, distances);
    let worst = maxima.iter().copied().fold(0.0, f64::max);
    // Where data are few, only spans that hold enough of them for both halves.
    [1, line.degree() + 1].into_iter().find_map(|least| {
        let middle = |span: usize| 0.5 * line.breaks()[span] + 0.5 * line.breaks()[span + 1];
        let is_asked = |&span: &usize| {
            let inside = &t[starts[span]..starts[span + 1]];
            let before = inside.partition_point(|&t| t < middle(span));
            let is_far = maxima[span] > tolerance && maxima[span] >= SHARE * worst;
            is_far && before >= least && inside.len() - before >= least
        };
        let mut asked: Vec<usize> = (0..line.spans()).filter(is_asked).collect();
        asked.sort_by(|&i, &j| maxima[j].total_cmp(&maxima[i]));
        asked.truncate(most.saturating_sub(line.control_points()));
        if asked.is_empty() {
            return None;
        }
        let mut breaks = line.breaks().to_vec();
        breaks.extend(asked.into_iter().map(middle));
        breaks.sort_by(f64::total_cmp);
        let grown = Breaks::new(line.degree(), line.is_closed(), breaks)?;
        (grown.control_points() <= limit && grown.is_determined(t)).then_some(grown)
    })
}
