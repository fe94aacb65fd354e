//! The inverse of a collocation matrix, by the factorization that suits it.

use nalgebra::DMatrix;

use super::banded::Banded;
use super::dense::DenseLu;
use super::elimination::{Shifted, Solver, decompose};
use super::lu::BandedLu;
use super::map::LineMap;

/// `B⁻¹` of one direction.
#[derive(Debug)]
pub enum Inverse {
    /// Of a local basis.
    Banded(BandedLu),
    /// Of a local basis whose matrix is totally positive.
    Positive(Box<dyn Solver>),
    /// Of a global one.
    Dense(DenseLu),
}

impl Inverse {
    /// Factorizes a banded matrix.
    pub fn of_banded(matrix: &Banded) -> Self {
        Self::Banded(BandedLu::new(matrix))
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
        let positive = (!matrix.is_cyclic()).then(|| decompose(shifted));
        positive.flatten().map(Self::Positive)
    }

    /// Factorizes a dense matrix.
    pub fn of_dense(matrix: &DMatrix<f64>) -> Self {
        Self::Dense(DenseLu::new(matrix))
    }
}

impl LineMap for Inverse {
    fn apply(&self, lines: &mut [f64]) {
        match self {
            Self::Banded(lu) => lu.apply(lines),
            Self::Positive(elimination) => elimination.apply(lines),
            Self::Dense(lu) => lu.apply(lines),
        }
    }

    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        match self {
            Self::Positive(elimination) => elimination.apply_each(lines),
            _ => lines.iter_mut().for_each(|line| self.apply(line)),
        }
    }
}
