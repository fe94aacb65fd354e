//! Least squares of scattered points, by conjugate gradients from a surface near them.
//!
//! Conjugate gradients of the normal equations of each coordinate, preconditioned with the diagonal D = 1 / column sums of A, as in
//! [`crate::knot_selection::steps`]. Control points that no datum sees stay where they are, and what
//! the data hardly say is followed last: in gaps of the data the surface keeps the shape that it had
//! with fewer knots. The normal equations of scattered data can be singular, and a factorization of
//! them would leave large control points there.

use super::normal::{Normal, Preconditioner};
use super::rows::Rows;
use crate::interrupt;
use crate::linear::conjugate::Conjugate;
use crate::linear::vectors::{add, dot};

/// The number of steps, each lowering the sum of squares by less than the gain of the [`Effort`], that ends
/// the descent.
const WINDOW: usize = 10;

/// A value that has fallen below this part of what it was computed from is computed again.
const TRUST: f64 = 1e-10;

/// A gradient whose square has fallen to this part of the largest is rounding.
const ROUNDING: f64 = 1e-28;

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
    pub(super) fn whole(rows: &Rows) -> Self {
        let steps = WORK / (2 * rows.numbers()).max(1);
        Self {
            steps: steps.min(ROUNDS * rows.control_points()),
            gain: 0.0,
        }
    }
}

/// Moves one coordinate of the control points towards the least of the sum of squares of `data`, multiplied with `unit`,
/// and of the energy, until the root of the mean square is at most `enough` or the effort is spent. Where there is an
/// energy, no distance is enough.
pub(super) fn descend(
    (normal, preconditioner, effort): (&Normal<'_>, &Preconditioner, Effort),
    data: &[f64],
    x: &mut [f64],
    unit: f64,
    enough: f64,
) {
    let small = match normal.has_energy() {
        true => 0.0,
        false => (enough * unit).powi(2) * data.len() as f64,
    };
    let (mut residual, mut gradient) = (vec![0.0; data.len()], vec![0.0; x.len()]);
    let mut value = normal.start((x, data, unit), &mut residual, &mut gradient);
    let (mut computed, mut before) = (value, value);
    let (mut conditioned, mut product) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    let (mut direction, mut first) = (vec![0.0; x.len()], 0.0);
    let mut conjugate = Conjugate::default();
    for step in 1..=effort.steps {
        interrupt::check();
        if value <= TRUST * computed {
            // What is left is the rounding of the values before.
            value = normal.start((x, data, unit), &mut residual, &mut gradient);
            computed = value;
        }
        if value <= small {
            return;
        }
        preconditioner.apply(&gradient, &mut conditioned);
        let gamma = dot(&gradient, &conditioned);
        first = f64::max(first, gamma);
        if gamma <= ROUNDING * first {
            return;
        }
        conjugate.turn_to(&mut direction, conditioned.iter().copied(), gamma);
        normal.apply(&direction, &mut product, &mut residual);
        let curvature = dot(&direction, &product);
        let Some(alpha) = conjugate
            .length(curvature)
            .filter(|_| curvature.is_finite())
        else {
            return;
        };
        add(x, alpha / unit, &direction);
        add(&mut gradient, -alpha, &product);
        value -= alpha * gamma;
        if step % WINDOW == 0 {
            if before - value <= effort.gain * before {
                return;
            }
            before = value;
        }
    }
}

/// How much one step of steepest descent lowers the sum of squares of a residual.
pub(super) fn first_gain(rows: &Rows, diagonal: &[f64], residual: &[f64]) -> f64 {
    let mut gradient = vec![0.0; diagonal.len()];
    rows.apply_transposed(residual, &mut gradient);
    let gamma = weighed_square(&gradient, diagonal);
    let pairs = gradient.iter_mut().zip(diagonal);
    pairs.for_each(|(g, d)| *g *= d);
    let mut image = vec![0.0; residual.len()];
    rows.apply(&gradient, &mut image);
    let curvature = dot(&image, &image);
    if curvature > 0.0 {
        gamma * (gamma / curvature)
    } else {
        0.0
    }
}

/// `gᵀ D g`.
fn weighed_square(gradient: &[f64], diagonal: &[f64]) -> f64 {
    let pairs = gradient.iter().zip(diagonal);
    pairs.map(|(g, d)| g * d * g).sum()
}
