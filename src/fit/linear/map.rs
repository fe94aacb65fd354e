//! Linear maps along the lines of a grid.

use std::fmt::Debug;

use crate::fit::points::Grid;

/// A linear map of lines, applied in place.
pub trait LineMap: Debug + Send + Sync {
    /// Maps each line of `lines`, which are as long as the map is wide and follow one another.
    fn apply(&self, lines: &mut [f64]);

    /// Maps lines that are anywhere.
    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        lines.iter_mut().for_each(|line| self.apply(line));
    }
}

/// Applies `u ⊗ v` to row-major grids: `v` along the rows, `u` across them. `scratch` is as large as
/// one of them; curves need none.
pub fn apply_tensor(
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

/// Writes the transpose of a row-major matrix, tile by tile.
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
