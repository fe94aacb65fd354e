//! Removal of single knots, in order of increasing change of the curve.
//!
//! Equal distances on all spans determine the knots as long as a span has many data. Where there are hardly more data
//! than control points they do not: a span without a datum has no distance. There, knots are removed one by one from a
//! curve that has more control points than needed.
//!
//! A simple knot is a jump of the p-th derivative. The B-spline over it and p + 1 knots around it
//! has such a jump, too:
//!
//! ```text
//! N⁽ᵖ⁾ jumps at t_q by  p! (t_last − t_first) / Π_{i ≠ q} |t_q − t_i|
//! ```
//!
//! The cost of a removal is the multiple of it that cancels the jump of the curve (Lyche, Mørken, *Knot removal for
//! parametric B-spline curves and surfaces*, CAGD 4 (1987)).

use super::breaks::Breaks;
use crate::data::points::Points;

/// The places of the knots between the ends, the cheapest removals first.
fn by_cost(line: &Breaks, control_points: &Points) -> impl Iterator<Item = usize> + use<> {
    let mut order: Vec<(f64, usize)> = costs(line, control_points)
        .into_iter()
        .zip(1..line.spans())
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, place)| place)
}

/// At most this part of the knots is removed at once.
const MOST: usize = 4;

/// Tries knots without several of them, half as many after each failure, as long as these are more than `fewest`. The
/// next call continues with `batch`, the number that has not failed yet. Returns true after a success.
pub(super) fn in_batches(
    batch: &mut Option<usize>,
    (line, control_points): (&Breaks, &Points),
    fewest: usize,
    mut succeeds: impl FnMut(Breaks) -> bool,
) -> bool {
    let most = line.spans() / MOST;
    let mut count = batch.map_or(most, |it| it.min(most));
    while count > fewest && !without(line, control_points, count).is_some_and(&mut succeeds) {
        count /= 2;
    }
    *batch = Some(count);
    count > fewest
}

/// The knots without some of them, the cheapest removals, but no two beside each other: what one costs depends on those
/// around it.
fn without(line: &Breaks, control_points: &Points, most: usize) -> Option<Breaks> {
    let mut stays = vec![true; line.spans() + 1];
    let mut left = most;
    for place in by_cost(line, control_points) {
        if left > 0 && stays[place - 1] && stays[place + 1] {
            (stays[place], left) = (false, left - 1);
        }
    }
    let breaks = line.breaks().iter().zip(stays);
    let breaks = breaks.filter(|(_, stays)| *stays).map(|(knot, _)| *knot);
    Breaks::new(line.degree(), line.is_closed(), breaks.collect())
}

/// The knots without one of them, the cheapest removals first.
pub(super) fn fewer<'a>(
    line: &'a Breaks,
    control_points: &Points,
) -> impl Iterator<Item = Breaks> + use<'a> {
    by_cost(line, control_points).filter_map(|place| {
        let mut breaks = line.breaks().to_vec();
        breaks.remove(place);
        Breaks::new(line.degree(), line.is_closed(), breaks)
    })
}

/// How much the p-th derivative jumps at each knot between the ends, in each coordinate.
pub(super) fn jumps(line: &Breaks, control_points: &Points) -> Vec<Vec<f64>> {
    let mut jumps = vec![Vec::with_capacity(control_points.dimension()); line.spans() - 1];
    for lane in control_points.lanes() {
        let highest = highest_derivative(line, lane);
        let steps = highest.windows(2).map(|pair| pair[1] - pair[0]);
        let each = jumps.iter_mut().zip(steps);
        each.for_each(|(jump, step)| jump.push(step));
    }
    jumps
}

/// What the removal of each knot between the ends costs, but for a factor that is the same for all.
fn costs(line: &Breaks, control_points: &Points) -> Vec<f64> {
    let jumps = jumps(line, control_points).into_iter();
    let jumps = jumps.map(|jump| jump.into_iter().fold(0.0, f64::hypot));
    let (degree, length) = (line.degree() as isize, length(line));
    let places = degree + 1..;
    let costs = jumps.zip(places).map(|(jump, q)| {
        let first = q - (degree + 1) / 2;
        let last = first + degree + 1;
        let others = (first..=last).filter(|&i| i != q);
        let away = others.map(|i| (line.knot(q) - line.knot(i)).abs() / length);
        jump * away.product::<f64>() / ((line.knot(last) - line.knot(first)) / length)
    });
    costs.collect()
}

/// The p-th derivative on each span, where the whole length is one.
fn highest_derivative(line: &Breaks, lane: &[f64]) -> Vec<f64> {
    let (degree, length) = (line.degree(), length(line));
    let functions = line.spans() + degree;
    let mut x: Vec<f64> = (0..functions)
        .map(|j| lane[line.control_point(j)])
        .collect();
    for r in 1..=degree {
        let knot = |i: usize| line.knot(i as isize);
        x = (r..functions)
            .zip(x.windows(2))
            .map(|(j, pair)| (pair[1] - pair[0]) * (length / (knot(j + degree + 1 - r) - knot(j))))
            .collect();
    }
    x
}

fn length(line: &Breaks) -> f64 {
    line.breaks()[line.spans()] - line.breaks()[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::knot_selection::insertion::refine;

    /// A knot that was inserted costs nothing, and is removed first; in any unit.
    #[test]
    fn inserted_knots_leave_first() {
        for (degree, closed) in [
            (1, false),
            (2, false),
            (3, false),
            (5, false),
            (2, true),
            (3, true),
        ] {
            for unit in [1e-290, 1.0, 1e290] {
                let at = |numbers: &[f64]| numbers.iter().map(|x| x * unit).collect::<Vec<f64>>();
                let coarse = at(&[0.0, 0.7, 1.0, 2.1, 3.3, 3.4, 5.0]);
                let coarse = Breaks::new(degree, closed, coarse).unwrap();
                let fine = at(&[0.0, 0.7, 1.0, 2.1, 2.6, 3.3, 3.4, 5.0]);
                let fine = Breaks::new(degree, closed, fine).unwrap();
                let numbers = |seed: f64| {
                    (0..coarse.control_points()).map(move |i| unit * (seed * i as f64).sin())
                };
                let lanes = [3.7, 5.1].map(|seed| numbers(seed).collect::<Vec<f64>>());
                let points = refine(&coarse, &fine, &Points::from_lanes(lanes));
                assert_eq!(
                    fewer(&fine, &points).next(),
                    Some(coarse),
                    "{degree}, {unit:e}"
                );
                assert_eq!(fewer(&fine, &points).count(), 6);
            }
        }
    }
}
