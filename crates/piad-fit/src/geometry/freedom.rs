//! The freedom that data leave a curve or surface between neighbours.
//!
//! The straight line between two data points, and the bilinear patch between four of a grid, are the reference between
//! the data where these are straight. Where they bend they leave freedom. The measure of it is the *bend* of a gap: how
//! far a cubic with the derivatives of parabolas through three successive data (Bessel) is from the straight line. No
//! derivative would lead further than one and a half times the longer of the chords beside it. An interpolating spline
//! passes a part of a bend on to the next gap, and of that again, by the largest root of the Euler–Frobenius polynomial
//! of its degree (.268 for cubics: Schoenberg, *Cardinal spline interpolation*, 1973).

use crate::basis::Basis;
use crate::basis::direction::Direction;
use crate::data::points::Points;

/// The freedom of a gap is that many times its bend: so far from straight lines are cubics that interpolate white noise.
const FACTOR: f64 = 4.0;

/// The first and the last gap of an open line bend by this many times as much, as nothing continues there.
const FACTOR_OF_ENDS: f64 = 2.0;

/// The greatest ratio of a derivative, over the width of a gap, to the chords beside it.
const LONGEST: f64 = 1.5;

/// An edge is long if others are shorter than this part of it.
const SHORT: f64 = 0.25;

/// Bends turn from an edge to the next by less than the angle with this cosine, 20 degrees.
const COSINE: f64 = 0.94;

/// The largest roots of the Euler–Frobenius polynomials of degrees 1, 2, …; further ones count as the last of these.
const DECAYS: [f64; 9] = [0.0, 0.172, 0.268, 0.361, 0.431, 0.488, 0.535, 0.575, 0.608];

/// The part of a bend that polynomials pass on.
const DECAY_OF_POLYNOMIALS: f64 = 0.5;

/// The part of a bend that a direction passes on to the next gap.
fn decay(direction: &Direction) -> f64 {
    match &direction.basis {
        Basis::BSpline { degree, .. } => {
            let last = DECAYS[DECAYS.len() - 1];
            DECAYS.get(degree - 1).copied().unwrap_or(last)
        }
        Basis::Polynomial { .. } => DECAY_OF_POLYNOMIALS,
    }
}

/// The freedom of a gap, or of a cell of a grid, with a bend.
pub(super) fn of_bend(bend: f64) -> f64 {
    FACTOR * bend
}

/// The part of its freedom that the edge from b to c should have at most, beside the edge from a to b: long edges that
/// densely sampled bends lead to are straight.
pub(crate) fn part_beside(points: &Points, [a, b, c]: [usize; 3]) -> f64 {
    let (short, long) = (points.distance(a, b), points.distance(b, c));
    let pairs = points.point(a).zip(points.point(b)).zip(points.point(c));
    let along: f64 = pairs
        .map(|((a, b), c)| (b - a) / short * ((c - b) / long))
        .sum();
    match along > COSINE {
        true => (short / long / SHORT).powi(2).min(1.0),
        false => 1.0,
    }
}

/// Passes values of the gaps of a curve, or of the cells of a grid with this number of columns, on to those beside them.
pub(super) fn pass_on(values: &mut [f64], columns: usize, u: &Direction, v: Option<&Direction>) {
    if let Some(v) = v {
        values
            .chunks_mut(columns)
            .for_each(|row| pass_on_along(row, (0, 1), v));
    }
    for column in 0..columns {
        pass_on_along(values, (column, columns), u);
    }
}

/// The same along a line of gaps, from a start index in steps.
fn pass_on_along(values: &mut [f64], (start, step): (usize, usize), direction: &Direction) {
    let decay = decay(direction);
    let places = || (start..values.len()).step_by(step);
    // Closed lines are gone around twice.
    let turns = if direction.is_closed() { 2 } else { 1 };
    let forwards: Vec<usize> = (0..turns).flat_map(|_| places()).collect();
    let mut pass = |places: &mut dyn Iterator<Item = usize>| {
        places.fold(0.0, |before: f64, place| {
            let value = values[place].max(decay * before);
            values[place] = value;
            value
        });
    };
    pass(&mut forwards.iter().copied());
    pass(&mut forwards.iter().rev().copied());
}

/// The bend of each gap between successive points of a line, which have these parameters; of a closed line also of the
/// gap between the last point and the first.
///
/// `indices` are those of the points of the line, and `parameters` have one value more than a closed line has points.
pub(super) fn bends(points: &Points, indices: &[usize], parameters: &[f64]) -> Vec<f64> {
    let (gaps, dimension) = (parameters.len() - 1, points.dimension());
    let is_closed = gaps == indices.len();
    let width = |gap: usize| parameters[gap + 1] - parameters[gap];
    let chord = |gap: usize, c: usize| {
        let lane = points.lane(c);
        let (from, to) = (indices[gap], indices[(gap + 1) % indices.len()]);
        (lane[to] - lane[from]) / width(gap)
    };
    let lengths: Vec<f64> = (0..gaps)
        .map(|gap| width(gap) * length_of((0..dimension).map(|c| chord(gap, c))))
        .collect();
    // The derivative of a gap at the point between it and another one beside it.
    let inside = |gap: usize, beside: usize| {
        let (h, k) = (width(gap), width(beside));
        let share = k / (h + k);
        let derivative: Vec<f64> = (0..dimension)
            .map(|c| share * chord(gap, c) + (1.0 - share) * chord(beside, c))
            .collect();
        limited(derivative, LONGEST * lengths[gap].max(lengths[beside]) / h)
    };
    // That at an end, where the derivative at the other side of the gap is known.
    let at_end = |gap: usize, other: &[f64]| {
        let derivative = (0..dimension).map(|c| 2.0 * chord(gap, c) - other[c]);
        derivative.collect::<Vec<f64>>()
    };
    if gaps < 2 {
        return vec![0.0; gaps];
    }
    let bend = |gap: usize| {
        let is_first = gap == 0 && !is_closed;
        let is_last = gap + 1 == gaps && !is_closed;
        let before = || inside(gap, (gap + gaps - 1) % gaps);
        let after = || inside(gap, (gap + 1) % gaps);
        let (start, end) = match (is_first, is_last) {
            (true, _) => (at_end(gap, &after()), after()),
            (_, true) => (before(), at_end(gap, &before())),
            _ => (before(), after()),
        };
        let farther = |most: f64, s: f64| {
            let parts = (0..dimension).map(|c| {
                let chord = chord(gap, c);
                (1.0 - s) * (start[c] - chord) - s * (end[c] - chord)
            });
            let part = s * (1.0 - s);
            match is_surely_shorter(parts.clone(), most / part) {
                true => most,
                false => most.max(part * length_of(parts)),
            }
        };
        // The middle first, which is farthest in most gaps.
        let most = [0.5, 0.25, 0.75].into_iter().fold(0.0, farther);
        let factor = if is_first || is_last {
            FACTOR_OF_ENDS
        } else {
            1.0
        };
        factor * width(gap) * most
    };
    (0..gaps).map(bend).collect()
}

/// The length of a vector.
pub(crate) fn length(vector: &[f64]) -> f64 {
    length_of(vector.iter().copied())
}

/// The length of a vector with these coordinates.
pub(crate) fn length_of(mut coordinates: impl Iterator<Item = f64>) -> f64 {
    let first = coordinates.next().map_or(0.0, f64::abs);
    coordinates.fold(first, f64::hypot)
}

/// Squares that are below this part of another one are so in spite of their rounding errors.
const SURELY_LESS: f64 = 1.0 - 1e-12;

/// Returns true if a vector with these coordinates is certainly shorter than that, by their squares: slow square roots
/// are not needed then.
pub(crate) fn is_surely_shorter(coordinates: impl Iterator<Item = f64>, than: f64) -> bool {
    let square = than * than;
    square.is_normal() && coordinates.map(|x| x * x).sum::<f64>() < SURELY_LESS * square
}

/// The same vector, but no longer than this.
pub(crate) fn limited(mut vector: Vec<f64>, longest: f64) -> Vec<f64> {
    if is_surely_shorter(vector.iter().copied(), longest) {
        return vector;
    }
    let length = length(&vector);
    if length > longest {
        vector.iter_mut().for_each(|x| *x *= longest / length);
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a parabola at equal steps bend by an eighth of the second difference, twice as much at its ends, and
    /// points of a line not at all.
    #[test]
    fn bends_are_those_of_parabolas() {
        let t: Vec<f64> = (0..7).map(f64::from).collect();
        let all: Vec<usize> = (0..7).collect();
        let parabola =
            Points::from_lanes([t.iter().map(|x| (x - 3.0) * (x - 3.0)).collect::<Vec<_>>()]);
        let line = Points::from_lanes([
            t.iter().map(|x| 2.0 * x - 5.0).collect::<Vec<_>>(),
            t.clone(),
        ]);
        for bend in bends(&line, &all, &t) {
            assert!(bend < 1e-15, "{bend}");
        }
        let bends = bends(&parabola, &all, &t);
        for (gap, bend) in bends.iter().enumerate() {
            let is_end = [0, 5].contains(&gap);
            let expected = if is_end { 2.0 * 0.25 } else { 0.25 };
            assert!((bend - expected).abs() < 1e-15, "{gap}: {bend}");
        }
    }
}
