//! The inverse of a collocation matrix, by the fastest suitable factorization.
//!
//! - Banded and totally positive (open B-splines): elimination without pivots, the quickest;
//! - banded otherwise (closed B-splines, wide bands): LU with partial pivoting, cyclic bands folded
//!   flat;
//! - dense (polynomial bases): LU with partial pivoting.

use nalgebra::DMatrix;

use super::banded::Banded;
use super::dense::DenseLu;
use super::elimination::{Shifted, Solver, decompose};
use super::lu::BandedLu;
use super::map::LineMap;

/// `B⁻¹` of one direction, as a factorization.
#[derive(Debug)]
pub enum Inverse {
    /// Of a local basis, with pivots.
    Banded(BandedLu),
    /// Of a local basis whose matrix is totally positive, without pivots.
    Positive(Box<dyn Solver>),
    /// Of a global one.
    Dense(DenseLu),
}

impl Inverse {
    /// Factorizes a square banded matrix, which may be cyclic, with pivots.
    pub fn of_banded(matrix: &Banded) -> Self {
        Self::Banded(BandedLu::new(matrix))
    }

    /// Factorizes the collocation matrix of a B-spline, without pivots if it is open and has a low
    /// degree.
    pub fn of_collocation(matrix: &Banded) -> Self {
        Self::of_positive(matrix, 1.0, 0.0).unwrap_or_else(|| Self::of_banded(matrix))
    }

    /// Factorizes `σ B − I` of a collocation matrix B, for Noda's iteration. With σ above 1/λ_min
    /// all leading and all trailing principal minors of it are positive, as the eigenvalues of
    /// principal blocks of B are at least λ_min, so that it needs no pivots either; but rounding is
    /// larger than that of B. `None` if the diagonal lies outside of the band.
    pub fn of_shifted(matrix: &Banded, sigma: f64) -> Option<Self> {
        let pivoted = || matrix.shifted(sigma).as_ref().map(Self::of_banded);
        Self::of_positive(matrix, sigma, 1.0).or_else(pivoted)
    }

    /// Factorizes `σ B − τ I` without pivots. Collocation matrices of open B-splines are totally
    /// positive; those of closed ones are in no order of their columns, as rows go around the end.
    fn of_positive(matrix: &Banded, sigma: f64, tau: f64) -> Option<Self> {
        let shifted = Shifted { matrix, sigma, tau };
        let positive = (!matrix.is_cyclic()).then(|| decompose(shifted));
        positive.flatten().map(Self::Positive)
    }

    /// Factorizes a square dense matrix, with pivots.
    pub fn of_dense(matrix: DMatrix<f64>) -> Self {
        Self::Dense(DenseLu::new(matrix))
    }
}

impl LineMap for Inverse {
    /// Solves for every line of a contiguous array.
    fn apply(&self, lines: &mut [f64]) {
        match self {
            Self::Banded(lu) => lu.apply(lines),
            Self::Positive(elimination) => elimination.apply(lines),
            Self::Dense(lu) => lu.apply(lines),
        }
    }

    /// Solves for lines that lie anywhere; without pivots several at a time.
    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        match self {
            Self::Positive(elimination) => elimination.apply_each(lines),
            _ => lines.iter_mut().for_each(|line| self.apply(line)),
        }
    }
}
