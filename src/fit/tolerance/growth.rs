//! New knots in the middle of the spans that need them.

use super::line::KnotLine;
use super::monitor::span_maxima;

/// Spans whose distance is below this part of the largest wait: they mostly follow from their
/// neighbours.
const SHARE: f64 = 0.05;

/// A knot in the middle of every span whose largest distance is above the tolerance and not far
/// below the worst. `None` if no knot can be inserted: if the data would not determine the fit, or
/// there would be more than `limit` control points.
pub(crate) fn grown(
    line: &KnotLine,
    t: &[f64],
    distances: &[f64],
    tolerance: f64,
    limit: usize,
) -> Option<KnotLine> {
    let starts = line.starts(t);
    let maxima = span_maxima(&starts, distances);
    let worst = maxima.iter().copied().fold(0.0, f64::max);
    // Where data are few, only spans that hold enough of them for both halves.
    [1, line.degree() + 1].into_iter().find_map(|least| {
        let mut breaks = Vec::with_capacity(2 * maxima.len() + 1);
        for (span, pair) in line.breaks().windows(2).enumerate() {
            breaks.push(pair[0]);
            let middle = 0.5 * pair[0] + 0.5 * pair[1];
            let inside = &t[starts[span]..starts[span + 1]];
            let before = inside.partition_point(|&t| t < middle);
            let asked = maxima[span] > tolerance && maxima[span] >= SHARE * worst;
            if asked && before >= least && inside.len() - before >= least {
                breaks.push(middle);
            }
        }
        breaks.push(line.breaks()[line.spans()]);
        if breaks.len() == line.breaks().len() {
            return None;
        }
        let grown = KnotLine::new(line.degree(), line.is_closed(), breaks)?;
        (grown.control_points() <= limit && grown.is_determined(t)).then_some(grown)
    })
}
