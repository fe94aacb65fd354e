//! The forecast of the convergence of a fit.

/// The forecast of the convergence, before the first step. Rates are factors per level, without a
/// unit; lengths are in the unit of the data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Forecast {
    /// The least eigenvalue of the collocation matrix.
    pub lambda_min: Option<f64>,
    /// The relaxation of weighted, local and adaptive PIA.
    pub omega: Option<f64>,
    /// By how much the error shrinks in each iteration, asymptotically. For adaptive fits, and
    /// local ones of many points, an upper bound: principal submatrices have eigenvalues between
    /// those of the matrix.
    pub rate: Option<f64>,
    /// Local: the least eigenvalue of the block of the matrix that belongs to the adjusted points.
    pub block: Option<f64>,
    /// The number of iterations after which the fit is exact, where there is one.
    pub exact_after: Option<usize>,
    /// Least squares: how many control points have no data in the support of their basis function.
    pub without_data: usize,
    /// Least squares: the first constraint whose tangent the data run against.
    pub reversed: Option<usize>,
    /// Chebyshev: where the interval of its steps begins, if not at the least eigenvalue.
    pub interval: Option<f64>,
    /// Extended: about how large a distance rounding leaves after `exact_after` iterations, if that
    /// is more than the tolerance.
    pub rounding: Option<f64>,
}

impl Forecast {
    /// The number of iterations of a local fit that reduce an error to the tolerance, both in data
    /// units, by the least eigenvalue of its block: `ln(tolerance / error) / ln(rate)`, rounded up.
    /// The block is small, so that its least eigenvalue soon dominates.
    pub(crate) fn iterations_of_block(&self, error: f64, tolerance: f64) -> Option<usize> {
        let rate = self.rate.filter(|_| self.block.is_some())?;
        let count = (tolerance / error).ln() / rate.ln();
        (rate > 0.0 && rate < 1.0 && count.is_finite()).then_some(count.ceil() as usize)
    }
}

/// The predicted end of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Prediction {
    /// By a trial run: at this level, but for rounding.
    End(usize),
    /// By a trial run of the beginning: at about this level, unless later errors give a better
    /// prediction.
    Estimate {
        /// The level at which it ends.
        end: usize,
        /// The level up to which this prediction is the best one.
        seen: usize,
    },
}
