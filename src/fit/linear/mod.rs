//! Linear algebra along the lines of a grid: banded matrices, and factorizations that solve.

mod band;
pub mod banded;
pub mod columns;
mod elimination;
pub mod lu;
mod pack;
pub mod qr;

use std::fmt::Debug;

use nalgebra::{DMatrix, DMatrixViewMut, Dyn};

use super::points::Grid;
pub use band::{folded, unfolded};
use banded::Banded;
use elimination::{Shifted, Solver};

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

/// `B⁻¹` of one direction.
#[derive(Debug)]
pub enum Inverse {
    /// Of a local basis.
    Banded(lu::BandedLu),
    /// Of a local basis whose matrix is totally positive.
    Positive(Box<dyn Solver>),
    /// Of a global one.
    Dense {
        /// The decomposition.
        lu: nalgebra::LU<f64, Dyn, Dyn>,
        /// The number of rows.
        n: usize,
    },
}

impl Inverse {
    /// Factorizes a banded matrix.
    pub fn of_banded(matrix: &Banded) -> Self {
        Self::Banded(lu::BandedLu::new(matrix))
    }

    /// Factorizes a collocation matrix.
    pub fn of_collocation(matrix: &Banded) -> Self {
        Self::of_positive(matrix, 1.0, 0.0).unwrap_or_else(|| Self::of_banded(matrix))
    }

    /// Factorizes `σ B − I` of a collocation matrix, by elimination without pivots: with σ above 1/λ_min
    /// all leading and all trailing minors are positive, as those of B interlace their eigenvalues, but
    /// rounding is larger.
    pub fn of_shifted(matrix: &Banded, sigma: f64) -> Option<Self> {
        let pivoted = || matrix.shifted(sigma).as_ref().map(Self::of_banded);
        Self::of_positive(matrix, sigma, 1.0).or_else(pivoted)
    }

    /// Collocation matrices of open B-splines are totally positive; around the end of closed ones
    /// there is no order of the columns in which they would be.
    fn of_positive(matrix: &Banded, sigma: f64, tau: f64) -> Option<Self> {
        let shifted = Shifted { matrix, sigma, tau };
        let positive = (!matrix.is_cyclic()).then(|| elimination::decompose(shifted));
        positive.flatten().map(Self::Positive)
    }

    /// Factorizes a dense matrix.
    pub fn of_dense(matrix: &DMatrix<f64>) -> Self {
        Self::Dense {
            lu: matrix.clone().lu(),
            n: matrix.nrows(),
        }
    }
}

impl LineMap for Inverse {
    fn apply(&self, lines: &mut [f64]) {
        match self {
            Self::Banded(lu) => lu.apply(lines),
            Self::Positive(elimination) => elimination.apply(lines),
            Self::Dense { lu, n } => {
                let mut view = DMatrixViewMut::from_slice(lines, *n, lines.len() / n);
                if !lu.solve_mut(&mut view) {
                    // Singular to working precision: the iteration ends with an overflow.
                    view.fill(f64::INFINITY);
                }
            }
        }
    }

    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        match self {
            Self::Positive(elimination) => elimination.apply_each(lines),
            _ => lines.iter_mut().for_each(|line| self.apply(line)),
        }
    }
}
