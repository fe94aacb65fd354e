//! Parameters of data points.
//!
//! ```text
//! uniform        t_i = i / n
//! chord length   t_i = t_{i−1} + ‖P_i − P_{i−1}‖
//! centripetal    t_i = t_{i−1} + ‖P_i − P_{i−1}‖^(1/2)        (Lee 1989)
//! ```
//!
//! from t_0 = 0 on. On surfaces the steps of a direction are means over all lines of the other one (LWD04 (12)–(13)).
//! Closed curves have one step more, from the last point back to the first, whose end is the *period*. Chord lengths
//! are in data units; polynomial bases scale them to [0, 1], and B-splines do not depend on the scale.

pub(crate) mod scattered;

use std::sync::Arc;

use rayon::prelude::*;

use super::invalid::{Axis, Invalid, Place};
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::monotonic;
use crate::data::points::Points;

pub use scattered::{
    CoordinatePlane, Cylinder, Domain, FoldedTriangles, MAX_TRIANGLES, Mesh, MeshUnfolding, Pairs,
    Scattered, Sections, Sphere, is_stack, pieces,
};

/// The largest absolute value of a knot or parameter: sums of a few larger ones could overflow.
pub(crate) const LARGEST: f64 = 1e300;

/// How the parameters of one direction are chosen.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Parametrization {
    /// `t_i = i / n`.
    Uniform,
    /// Steps are the distances of successive points, in data units; on surfaces their mean over all
    /// lines of the other direction (LWD04 (12)–(13)).
    ChordLength,
    /// Steps are square roots of the distances (Lee 1989), averaged in the same way.
    Centripetal,
    /// Given values, strictly increasing.
    Explicit(Arc<Vec<f64>>),
}

impl Parametrization {
    /// The default for a surface through these points: distances of heights, points of one coordinate, do not determine
    /// where on the surface they lie.
    pub fn usual_of_surface(points: &Points) -> Self {
        match points.dimension() {
            1 => Self::Uniform,
            _ => Self::ChordLength,
        }
    }
}

/// Parameters of data points.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub struct Parametrized {
    /// One for each data point, finite and strictly increasing.
    pub values: Arc<Vec<f64>>,
    /// The parameter distance after which a closed curve is back at its first point; for an open one the length of its
    /// range.
    pub period: f64,
}

/// The parameters of the points of `grid` in direction `axis`: one for each line across it. On
/// closed curves the last step leads back to the first point. Steps between points of which one is
/// `missing` do not count.
///
/// # Errors
///
/// Fails with the points that are equal or too close to be distinct, the first explicit value that does not increase,
/// or the wrong number of explicit values.
#[doc(hidden)]
pub fn parameters(
    choice: Parametrization,
    points: &Points,
    grid: Grid,
    missing: Option<&Missing>,
    axis: Axis,
    closed: bool,
) -> Result<Parametrized, Invalid> {
    let count = grid.along(axis);
    let steps = if closed { count } else { count - 1 };
    let all = match choice {
        Parametrization::Uniform => {
            Arc::new((0..=steps).map(|i| i as f64 / steps as f64).collect())
        }
        Parametrization::ChordLength => {
            by_distance(points, grid, missing, axis, steps, "chord-length", |d| d)?
        }
        Parametrization::Centripetal => {
            by_distance(points, grid, missing, axis, steps, "centripetal", f64::sqrt)?
        }
        Parametrization::Explicit(values) => explicit(values, steps + 1, closed, axis)?,
    };
    let period = all[steps] - all[0];
    let mut values = all;
    if closed {
        Arc::make_mut(&mut values).truncate(count);
    }
    Ok(Parametrized { values, period })
}

/// Parameters whose steps are a function `step` of the distances of successive points: its mean
/// over the lines of the other direction. There are `steps` of them; `rule` is the name that errors
/// give.
fn by_distance(
    points: &Points,
    grid: Grid,
    missing: Option<&Missing>,
    axis: Axis,
    steps: usize,
    rule: &'static str,
    step: impl Fn(f64) -> f64 + Sync,
) -> Result<Arc<Vec<f64>>, Invalid> {
    let count = grid.along(axis);
    let mut sums = Sums {
        points,
        missing,
        step,
        // To be summed up from the start.
        totals: vec![0.0; steps + 1],
        pairs: vec![0; if missing.is_some() { steps + 1 } else { 0 }],
    };
    let lines = grid.count() / count;
    if axis == Axis::V || grid.columns == 1 {
        // Lines along the direction are contiguous.
        for start in (0..grid.count()).step_by(count) {
            sums.add_line(start, count);
            if steps == count {
                sums.add_pairs(start + count - 1, start, 1, |_| steps);
            }
        }
    } else {
        for k in 1..=steps {
            sums.add_pairs((k - 1) * lines, k % count * lines, lines, |_| k);
        }
    }
    let Sums {
        mut totals, pairs, ..
    } = sums;
    for (total, &pairs) in totals.iter_mut().zip(&pairs).skip(1) {
        *total /= f64::from(pairs);
    }
    let all = if pairs.is_empty() { lines as f64 } else { 1.0 };
    let mut last = 0.0;
    for t in &mut totals[1..] {
        last += *t / all;
        *t = last;
    }
    // Looked at afterwards, side by side: each sum waits for the one before.
    if monotonic::increases(&totals) && last.is_finite() {
        return Ok(Arc::new(totals));
    }
    Err(not_increasing(&totals, &pairs, grid, axis, rule))
}

/// The most steps without length that are named.
const MOST_NAMED: usize = 100;

/// The validation errors of parameters by distance that do not increase, at each step that has no length: `pairs` is
/// the number of distances in the mean of each step, if points are missing.
fn not_increasing(
    parameters: &[f64],
    pairs: &[u32],
    grid: Grid,
    axis: Axis,
    rule: &'static str,
) -> Invalid {
    let (t, count) = (parameters, grid.along(axis));
    // From an infinite one on there is nothing to compare.
    let finite = t.iter().position(|t| !t.is_finite()).unwrap_or(t.len());
    let lost = (finite < t.len()).then_some(finite);
    let unknown = lost.filter(|&k| pairs.get(k) == Some(&0));
    let equal = (1..finite).filter(|&k| t[k] <= t[k - 1]);
    let wrong = equal.take(MOST_NAMED).chain(unknown).map(|k| {
        let index = k % count;
        if pairs.get(k) == Some(&0) {
            // The neighbour of the last line of a closed surface is the first one.
            let previous = k - 1;
            Invalid::at(
                Place::Line(axis, index),
                format!(
                    "no two neighbours of lines {previous} and {index} are given, so that {rule} parameters are unknown: use uniform or explicit parameters"
                ),
            )
        } else if k == count {
            let index = count - 1;
            Invalid::at(
                Place::Line(axis, index),
                "the last point equals the first: a closed curve returns to its first point by itself, leave the last one out",
            )
        } else if grid.columns == 1 {
            Invalid::at(
                Place::Line(axis, index),
                format!(
                    "point {index} equals point {previous} (or is too close to it), so that {rule} parameters do not increase: drop one of them, or let equal points be merged (repeated_points), or use uniform or explicit parameters",
                    previous = index - 1
                ),
            )
        } else {
            Invalid::at(
                Place::Line(axis, index),
                format!(
                    "all points of line {index} equal those of line {previous} (or are too close to them), so that {rule} parameters do not increase: drop one of the lines or use uniform or explicit parameters",
                    previous = index - 1
                ),
            )
        }
    });
    match lost.xor(unknown) {
        Some(_) => Invalid::too_large(),
        None => Invalid::of_all(wrong).unwrap_or_else(Invalid::too_large),
    }
}

/// The number of distances that are computed at a time.
const BLOCK: usize = 256;

/// The distances of shorter lines are computed by one thread.
const PARALLEL: usize = 100_000;

/// Sums over all lines of the steps that lead to each point of a line.
struct Sums<'a, F> {
    points: &'a Points,
    missing: Option<&'a Missing>,
    /// The step for a distance.
    step: F,
    /// The sum for each point of a line; that for the first one stays zero.
    totals: Vec<f64>,
    /// The number of distances added to each sum, if points are missing.
    pairs: Vec<u32>,
}

impl<F: Fn(f64) -> f64 + Sync> Sums<'_, F> {
    /// Adds the steps between the successive points of a line, the `count` points from `start` on.
    fn add_line(&mut self, start: usize, count: usize) {
        let Self { points, step, .. } = self;
        if self.missing.is_some() || count < PARALLEL {
            return self.add_pairs(start, start + 1, count - 1, |i| i + 1);
        }
        let totals = self.totals[1..count].par_chunks_mut(BLOCK).enumerate();
        totals.for_each(|(block, totals)| {
            let mut buffer = [0.0; BLOCK];
            let distances = &mut buffer[..totals.len()];
            let first = start + block * BLOCK;
            points.distances(first, first + 1, distances);
            let totals = totals.iter_mut().zip(distances);
            totals.for_each(|(total, distance)| *total += step(*distance));
        });
    }

    /// Adds the steps between points `from + i` and `to + i` for i below `count`, to the sums
    /// `step_of(i)`.
    fn add_pairs(
        &mut self,
        from: usize,
        to: usize,
        count: usize,
        step_of: impl Fn(usize) -> usize,
    ) {
        let mut buffer = [0.0; BLOCK];
        for first in (0..count).step_by(BLOCK) {
            let distances = &mut buffer[..BLOCK.min(count - first)];
            self.points.distances(from + first, to + first, distances);
            for (i, &distance) in (first..).zip(&*distances) {
                self.add(step_of(i), from + i, to + i, distance);
            }
        }
    }

    /// Adds the step for a distance between two points to sum k, unless one of them is missing.
    fn add(&mut self, k: usize, from: usize, to: usize, distance: f64) {
        if let Some(missing) = self.missing {
            if missing.contains(from) || missing.contains(to) {
                return;
            }
            self.pairs[k] += 1;
        }
        self.totals[k] += (self.step)(distance);
    }
}

/// Given parameters, if there are `expected` of them, and they are finite and strictly increase.
fn explicit(
    values: Arc<Vec<f64>>,
    expected: usize,
    closed: bool,
    axis: Axis,
) -> Result<Arc<Vec<f64>>, Invalid> {
    if values.len() != expected {
        let given = values.len();
        return Err(if closed {
            Invalid::at(
                Place::Parameters(axis),
                format!(
                    "{given} parameters given, {expected} needed: one for each point, and the one at which the closed curve is back at the first"
                ),
            )
        } else {
            Invalid::parameter_count(axis, given, expected)
        });
    }
    let ends = values.first().into_iter().chain(values.last());
    if monotonic::increases(&values) && ends.into_iter().all(|end| end.is_finite()) {
        return Ok(values);
    }
    for (index, &value) in values.iter().enumerate() {
        if !value.is_finite() {
            return Err(Invalid::parameter_not_finite(axis, index, value));
        }
        if index > 0 && value <= values[index - 1] {
            let previous = values[index - 1];
            return Err(Invalid::at(
                Place::Parameter(axis, index),
                format!(
                    "parameter {index} is {value}, not greater than the one before, {previous}: parameters must strictly increase"
                ),
            ));
        }
    }
    Ok(values)
}

/// Maps increasing parameters affinely so that they start at `low` and end at `high`, exactly.
///
/// # Errors
///
/// [`Invalid::ParameterRange`] if neighbours fall together by rounding, or the range overflows.
pub(super) fn rescale(t: &mut [f64], low: f64, high: f64, axis: Axis) -> Result<(), Invalid> {
    let (Some(&first), Some(&last)) = (t.first(), t.last()) else {
        return Ok(());
    };
    let length = last - first;
    for x in t.iter_mut() {
        *x = low + (high - low) * ((*x - first) / length);
    }
    if let Some(end) = t.last_mut() {
        *end = high;
    }
    // Neighbours may fall together when they differ by less than the rounding of the new range.
    if length.is_finite() && monotonic::increases(t) {
        Ok(())
    } else {
        Err(Invalid::parameter_range(axis))
    }
}

#[cfg(test)]
mod tests;
