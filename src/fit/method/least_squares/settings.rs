//! What can be chosen of a least-squares fit.

/// A least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares {
    /// The number of control points of a curve, or in the u direction.
    pub u: usize,
    /// The number of control points in the v direction of a surface.
    pub v: usize,
    /// How the control points move.
    pub variant: Variant,
    /// Where it ends.
    pub ending: Ending,
}

/// Where a least-squares fit ends besides its tolerance and its last level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Where the gradient says that the minimum is near.
    Minimum,
    /// Where the residual shrinks by less than a millionth in one iteration: the rule of fits that
    /// were accepted before there was the other one.
    SmallStep,
}

/// The variants of the least-squares update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variant {
    /// `X ← X + D Aᵀ Δ` with D = diag(1 / column sums of A).
    Diagonal,
    /// `X ← X + μ Aᵀ Δ`; without μ it is 1 / (largest column sum of A).
    Lspia {
        /// The given μ > 0.
        mu: Option<f64>,
    },
    /// Conjugate gradients (CGLS), preconditioned with the same D.
    ConjugateGradients,
    /// The normal equations are solved.
    Direct,
}
