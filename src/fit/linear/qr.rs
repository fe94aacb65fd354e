//! The transform of the extended method, `U = H Qᵀ` with `B = Q R` and `H = diag(1 / r_ii)`.

use nalgebra::{DMatrix, DMatrixViewMut, Dyn};

use super::band::{Band, unfolded};
use super::banded::Banded;
use super::map::LineMap;

/// `H Qᵀ` of one direction (Deng13 (9)). It does not depend on the signs that a QR decomposition
/// chooses. `I − U B` is strictly upper triangular.
#[derive(Debug)]
pub enum Orthogonal {
    /// Of a local basis: plane rotations, O(n p²) to make and O(n p) to apply.
    Banded(Rotations),
    /// Of a global one.
    Dense {
        /// The decomposition.
        qr: nalgebra::QR<f64, Dyn, Dyn>,
        /// The diagonal of R.
        diagonal: Vec<f64>,
    },
}

/// Plane rotations that make a banded matrix upper triangular.
#[derive(Debug)]
pub struct Rotations {
    n: usize,
    lower: usize,
    /// For each column, the cosine and the sine that annihilate the entries below the diagonal.
    rotations: Vec<(f64, f64)>,
    diagonal: Vec<f64>,
    /// Whether rows and columns are in the folded order.
    folded: bool,
}

impl Orthogonal {
    /// The transform of a square banded matrix, which may be cyclic.
    pub fn of_banded(matrix: &Banded) -> Self {
        let n = matrix.rows();
        let mut band = Band::new(matrix);
        let (lower, upper) = (band.lower, band.upper);
        let mut rotations = Vec::with_capacity(n * lower);
        let mut diagonal = Vec::with_capacity(n);
        for k in 0..n {
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
            folded: band.folded,
        })
    }

    /// The transform of a square dense matrix.
    pub fn of_dense(matrix: &DMatrix<f64>) -> Self {
        let qr = matrix.clone().qr();
        let diagonal = qr.r().diagonal().iter().copied().collect();
        Self::Dense { qr, diagonal }
    }
}

impl Rotations {
    /// Transforms in place; `at` is the index of each place of the order.
    fn transform(&self, x: &mut [f64], at: impl Fn(usize) -> usize) {
        for k in 0..self.n {
            let rotations = &self.rotations[k * self.lower..(k + 1) * self.lower];
            for (r, &(c, s)) in rotations.iter().enumerate().take(self.n - 1 - k) {
                let (i, j) = (at(k), at(k + r + 1));
                let (a, b) = (x[i], x[j]);
                x[i] = c * a + s * b;
                x[j] = c * b - s * a;
            }
            x[at(k)] /= self.diagonal[k];
        }
    }
}

impl LineMap for Orthogonal {
    fn apply(&self, lines: &mut [f64]) {
        match self {
            Self::Banded(rotations) => {
                for line in lines.chunks_exact_mut(rotations.n) {
                    if rotations.folded {
                        rotations.transform(line, unfolded(rotations.n));
                    } else {
                        rotations.transform(line, |k| k);
                    }
                }
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
