//! One coordinate of some rows of a curve: `Δ = P − B X`, its squares and the next level, in one loop
//! wherever the rows lie in one stretch of B.

use std::array::from_fn;
use std::ops::Range;

use super::relaxation::Coefficients;
use crate::fit::blocks::BLOCK;
use crate::fit::linear::banded::Banded;

/// What is read and written: arrays with a number for each row, but for `x`.
pub struct Lane<'a> {
    /// The columns of X that the rows need, from column `base` on.
    pub x: &'a [f64],
    /// The first column that is there.
    pub base: i64,
    /// P.
    pub data: &'a [f64],
    /// X at the rows themselves.
    pub own: &'a [f64],
    /// X'.
    pub next: &'a mut [f64],
    /// The last step, and then this one; empty without momentum.
    pub step: &'a mut [f64],
    /// Gets the squares of the scaled residuals added.
    pub squares: &'a mut [f64],
}

/// Computes a lane of at most a block of rows.
#[inline(always)]
pub fn relax(
    u: &Banded,
    rows: Range<usize>,
    coefficients: Coefficients,
    scale: f64,
    lane: Lane<'_>,
) {
    match u.width() {
        2 => relax_width::<2>(u, rows, coefficients, scale, lane),
        3 => relax_width::<3>(u, rows, coefficients, scale, lane),
        4 => relax_width::<4>(u, rows, coefficients, scale, lane),
        5 => relax_width::<5>(u, rows, coefficients, scale, lane),
        6 => relax_width::<6>(u, rows, coefficients, scale, lane),
        _ => one_by_one(u, rows, coefficients, scale, lane),
    }
}

#[inline(always)]
fn relax_width<const W: usize>(
    u: &Banded,
    rows: Range<usize>,
    coefficients: Coefficients,
    scale: f64,
    lane: Lane<'_>,
) {
    let Some((b, columns)) = u.stretch::<W>(rows.clone(), lane.x, lane.base) else {
        return one_by_one(u, rows, coefficients, scale, lane);
    };
    let rows = Rows { b, columns };
    let Lane {
        data,
        own,
        next,
        step,
        squares,
        ..
    } = lane;
    if step.is_empty() {
        rows.relax(coefficients.gain, scale, data, own, next, squares);
    } else {
        rows.relax_with_momentum(coefficients, scale, data, own, next, step, squares);
    }
}

/// Rows of one stretch: their entries along the diagonals, and the columns that they are multiplied
/// with. What is written comes as arguments of its own: so the compiler knows that it is nothing
/// of what is read.
struct Rows<'a, const W: usize> {
    b: [&'a [f64]; W],
    columns: &'a [f64],
}

impl<const W: usize> Rows<'_, W> {
    #[inline(always)]
    fn relax(
        &self,
        gain: f64,
        scale: f64,
        data: &[f64],
        own: &[f64],
        next: &mut [f64],
        squares: &mut [f64],
    ) {
        let n = next.len();
        let b: [&[f64]; W] = from_fn(|k| &self.b[k][..n]);
        let x: [&[f64]; W] = from_fn(|k| &self.columns[k..k + n]);
        let (data, own, squares) = (&data[..n], &own[..n], &mut squares[..n]);
        for r in 0..n {
            let mut sum = b[0][r] * x[0][r];
            for k in 1..W {
                sum += b[k][r] * x[k][r];
            }
            let delta = data[r] - sum;
            next[r] = own[r] + gain * delta;
            let scaled = delta * scale;
            squares[r] += scaled * scaled;
        }
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "see above")]
    fn relax_with_momentum(
        &self,
        Coefficients { momentum, gain }: Coefficients,
        scale: f64,
        data: &[f64],
        own: &[f64],
        next: &mut [f64],
        step: &mut [f64],
        squares: &mut [f64],
    ) {
        let n = next.len();
        let b: [&[f64]; W] = from_fn(|k| &self.b[k][..n]);
        let x: [&[f64]; W] = from_fn(|k| &self.columns[k..k + n]);
        let (data, own) = (&data[..n], &own[..n]);
        let (step, squares) = (&mut step[..n], &mut squares[..n]);
        for r in 0..n {
            let mut sum = b[0][r] * x[0][r];
            for k in 1..W {
                sum += b[k][r] * x[k][r];
            }
            let delta = data[r] - sum;
            step[r] = momentum * step[r] + gain * delta;
            next[r] = own[r] + step[r];
            let scaled = delta * scale;
            squares[r] += scaled * scaled;
        }
    }
}

/// The same, operation by operation, for all rows.
#[inline(always)]
fn one_by_one(
    u: &Banded,
    rows: Range<usize>,
    coefficients: Coefficients,
    scale: f64,
    lane: Lane<'_>,
) {
    let mut delta = [0.0; BLOCK];
    let delta = &mut delta[..rows.len()];
    u.apply_rows(rows, lane.x, lane.base, delta);
    subtract_from(lane.data, delta);
    add_squares(delta, scale, lane.squares);
    advance(coefficients, lane.own, delta, lane.step, lane.next);
}

/// The next level of some points, and the step that leads there if there is momentum.
#[inline(always)]
pub fn advance(
    coefficients: Coefficients,
    x: &[f64],
    delta: &[f64],
    step: &mut [f64],
    next: &mut [f64],
) {
    if step.is_empty() {
        coefficients.relax(x, delta, next);
    } else {
        coefficients.relax_with_momentum(x, delta, step, next);
    }
}

/// `values ← data − values`.
#[inline(always)]
pub fn subtract_from(data: &[f64], values: &mut [f64]) {
    for (value, data) in values.iter_mut().zip(data) {
        *value = data - *value;
    }
}

/// Adds the squares of scaled coordinates.
#[inline(always)]
pub fn add_squares(delta: &[f64], scale: f64, squares: &mut [f64]) {
    for (square, x) in squares.iter_mut().zip(delta) {
        let x = x * scale;
        *square += x * x;
    }
}
