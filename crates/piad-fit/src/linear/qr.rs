//! The transform of the extended method, `U = H Qᵀ` with `B = Q R` and `H = diag(1 / r_ii)` (Deng13
//! (9)).
//!
//! Q is never formed. For banded matrices it is a product of plane (Givens) rotations, l for each
//! of the n columns if there are l entries below the diagonal: `O(n l (l + r))` to make and `6 n l`
//! operations for a line; [cyclic](super::bordered) ones fill in their last columns. Columns keep
//! their order, so that U and with it every level are those of the thin QR decomposition. For dense matrices it is the product of Householder reflections that
//! `nalgebra` keeps: O(n³) and O(n²). `U B = H R` is upper triangular with ones on the diagonal, so
//! that `I − U B` is nilpotent.

use nalgebra::{DMatrix, DMatrixViewMut, Dyn};

use super::band::Band;
use super::banded::Banded;
use super::bordered::BorderedRotations;
use super::map::LineMap;
use crate::interrupt;

/// `H Qᵀ` of one direction. It does not depend on the signs that a QR decomposition chooses: a sign
/// in a column of Q is one in a row of R, too.
#[derive(Debug)]
pub enum Orthogonal {
    /// Of a local basis of degree p: plane rotations, O(n p²) to make and O(n p) to apply.
    Banded(Rotations),
    /// Of a local basis whose matrix has rows that go around the end: as much.
    Cyclic(BorderedRotations),
    /// Of a global basis: reflections, O(n³) to make and O(n²) to apply.
    Dense {
        /// The decomposition.
        qr: nalgebra::QR<f64, Dyn, Dyn>,
        /// The diagonal of R.
        diagonal: Vec<f64>,
    },
}

/// Plane rotations that make a banded matrix upper triangular, column by column from the left.
#[derive(Debug)]
pub struct Rotations {
    /// The number of rows.
    n: usize,
    /// The most entries of a column below the diagonal.
    lower: usize,
    /// For each column, the cosines and sines of the rotations that annihilate its entries below
    /// the diagonal, from the nearest to the farthest.
    rotations: Vec<(f64, f64)>,
    /// The diagonal of R.
    diagonal: Vec<f64>,
}

impl Orthogonal {
    /// The transform of a square banded matrix, which may be cyclic.
    pub fn of_banded(matrix: &Banded) -> Self {
        if matrix.is_cyclic() {
            return Self::Cyclic(BorderedRotations::new(matrix));
        }
        let n = matrix.rows();
        let mut band = Band::new(matrix);
        let (lower, upper) = (band.lower, band.upper);
        let mut rotations = Vec::with_capacity(n * lower);
        let mut diagonal = Vec::with_capacity(n);
        for k in 0..n {
            interrupt::check();
            let right = upper.min(n - 1 - k);
            for r in 1..=lower {
                if k + r >= n {
                    rotations.push((1.0, 0.0));
                    continue;
                }
                let (a, b) = (*band.at(k, k), *band.at(k + r, k));
                let length = a.hypot(b);
                let (c, s) = if b == 0.0 {
                    (1.0, 0.0)
                } else {
                    (a / length, b / length)
                };
                rotations.push((c, s));
                if s != 0.0 {
                    for j in k..=k + right {
                        let (a, b) = (*band.at(k, j), *band.at(k + r, j));
                        *band.at(k, j) = c * a + s * b;
                        *band.at(k + r, j) = c * b - s * a;
                    }
                }
            }
            diagonal.push(*band.at(k, k));
        }
        Self::Banded(Rotations {
            n,
            lower,
            rotations,
            diagonal,
        })
    }

    /// The transform of a square dense matrix.
    pub fn of_dense(matrix: DMatrix<f64>) -> Self {
        let qr = matrix.qr();
        let diagonal = qr.r().diagonal().iter().copied().collect();
        Self::Dense { qr, diagonal }
    }
}

impl Rotations {
    /// Applies `H Qᵀ` to a line in place.
    fn transform(&self, x: &mut [f64]) {
        for k in 0..self.n {
            let rotations = &self.rotations[k * self.lower..(k + 1) * self.lower];
            for (r, &(c, s)) in rotations.iter().enumerate().take(self.n - 1 - k) {
                let (i, j) = (k, k + r + 1);
                let (a, b) = (x[i], x[j]);
                x[i] = c * a + s * b;
                x[j] = c * b - s * a;
            }
            x[k] /= self.diagonal[k];
        }
    }
}

impl LineMap for Orthogonal {
    fn apply(&self, lines: &mut [f64]) {
        match self {
            Self::Banded(rotations) => {
                let lines = lines.chunks_exact_mut(rotations.n);
                lines.for_each(|line| rotations.transform(line));
            }
            Self::Cyclic(rotations) => {
                let lines = lines.chunks_exact_mut(rotations.rows());
                lines.for_each(|line| rotations.transform(line));
            }
            Self::Dense { qr, diagonal } => {
                let n = diagonal.len();
                let count = lines.len() / n;
                let mut view = DMatrixViewMut::from_slice(lines, n, count);
                qr.q_tr_mul(&mut view);
                for line in lines.chunks_exact_mut(n) {
                    for (x, diagonal) in line.iter_mut().zip(diagonal) {
                        *x /= diagonal;
                    }
                }
            }
        }
    }
}
