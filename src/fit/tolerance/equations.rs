//! Least squares over given knots: what the schedule asks for, and knows nothing more about.
//!
//! ```text
//! min Σ_i w_i ‖P_i − C(t_i)‖²,   C(t_0) = P_0 and C(t_n) = P_n on open curves
//! ```
//!
//! The first and the last control point of an open curve are its ends, so these constraints take
//! two unknowns away and the normal equations stay banded and positive definite. Everything is
//! computed relative to the segment between the ends: `X = X⁰ + (AᵀWA)⁻¹ AᵀW (P − A X⁰)`, so that
//! data far from the origin lose no digits.

use std::sync::Arc;

use super::gram::Gram;
use super::line::KnotLine;
use super::values::Values;
use crate::fit::points::{Points, normalizing_scale};

/// A minimum over some knots. What else it has to obey or to weigh, as constraints or fairness, is
/// the business of an implementation: the schedule only compares distances.
pub(crate) trait Minimum {
    /// The control points that are nearest to the data by the sum of squared distances, each
    /// multiplied with its weight, or `None` if the data do not determine them.
    fn minimum(&self, line: &KnotLine, values: &Values, weights: Option<&[f64]>) -> Option<Points>;
}

/// Least squares of a curve with interpolated ends.
#[derive(Clone, Debug)]
pub(crate) struct LeastSquares {
    /// The data.
    pub points: Arc<Points>,
    /// How much each datum counts, without it all alike.
    pub data_weights: Option<Arc<Vec<f64>>>,
}

impl Minimum for LeastSquares {
    fn minimum(&self, line: &KnotLine, values: &Values, weights: Option<&[f64]>) -> Option<Points> {
        let product: Vec<f64>;
        let weights = match (weights, self.data_weights.as_deref()) {
            (Some(weights), Some(own)) => {
                product = weights.iter().zip(own).map(|(a, b)| a * b).collect();
                Some(&product[..])
            }
            (given, own) => given.or(own.map(Vec::as_slice)),
        };
        let factor = gram(line, values, weights).factor()?;
        let mut control_points = start(line, &self.points);
        // Where there are few data for each control point, rounding matters: one step of refinement.
        let steps = 1 + usize::from(2 * line.control_points() > self.points.len());
        let fixed = fixed_ends(line);
        let count = line.control_points();
        let (mut right, mut fit) = (vec![0.0; count], vec![0.0; self.points.len()]);
        for (x, data) in control_points
            .lanes_mut()
            .iter_mut()
            .zip(self.points.lanes())
        {
            for _ in 0..steps {
                values.apply(line, x, &mut fit);
                residual(&mut fit, data, weights);
                values.apply_transposed(line, &fit, &mut right);
                factor.solve(&mut right[fixed..count - fixed]);
                let moved = x[fixed..count - fixed].iter_mut();
                moved.zip(&right[fixed..]).for_each(|(x, step)| *x += step);
            }
            if !x.iter().all(|x| x.is_finite()) {
                return None;
            }
        }
        Some(control_points)
    }
}

/// How many control points are fixed at each end.
pub(super) fn fixed_ends(line: &KnotLine) -> usize {
    usize::from(!line.is_closed())
}

/// `fit ← w (data − fit)`.
fn residual(fit: &mut [f64], data: &[f64], weights: Option<&[f64]>) {
    fit.iter_mut()
        .zip(data)
        .for_each(|(fit, data)| *fit = data - *fit);
    if let Some(weights) = weights {
        fit.iter_mut().zip(weights).for_each(|(fit, w)| *fit *= w);
    }
}

/// `AᵀWA` of the control points that move.
fn gram(line: &KnotLine, values: &Values, weights: Option<&[f64]>) -> Gram {
    match values.width() {
        3 => gram_of_width::<3>(line, values, weights),
        4 => gram_of_width::<4>(line, values, weights),
        5 => gram_of_width::<5>(line, values, weights),
        6 => gram_of_width::<6>(line, values, weights),
        _ => gram_of_any_width(line, values, weights),
    }
}

/// The same, with the sums of a span in registers.
fn gram_of_width<const W: usize>(
    line: &KnotLine,
    values: &Values,
    weights: Option<&[f64]>,
) -> Gram {
    let mut gram = empty(line);
    for (span, range, rows) in values.spans() {
        let mut sums = [[0.0; W]; W];
        let (rows, _) = rows.as_chunks::<W>();
        for (row, i) in rows.iter().zip(range) {
            let w = weights.map_or(1.0, |weights| weights[i]);
            for a in 0..W {
                let value = w * row[a];
                for b in 0..=a {
                    sums[a][b] += value * row[b];
                }
            }
        }
        add_span(line, &mut gram, span, W, |a, b| sums[a][b]);
    }
    gram
}

/// The same for every degree.
fn gram_of_any_width(line: &KnotLine, values: &Values, weights: Option<&[f64]>) -> Gram {
    let width = values.width();
    let mut gram = empty(line);
    let mut sums = vec![0.0; width * width];
    for (span, range, rows) in values.spans() {
        sums.fill(0.0);
        for (row, i) in rows.chunks_exact(width).zip(range) {
            let w = weights.map_or(1.0, |weights| weights[i]);
            for (a, sums) in sums.chunks_exact_mut(width).enumerate() {
                let value = w * row[a];
                sums[..=a]
                    .iter_mut()
                    .zip(row)
                    .for_each(|(sum, b)| *sum += value * b);
            }
        }
        add_span(line, &mut gram, span, width, |a, b| sums[a * width + b]);
    }
    gram
}

/// No equations yet.
fn empty(line: &KnotLine) -> Gram {
    let count = line.control_points() - 2 * fixed_ends(line);
    Gram::new(count, line.degree(), line.is_closed())
}

/// Adds the products of the functions of a span, but those of fixed control points.
fn add_span(
    line: &KnotLine,
    gram: &mut Gram,
    span: usize,
    width: usize,
    sum: impl Fn(usize, usize) -> f64,
) {
    let (fixed, count) = (fixed_ends(line), line.control_points());
    let place = |k: usize| {
        let j = line.control_point(span + k);
        (fixed..count - fixed).contains(&j).then(|| j - fixed)
    };
    for a in 0..width {
        for b in 0..=a {
            if let (Some(i), Some(j)) = (place(a), place(b)) {
                gram.add(i, j, sum(a, b));
            }
        }
    }
}

/// The control points of the segment from the first datum to the last one, at the speed of the
/// parameters; of a closed curve the first datum.
pub(super) fn start(line: &KnotLine, points: &Points) -> Points {
    let count = line.control_points();
    let breaks = line.breaks();
    let (low, high) = (breaks[0], breaks[line.spans()]);
    let last = points.len() - 1;
    let greville = |j: usize| {
        let knots = 1..=line.degree();
        let mean = knots
            .map(|k| (line.knot((j + k) as isize) - low) / (high - low))
            .sum::<f64>()
            / line.degree() as f64;
        // At the ends exactly.
        match j {
            0 => 0.0,
            _ if j + 1 == count => 1.0,
            _ => mean,
        }
    };
    Points::from_lanes(points.lanes().iter().map(|lane| {
        let at = |j: usize| match line.is_closed() {
            true => lane[0],
            false => {
                let s = greville(j);
                (1.0 - s) * lane[0] + s * lane[last]
            }
        };
        (0..count).map(at).collect::<Vec<f64>>()
    }))
}

/// How far a curve is from the data.
#[derive(Clone, Debug)]
pub(crate) struct Distances {
    /// `‖P_i − C(t_i)‖`.
    pub each: Vec<f64>,
    /// The largest.
    pub max: f64,
    /// The root of the mean of the squared ones.
    pub rms: f64,
}

impl Distances {
    /// Of the curve of some control points.
    pub(crate) fn new(
        line: &KnotLine,
        values: &Values,
        control_points: &Points,
        points: &Points,
    ) -> Self {
        let count = points.len();
        let unit = normalizing_scale(points.magnitude());
        let mut each = vec![0.0; count];
        let mut fit = vec![0.0; count];
        for (x, data) in control_points.lanes().iter().zip(points.lanes()) {
            values.apply(line, x, &mut fit);
            for ((sum, fit), data) in each.iter_mut().zip(&fit).zip(&**data) {
                let distance = (data - fit) * unit;
                *sum += distance * distance;
            }
        }
        Self::of_squares(each, unit)
    }

    /// Of squares of distances that are scaled by `unit`.
    pub(super) fn of_squares(mut each: Vec<f64>, unit: f64) -> Self {
        let sum: f64 = each.iter().sum();
        let rms = (sum / each.len() as f64).sqrt() / unit;
        each.iter_mut()
            .for_each(|square| *square = square.sqrt() / unit);
        let larger = |most: f64, &distance: &f64| match distance {
            _ if distance.is_nan() || most.is_nan() => f64::NAN,
            _ => most.max(distance),
        };
        let max = each.iter().fold(0.0, larger);
        Self { each, max, rms }
    }
}
