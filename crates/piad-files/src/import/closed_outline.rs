//! Outlines whose last point equals the first one, but for rounding: closed curves, in which that point is kept once.

use super::imported::{Hints, Kind};
use super::part::Part;
use piad_fit::data::Points;

/// Cosine of the sharpest turn, 60°, at which an outline is taken to be smooth. The trailing edge of an airfoil turns
/// by more than 160°, or by 90° where it is blunt, and stays an end.
const SHARPEST_TURN: f64 = 0.5;

/// The fewest points of an outline that is closed by default. With fewer, a corner cannot be distinguished from a
/// curve, and closed curves of some degrees need this many.
const FEWEST: usize = 8;

/// The last point equals the first one if it is no further from it than this part of the size of the outline.
const SAME: f64 = 1e-9;

/// Returns true if the points are those of a closed curve. If so, the copy of the first point is removed.
pub(super) fn closed(part: &mut Part, hints: &Hints) -> bool {
    if part.closed {
        return hints.closed != Some(false);
    }
    let last = part.points.len() - 1;
    let surface = hints.kind == Some(Kind::Surface);
    if surface || last < 3 || !is_same(&part.points, last) {
        return false;
    }
    let smooth = last >= FEWEST && turn(&part.points) >= SHARPEST_TURN;
    let closed = hints.closed.unwrap_or(smooth);
    if closed {
        part.points.truncate(last);
        part.lines.truncate(last);
        part.breaks.retain(|index| *index < last);
    }
    let what = match (closed, hints.closed) {
        (true, _) => "the curve is closed, and the point is kept once",
        (false, None) => "the curve stays open, as there is a corner or there are few points",
        (false, Some(_)) => "the curve stays open, as requested or for its basis",
    };
    let notice = format!("The last point equals the first: {what}.");
    part.notices.push(notice);
    closed
}

/// Returns true if the last point is the first one, but for rounding.
fn is_same(points: &Points, last: usize) -> bool {
    let distance = points.distance(0, last);
    let near = SAME * points.bounding_diagonal();
    distance == 0.0 || (near.is_finite() && distance <= near)
}

/// Cosine of the angle between the last edge of a closed polygon and the first one. Edges of length
/// zero have no direction, and no corner is seen there.
fn turn(points: &Points) -> f64 {
    let last = points.len() - 1;
    let edge = |from: usize, to: usize| -> Vec<f64> {
        let lanes = points.lanes().iter();
        let ends = lanes.filter_map(|lane| Some((lane.get(from)?, lane.get(to)?)));
        ends.map(|(from, to)| to - from).collect()
    };
    let (arriving, leaving) = (edge(last - 1, last), edge(0, 1));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let lengths = (dot(&arriving, &arriving) * dot(&leaving, &leaving)).sqrt();
    match lengths > 0.0 {
        true => dot(&arriving, &leaving) / lengths,
        false => 1.0,
    }
}
