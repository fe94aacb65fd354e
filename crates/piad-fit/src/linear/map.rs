//! Linear maps along the lines of a grid.
//!
//! The tensor product `U ⊗ V` of two maps, applied to a row-major grid X of n × m numbers, is
//! `U X Vᵀ`: V along each row, U along each column. It is never formed, as it would take (n m)²
//! numbers.

use std::fmt::Debug;

use crate::data::grid::Grid;

/// A linear map of lines of a fixed length n, applied in place: `x ← M x`.
pub trait LineMap: Debug + Send + Sync {
    /// Maps each line of `lines`, a multiple of n numbers in which the lines follow one another.
    fn apply(&self, lines: &mut [f64]);

    /// Maps lines of n numbers each that lie anywhere in memory.
    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        lines.iter_mut().for_each(|line| self.apply(line));
    }
}

/// Applies `u ⊗ v` to row-major grids, one for each coordinate: `v` along the rows, `u` along the
/// columns. Curves have no `v`, and their grids are lines. `scratch` has at least as many numbers
/// as a grid; curves need none. Columns are transposed into lines and back, which costs less than
/// walking along them.
pub(crate) fn apply_tensor(
    u: &impl LineMap,
    v: Option<&impl LineMap>,
    grid: Grid,
    grids: &mut [&mut [f64]],
    scratch: &mut [f64],
) {
    let Some(v) = v else {
        return u.apply_each(grids);
    };
    let scratch = &mut scratch[..grid.count()];
    for values in grids {
        v.apply(values);
        transpose(grid.rows, grid.columns, values, scratch);
        u.apply(scratch);
        transpose(grid.columns, grid.rows, scratch, values);
    }
}

/// Writes the transpose of a row-major matrix, tile by tile: a tile of 32 × 32 numbers fits the
/// nearest cache both ways.
fn transpose(rows: usize, columns: usize, from: &[f64], to: &mut [f64]) {
    const TILE: usize = 32;
    for top in (0..rows).step_by(TILE) {
        for left in (0..columns).step_by(TILE) {
            for i in top..rows.min(top + TILE) {
                for j in left..columns.min(left + TILE) {
                    to[j * rows + i] = from[i * columns + j];
                }
            }
        }
    }
}
