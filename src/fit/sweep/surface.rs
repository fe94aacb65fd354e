//! One level of a surface in one pass.
//!
//! `Δ = P − B_u X B_vᵀ`: line i of `B_u T` needs the few lines of `T = X B_vᵀ` that row i of `B_u`
//! reaches. A window of lines goes along; T as a whole is never there.

use super::Pass;
use super::fused::{add_squares, advance, subtract_from};
use super::parts::Part;
use crate::fit::blocks::{BLOCK, Block};
use crate::fit::linear::banded::Banded;
use crate::fit::points::Points;

/// Lines of T that are kept: all that a row needs.
pub fn window(u: &Banded) -> usize {
    u.width()
}

/// For each line: what it needs of T, `Δ = P − B_u T`, its norms, and the next level.
#[inline(always)]
pub fn sweep(pass: &Pass<'_>, v: &Banded, part: Part<'_>) {
    let [coefficients] = *pass.coefficients else {
        return;
    };
    let [room] = &mut *part.rooms else { return };
    let columns = v.columns();
    let (lines, parts) = pass.layout.unit();
    let origin = part.lines.start * columns;
    let first_block = part.lines.start / lines * parts;
    let mut next_line = i64::MIN;
    for (index, block) in part.blocks[0].iter_mut().enumerate() {
        let points = pass.layout.points(first_block + index);
        let mut squares = [0.0; BLOCK];
        let mut start = points.start;
        while start < points.end {
            let (row, column) = (start / columns, start % columns);
            let end = points.end.min((row + 1) * columns);
            if column == 0 {
                fill(pass, v, &mut room.front, row, &mut next_line);
            }
            let squares = &mut squares[start - points.start..end - points.start];
            let (from, to) = (start..end, start - origin..end - origin);
            let mut delta = [0.0; BLOCK];
            let delta = &mut delta[..end - start];
            for (c, x) in pass.source.x.lanes().iter().enumerate() {
                let lines = room.front.lane(c);
                combine(pass.u, row, lines, columns, column, delta);
                subtract_from(&pass.data.lane(c)[from.clone()], delta);
                add_squares(delta, pass.scale, squares);
                let next_step = part.step[c].get_mut(to.clone()).unwrap_or_default();
                if let Some(step) = &pass.source.step {
                    next_step.copy_from_slice(&step.lane(c)[from.clone()]);
                }
                let next = &mut part.x[c][to.clone()];
                advance(coefficients, &x[from.clone()], delta, next_step, next);
            }
            start = end;
        }
        *block = Block::of(points.start, &squares[..points.len()]);
    }
}

/// Computes the lines of `T = X B_vᵀ` that a row of `B_u` needs and that are not there yet.
#[inline(always)]
fn fill(pass: &Pass<'_>, v: &Banded, lines: &mut Points, row: usize, next: &mut i64) {
    let columns = v.columns();
    let (first, width) = (pass.u.first(row), pass.u.width() as i64);
    // The window moves on; on short closed directions it may turn back.
    let missing = if first + width < *next {
        first
    } else {
        first.max(*next)
    };
    for line in missing..first + width {
        let slot = line.rem_euclid(width) as usize * columns;
        let from = line.rem_euclid(pass.u.columns() as i64) as usize * columns;
        for (to, x) in lines.lanes_mut().iter_mut().zip(pass.source.x.lanes()) {
            let to = &mut to[slot..slot + columns];
            v.apply_rows(0..columns, &x[from..from + columns], 0, to);
        }
    }
    *next = first + width;
}

/// A part of line `row` of `B_u T`, from a column on.
#[inline(always)]
fn combine(u: &Banded, row: usize, lines: &[f64], columns: usize, column: usize, y: &mut [f64]) {
    match u.width() {
        1 => sum::<1>(u, row, lines, columns, column, y),
        2 => sum::<2>(u, row, lines, columns, column, y),
        3 => sum::<3>(u, row, lines, columns, column, y),
        4 => sum::<4>(u, row, lines, columns, column, y),
        5 => sum::<5>(u, row, lines, columns, column, y),
        6 => sum::<6>(u, row, lines, columns, column, y),
        7 => sum::<7>(u, row, lines, columns, column, y),
        width => {
            for k in 0..width {
                let (b, x) = (
                    u.entry(row, k),
                    &lines[slot(u, row, k) * columns + column..],
                );
                for (y, x) in y.iter_mut().zip(x) {
                    *y = if k == 0 { b * x } else { *y + b * x };
                }
            }
        }
    }
}

/// The place in the window of the line that entry k of a row is multiplied with.
#[inline(always)]
fn slot(u: &Banded, row: usize, k: usize) -> usize {
    (u.first(row) + k as i64).rem_euclid(u.width() as i64) as usize
}

/// `y_r = Σ_k b_k T_k,r`.
#[inline(always)]
fn sum<const W: usize>(
    u: &Banded,
    row: usize,
    lines: &[f64],
    columns: usize,
    column: usize,
    y: &mut [f64],
) {
    let n = y.len();
    let b: [f64; W] = std::array::from_fn(|k| u.entry(row, k));
    let x: [&[f64]; W] = std::array::from_fn(|k| &lines[slot(u, row, k) * columns + column..][..n]);
    for r in 0..n {
        let mut sum = b[0] * x[0][r];
        for k in 1..W {
            sum += b[k] * x[k][r];
        }
        y[r] = sum;
    }
}
