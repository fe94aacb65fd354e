//! The collocation matrix `B[i][j] = B_j(t_i)` as an operator.
//!
//! A direction has one matrix: a row for each of its n data points, a column for each of its free
//! control points, as many of them unless the fit is a least-squares one. It is *banded* for
//! B-splines, p + 1 numbers in a row, and *dense* for polynomial bases. Its rows sum to one, as
//! bases are normalized, and none of its entries is negative.
//!
//! With end copies (knots at the data), the columns of all copies of a control point are added
//! together (LBW05 (3.2)): the matrix stays square, totally positive and nonsingular. In closed
//! directions columns are cyclic.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::bands;
use crate::basis::direction::Direction;
use crate::linear::banded::Banded;
use crate::linear::qr::Orthogonal;
use crate::linear::{Dense, Inverse};

/// Above this number of columns, eigenvalues are computed to fewer digits, which is enough for
/// forecasts.
pub(crate) const ROUGH_EIGENVALUE_COLUMNS: usize = 1000;

/// The least values of a dense matrix that another thread is woken up for.
const PART: usize = 50_000;

/// The collocation matrix of one direction.
#[derive(Clone, Debug)]
pub enum Collocation {
    /// Of a local basis: few entries in each row.
    Banded(Banded),
    /// Of a global basis.
    Dense(Dense),
}

impl Collocation {
    /// The matrix of a direction with respect to its free control points: the columns of end copies
    /// are added to the column of the control point that they copy.
    pub fn new(direction: &Direction) -> Self {
        if direction.basis.is_local() {
            Self::Banded(bands::banded(direction))
        } else {
            Self::Dense(dense(direction))
        }
    }

    /// The matrix, if it is banded.
    pub fn as_banded(&self) -> Option<&Banded> {
        match self {
            Self::Banded(banded) => Some(banded),
            Self::Dense(_) => None,
        }
    }

    /// The number of bytes that the matrix of a direction takes, before it is made.
    pub fn memory(direction: &Direction) -> usize {
        let (rows, columns) = (direction.parameters.len(), direction.free());
        if direction.basis.is_local() {
            // One zero more where that makes rows alike.
            let width = (direction.basis.support_width() + 1).min(columns);
            rows * width * size_of::<f64>()
        } else {
            // The matrix, on surfaces its transpose, and where the entries of each row begin and end.
            rows * (2 * columns + 2) * size_of::<f64>()
        }
    }

    /// The number of rows, one for each data point.
    pub fn rows(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.rows(),
            Self::Dense(dense) => dense.rows(),
        }
    }

    /// The number of columns, one for each free control point.
    pub fn columns(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.columns(),
            Self::Dense(dense) => dense.columns(),
        }
    }

    /// The number of entries that are stored: multiplications of applying the matrix to a line.
    pub fn entries(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.rows() * banded.width(),
            Self::Dense(dense) => dense.len(),
        }
    }

    /// `Y = X Bᵀ`: applies B to each line of `x`, a row-major grid with as many columns as B has.
    /// The lines of `y` are as long as B has rows.
    pub fn apply_to_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => {
                let lines = x.chunks_exact(banded.columns());
                for (x, y) in lines.zip(y.chunks_exact_mut(banded.rows())) {
                    banded.apply(x, y);
                }
            }
            Self::Dense(dense) => dense.apply_to_lines(x, y),
        }
    }

    /// `Y = X B`: applies Bᵀ to each line of `x`, a row-major grid with as many columns as B has
    /// rows. The lines of `y` are as long as B has columns.
    pub fn apply_transposed_to_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => {
                let lines = x.chunks_exact(banded.rows());
                for (x, y) in lines.zip(y.chunks_exact_mut(banded.columns())) {
                    banded.apply_transposed(x, y);
                }
            }
            Self::Dense(dense) => dense.apply_transposed_to_lines(x, y),
        }
    }

    /// `Y = B X`: applies B across the lines of `x`, a row-major grid with as many rows as B has
    /// columns. `y` has as many rows as B.
    pub fn apply_across_lines(&self, x: &[f64], y: &mut [f64]) {
        let line = x.len() / self.columns();
        match self {
            Self::Banded(banded) => banded.apply_across(x, y, line),
            Self::Dense(dense) => dense.apply_across(x, y, line),
        }
    }

    /// `Y = Bᵀ X`: applies Bᵀ across the lines of `x`, a row-major grid with as many rows as B has.
    /// `y` has as many rows as B has columns.
    pub fn apply_transposed_across_lines(&self, x: &[f64], y: &mut [f64]) {
        let line = x.len() / self.rows();
        match self {
            Self::Banded(banded) => banded.apply_transposed_across(x, y, line),
            Self::Dense(dense) => dense.apply_transposed_across(x, y, line),
        }
    }

    /// The matrix itself.
    pub(crate) fn to_dense(&self) -> DMatrix<f64> {
        match self {
            Self::Banded(banded) => {
                let mut matrix = DMatrix::zeros(banded.rows(), banded.columns());
                let entries = banded.entries();
                entries.for_each(|(i, j, value)| matrix[(i, j)] += value);
                matrix
            }
            Self::Dense(dense) => dense.to_matrix(),
        }
    }

    /// The entries of column `j` that differ from zero, rows (increasing) and values.
    pub(crate) fn column(&self, j: usize) -> Vec<(usize, f64)> {
        match self {
            Self::Banded(banded) => banded.column(j).collect(),
            Self::Dense(dense) => dense.column(j).collect(),
        }
    }

    /// The diagonal, if the matrix is triangular: its eigenvalues.
    pub fn diagonal_if_triangular(&self) -> Option<Vec<f64>> {
        match self {
            Self::Banded(banded) => banded.diagonal_if_triangular(),
            Self::Dense(_) => None,
        }
    }

    /// `B⁻¹`, for a square matrix: O(n p²) for B-splines, O(n³) for polynomials.
    pub fn inverse(&self) -> Inverse {
        match self {
            Self::Banded(banded) => Inverse::of_collocation(banded),
            Self::Dense(dense) => Inverse::of_dense(dense.to_matrix()),
        }
    }

    /// `(σ B − I)⁻¹`, for a square matrix and σ above 1/λ_min. Near 1/λ_min, `exact`, matrices that
    /// are not long are factorized with pivots.
    pub fn shifted_inverse(&self, sigma: f64, exact: bool) -> Option<Inverse> {
        match self {
            Self::Banded(banded) if exact && banded.columns() <= ROUGH_EIGENVALUE_COLUMNS => {
                banded.shifted(sigma).as_ref().map(Inverse::of_banded)
            }
            Self::Banded(banded) => Inverse::of_shifted(banded, sigma),
            Self::Dense(dense) => {
                let mut shifted = dense.to_matrix() * sigma;
                for i in 0..dense.rows() {
                    shifted[(i, i)] -= 1.0;
                }
                Some(Inverse::of_dense(shifted))
            }
        }
    }

    /// `H Qᵀ`, for a square matrix (Deng13 (9)): O(n p²) for B-splines, O(n³) for polynomials.
    pub fn orthogonal(&self) -> Orthogonal {
        match self {
            Self::Banded(banded) => Orthogonal::of_banded(banded),
            Self::Dense(dense) => Orthogonal::of_dense(dense.to_matrix()),
        }
    }
}

/// The matrix of a polynomial direction.
fn dense(direction: &Direction) -> Dense {
    let (columns, t) = (direction.free(), &direction.parameters);
    let mut values = vec![0.0; columns * t.len()];
    let rows = values.par_chunks_mut(columns).zip(&t[..]);
    rows.with_min_len(PART.div_ceil(columns))
        .for_each(|(row, &t)| {
            direction.evaluate(t, row);
        });
    Dense::new(DMatrix::from_vec(columns, t.len(), values))
}

#[cfg(test)]
pub(crate) mod tests;
