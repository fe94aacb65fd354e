//! One level of a curve in one pass.

use super::parts::Part;
use super::relaxation::Coefficients;
use super::{Pass, Vectors};
use crate::fit::blocks::{BLOCK, Block};

/// For each block: `Δ = P − B X`, its norms, and the next level.
#[inline(always)]
pub fn sweep(pass: &Pass<'_>, part: Part<'_>) {
    let Vectors { x, step } = pass.source;
    let [coefficients] = *pass.coefficients else {
        return;
    };
    let first = part.lines.start;
    let mut delta = [0.0; BLOCK];
    let mut start = first;
    for block in part.blocks[0].iter_mut() {
        let end = part.lines.end.min(start + BLOCK);
        let delta = &mut delta[..end - start];
        let mut squares = [0.0; BLOCK];
        for (c, (x, data)) in x.lanes().iter().zip(pass.data.lanes()).enumerate() {
            pass.u.apply_rows(start..end, x, 0, delta);
            subtract_from(&data[start..end], delta);
            add_squares(delta, pass.scale, &mut squares);
            let (from, to) = (start..end, start - first..end - first);
            let step = step.as_ref().map(|step| &step.lanes()[c][from.clone()]);
            let next_step = part.step[c].get_mut(to.clone()).unwrap_or_default();
            advance(
                coefficients,
                &x[from],
                delta,
                step,
                next_step,
                &mut part.x[c][to],
            );
        }
        *block = Block::of(start, &squares[..end - start]);
        start = end;
    }
}

/// The next level of some points, and the step that leads there if there is momentum.
#[inline(always)]
pub fn advance(
    coefficients: Coefficients,
    x: &[f64],
    delta: &[f64],
    step: Option<&[f64]>,
    next_step: &mut [f64],
    next: &mut [f64],
) {
    if let Some(step) = step {
        next_step.copy_from_slice(step);
        coefficients.relax_with_momentum(x, delta, next_step, next);
    } else {
        coefficients.relax(x, delta, next);
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
