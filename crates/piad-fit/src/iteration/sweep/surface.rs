//! One level of a surface in one pass.
//!
//! `Δ = P − (B_u X) B_vᵀ`: a line of `B_u X` is a sum of the p + 1 lines of X that a row of `B_u`
//! reaches, and along that line the work is that of a curve with the matrix `B_v`. The grid is
//! worked through in strips of at most 1024 columns, row after row, so that the lines of X stay in
//! the nearest cache until the last row that needs them. The Kronecker product is never formed: a
//! level costs `d n m (p_u + p_v + 2)` multiplications on n × m points.

use std::ops::Range;

use pulp::{Arch, NullaryFnOnce};

use super::fused::Rows;
use super::parts::{Part, columns, ranges};
use super::pass::{Pass, Way};
use super::workspace::pieces;
use crate::data::blocks::{Block, Squares, Sums};
use crate::data::points::Points;
use crate::linear::banded::Banded;

/// Strip by strip, for each line of the part: its part of `B_u X`, then `Δ`, its norms, and the
/// points of the next level.
pub(super) fn sweep<const D: usize>(pass: &Pass<'_>, v: &Banded, mut part: Part<'_>) {
    let (lines, strips) = pass.layout.unit();
    let units = part.blocks[0].len() / strips;
    let first_unit = part.lines.start / lines;
    let mut squares = Squares::new();
    for strip in 0..strips {
        for unit in 0..units {
            let points = pass.layout.points((first_unit + unit) * strips + strip);
            let squares = squares.first(points.len());
            let sums = block::<D>(pass, v, &mut part, points.clone(), squares);
            part.blocks[0][unit * strips + strip] = Block::new(points.start, squares, &sums);
        }
    }
}

/// The points of one block, which are several whole lines, or a part of one line. Writes the
/// squares of their scaled residuals, and returns what these add up to.
fn block<const D: usize>(
    pass: &Pass<'_>,
    v: &Banded,
    part: &mut Part<'_>,
    points: Range<usize>,
    squares: &mut [f64],
) -> Sums {
    let line = v.columns();
    let mut sums = Sums::default();
    let mut start = points.start;
    while start < points.end {
        let end = points.end.min((start / line + 1) * line);
        let place = start - points.start;
        let squares = &mut squares[place..end - points.start];
        segment::<D>(pass, v, part, start..end, place, squares, &mut sums);
        start = end;
    }
    sums
}

/// Consecutive points of one line; `place` is that of the first one in its block. Adds their
/// squares to `sums`.
fn segment<const D: usize>(
    pass: &Pass<'_>,
    v: &Banded,
    part: &mut Part<'_>,
    points: Range<usize>,
    place: usize,
    squares: &mut [f64],
    sums: &mut Sums,
) {
    let line = v.columns();
    let row = points.start / line;
    let along = points.start % line..(points.end - 1) % line + 1;
    let origin = part.lines.start * line;
    let [workspace] = &mut *part.workspaces else {
        return;
    };
    let reached = reached(v, along.clone());
    combine_all(pass, row, line, reached.clone(), &mut workspace.front);
    let to = points.start - origin..points.end - origin;
    let mut step = ranges::<D>(&mut part.step, to.clone());
    let next = match pass.way {
        Way::Measure => ranges(workspace.back.lanes_mut(), 0..to.len()),
        _ => ranges(&mut part.x, to),
    };
    if let Some(last) = &pass.source.step {
        let last = columns::<D>(last, points.clone());
        let steps = step.iter_mut().zip(last);
        steps.for_each(|(next, last)| next.copy_from_slice(last));
    }
    let mut rows = Rows {
        x: columns(&workspace.front, 0..(reached.end - reached.start) as usize),
        base: reached.start,
        data: columns(pass.data, points.clone()),
        own: columns(&pass.source.x, points),
        next,
        step,
        squares,
        place,
    };
    pass.update(v, 0).add(along, &mut rows, sums);
}

/// The columns that some rows of `B_v` reach. In closed directions columns before the first one and
/// behind the last one are those of the other end.
fn reached(v: &Banded, rows: Range<usize>) -> Range<i64> {
    let reach = v.reach() as i64;
    let range = rows.start as i64 - reach..rows.end as i64 + reach;
    if v.is_cyclic() {
        return range;
    }
    range.start.max(0)..range.end.min(v.columns() as i64)
}

/// Writes a range of columns of line `row` of `B_u X`, of all coordinates, to the start of `to`.
fn combine_all(pass: &Pass<'_>, row: usize, line: usize, range: Range<i64>, to: &mut Points) {
    let base = range.start;
    let first = pass.u.first(row);
    for (piece, column) in pieces(range, line as i64, i64::MAX) {
        let local = (piece.start - base) as usize..(piece.end - base) as usize;
        for (to, x) in to.lanes_mut().iter_mut().zip(pass.source.x.lanes()) {
            Arch::new().dispatch(Combine {
                u: pass.u,
                row,
                first,
                x,
                line,
                column,
                y: &mut to[local.clone()],
            });
        }
    }
}

/// A part of a line of `B_u X`, of one coordinate: `y = Σ_k b_k x_k` with the entries b_k of a row
/// of `B_u` and the lines x_k of X that it reaches. Compiled for several instruction sets.
struct Combine<'a> {
    u: &'a Banded,
    /// The row of `B_u`.
    row: usize,
    /// The column of its first entry.
    first: i64,
    /// One coordinate of X, row by row.
    x: &'a [f64],
    /// The length of a line of X.
    line: usize,
    /// The first column of the part.
    column: usize,
    /// Gets the part.
    y: &'a mut [f64],
}

impl NullaryFnOnce for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.u.width() {
            1 => self.sum::<1>(),
            2 => self.sum::<2>(),
            3 => self.sum::<3>(),
            4 => self.sum::<4>(),
            5 => self.sum::<5>(),
            6 => self.sum::<6>(),
            7 => self.sum::<7>(),
            width => {
                for k in 0..width {
                    let (b, x) = self.product(k);
                    for (y, x) in self.y.iter_mut().zip(x) {
                        *y = if k == 0 { b * x } else { *y + b * x };
                    }
                }
            }
        }
    }
}

impl<'a> Combine<'a> {
    /// Entry k of the row of `B_u`, and the line of X that it is multiplied with, from the column
    /// on.
    #[inline(always)]
    fn product(&self, k: usize) -> (f64, &'a [f64]) {
        let (line, lines) = (self.first + k as i64, self.u.columns() as i64);
        // Divisions take longer than the sum: only rows around the end of a closed direction need them.
        let line = if (0..lines).contains(&line) {
            line
        } else {
            line.rem_euclid(lines)
        };
        let x = &self.x[line as usize * self.line + self.column..];
        (self.u.entry(self.row, k), x)
    }

    /// The sum of the W products, with the loop over them unrolled.
    #[inline(always)]
    fn sum<const W: usize>(self) {
        let products: [(f64, &[f64]); W] = std::array::from_fn(|k| self.product(k));
        sum(products.map(|it| it.0), products.map(|it| it.1), self.y);
    }
}

/// `y_r = Σ_k b_k x_k,r`, summed up from k = 0 on.
#[inline(always)]
fn sum<const W: usize>(b: [f64; W], x: [&[f64]; W], y: &mut [f64]) {
    let n = y.len();
    let x = x.map(|x| &x[..n]);
    for r in 0..n {
        let mut sum = b[0] * x[0][r];
        for k in 1..W {
            sum += b[k] * x[k][r];
        }
        y[r] = sum;
    }
}
