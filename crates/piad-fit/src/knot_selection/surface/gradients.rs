//! Least squares of scattered points, by conjugate gradients from a surface near them.
//!
//! CGLS of each coordinate, preconditioned with the diagonal D = 1 / column sums of A, as in
//! [`crate::knot_selection::steps`]. Control points that no datum sees stay where they are, and what
//! the data hardly say is followed last: in gaps of the data the surface keeps the shape that it had
//! with fewer knots. The normal equations of scattered data can be singular, and a factorization of
//! them would leave large control points there.

use super::rows::Rows;
use crate::interrupt;

/// The number of steps, each lowering the sum of squares by less than the gain of the [`Effort`], that ends
/// the descent.
const WINDOW: usize = 10;

/// The most multiplications of a descent that does not give up.
const WORK: usize = 1_000_000_000;

/// Without rounding there are as many steps as control points; with it, up to this number of times as many.
const ROUNDS: usize = 50;

/// When a descent gives up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// The most steps.
    steps: usize,
    /// The least part of the sum of squares that a few steps lower it by.
    gain: f64,
}

impl Effort {
    /// As long as it is worth it: what is left are gaps of the data, mostly.
    pub(super) const USUAL: Self = Self {
        steps: 200,
        gain: 1e-3,
    };

    /// As long as there may be something to gain.
    pub(super) fn whole(rows: &Rows<'_>) -> Self {
        let steps = WORK / rows.multiplications().max(1);
        Self {
            steps: steps.min(ROUNDS * rows.control_points()),
            gain: 0.0,
        }
    }
}

/// The diagonal D; zero where there are no data.
pub(super) fn diagonal(rows: &Rows<'_>) -> Vec<f64> {
    let mut sums = vec![0.0; rows.control_points()];
    rows.apply_transposed(&vec![1.0; rows.points()], &mut sums);
    let inverse = |sum: f64| if sum > 0.0 { 1.0 / sum } else { 0.0 };
    sums.into_iter().map(inverse).collect()
}

/// Moves one coordinate of the control points towards the least-squares fit of `data`, multiplied
/// with `unit`, until the root of the mean square is at most `enough` or the effort is spent.
pub(super) fn descend(
    (rows, effort): (&Rows<'_>, Effort),
    diagonal: &[f64],
    data: &[f64],
    x: &mut [f64],
    unit: f64,
    enough: f64,
) {
    let mut residual = vec![0.0; data.len()];
    rows.apply(x, &mut residual);
    let pairs = residual.iter_mut().zip(data);
    pairs.for_each(|(r, datum)| *r = (datum - *r) * unit);
    let small = (enough * unit).powi(2) * data.len() as f64;
    let mut square = sum_of_squares(&residual);
    let mut before = square;
    let (mut gradient, mut image) = (vec![0.0; x.len()], vec![0.0; data.len()]);
    let (mut direction, mut last) = (vec![0.0; x.len()], 0.0);
    for step in 1..=effort.steps {
        interrupt::check();
        if square <= small {
            return;
        }
        rows.apply_transposed(&residual, &mut gradient);
        let gamma = weighed_square(&gradient, diagonal);
        let beta = if last > 0.0 { gamma / last } else { 0.0 };
        last = gamma;
        for ((direction, g), d) in direction.iter_mut().zip(&gradient).zip(diagonal) {
            *direction = d * g + beta * *direction;
        }
        rows.apply(&direction, &mut image);
        let curvature = sum_of_squares(&image);
        if curvature <= 0.0 || !curvature.is_finite() {
            return;
        }
        let alpha = gamma / curvature;
        let pairs = x.iter_mut().zip(&direction);
        pairs.for_each(|(x, d)| *x += alpha / unit * d);
        let pairs = residual.iter_mut().zip(&image);
        pairs.for_each(|(r, q)| *r -= alpha * q);
        square = sum_of_squares(&residual);
        if step % WINDOW == 0 {
            if before - square <= effort.gain * before {
                return;
            }
            before = square;
        }
    }
}

/// How much one step of steepest descent lowers the sum of squares of a residual.
pub(super) fn first_gain(rows: &Rows<'_>, diagonal: &[f64], residual: &[f64]) -> f64 {
    let mut gradient = vec![0.0; diagonal.len()];
    rows.apply_transposed(residual, &mut gradient);
    let gamma = weighed_square(&gradient, diagonal);
    let pairs = gradient.iter_mut().zip(diagonal);
    pairs.for_each(|(g, d)| *g *= d);
    let mut image = vec![0.0; residual.len()];
    rows.apply(&gradient, &mut image);
    let curvature = sum_of_squares(&image);
    if curvature > 0.0 {
        gamma * (gamma / curvature)
    } else {
        0.0
    }
}

fn sum_of_squares(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// `gᵀ D g`.
fn weighed_square(gradient: &[f64], diagonal: &[f64]) -> f64 {
    let pairs = gradient.iter().zip(diagonal);
    pairs.map(|(g, d)| g * d * g).sum()
}
