//! How an iteration ends.
//!
//! Converged fits have succeeded, and so have least-squares fits at their minimum if no tolerance was requested.
//! Exhausted and stalled fits have a curve that is further from the data than requested; another method can continue
//! from it. After an overflow there is no curve.

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The largest distance is within the tolerance.
    Converged,
    /// A least-squares fit is at its minimum, and no tolerance was requested.
    Minimum,
    /// The last allowed level is reached, and the tolerance is not.
    Exhausted,
    /// The method cannot continue.
    Stalled(Reason),
    /// The distances are no longer finite.
    Overflow,
}

/// Why a fit stalls outside its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// Least squares: no step reduces the sum of squares.
    Minimum,
    /// Convex: any step would reverse a turn of the control polygon.
    Convexity,
    /// Extended: the error is zero but for rounding, as the power of `I − U B` has vanished.
    Nilpotent,
    /// Direct: only rounding is left.
    Rounding,
    /// Least squares and Chebyshev: the residual grows, because the steps are too long.
    Diverging,
    /// With control points `auto`: within the tolerance at the data, but far from them between neighbours.
    Between,
}

impl Reason {
    /// All reasons.
    pub const ALL: [Self; 6] = [
        Self::Minimum,
        Self::Convexity,
        Self::Nilpotent,
        Self::Rounding,
        Self::Diverging,
        Self::Between,
    ];

    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Minimum => "minimum",
            Self::Convexity => "convexity",
            Self::Nilpotent => "nilpotent",
            Self::Rounding => "rounding",
            Self::Diverging => "diverging",
            Self::Between => "between",
        }
    }
}
