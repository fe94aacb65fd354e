//! The methods: what is asked for of the transform U in `X ← X + U (P − B X)`.

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Classical PIA, U = I (LBW05 (2.9), DP07 (1)).
    Global,
    /// Weighted PIA, U = ω I (Lu 2010). Without ω it is the best one, 2 / (1 + λ_min).
    Weighted {
        /// The given ω, between 0 and 2.
        omega: Option<f64>,
    },
    /// Only the selected control points move (Lin10, sections 2–5).
    Local {
        /// Surfaces: one row after the other, in sweeps until all are within the tolerance.
        row_by_row: bool,
    },
    /// Only control points whose data point is further away than the threshold move; they are
    /// chosen anew at every level (Lin10, section 6).
    Adaptive {
        /// In data units.
        threshold: f64,
    },
    /// Extended PIA, U = H Qᵀ of the QR decomposition of B (Deng13 (9)).
    Extended {
        /// The control points of level 0.
        start: Start,
    },
    /// U = Bᵀ / ρ(B Bᵀ) (Deng13, Lemma 2.1): for any nonsingular B.
    Transpose,
    /// Steps as long as the control polygon keeps the turns of the data (LWD04, Algorithm 1).
    Convex,
    /// Chebyshev semi-iteration on [λ_min, 1].
    Chebyshev,
    /// U = B⁻¹: level 1 is the limit.
    Direct,
    /// Fewer control points than data points (Deng, Lin 2014; Lin, Cao, Zhang 2018).
    LeastSquares(LeastSquares),
}

/// Level 0 of the extended method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// `X⁰ = U P`.
    Transformed,
    /// `X⁰ = P`.
    Data,
}

/// A least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares {
    /// The number of control points of a curve, or in the u direction.
    pub u: usize,
    /// The number of control points in the v direction of a surface.
    pub v: usize,
    /// How the control points move.
    pub variant: Variant,
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
}

impl Method {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Global => "global",
            Self::Weighted { .. } => "weighted",
            Self::Local { .. } => "local",
            Self::Adaptive { .. } => "adaptive",
            Self::Extended { .. } => "extended",
            Self::Transpose => "transpose",
            Self::Convex => "convex",
            Self::Chebyshev => "chebyshev",
            Self::Direct => "direct",
            Self::LeastSquares(_) => "least_squares",
        }
    }
}
