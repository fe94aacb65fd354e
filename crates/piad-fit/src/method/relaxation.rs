//! The use of the adjusting vectors of a level in a sweep.
//!
//! A sweep computes `Δ = P − B X` block by block. Of some methods every control point can move at
//! once, by its own adjusting vector,
//!
//! ```text
//! d ← momentum d + gain Δ,   X' = X + d
//! ```
//!
//! for others all adjusting vectors are needed first, and are transformed together afterwards.

use super::recurrence::Recurrence;

/// `d ← momentum d + gain Δ`, `X ← X + d`: of global and weighted PIA without momentum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Coefficients {
    /// How much of the last step is repeated.
    pub momentum: f64,
    /// The factor of the residual.
    pub gain: f64,
}

/// The use of the residual of a level in a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Step {
    /// The control points stay: the level is only measured.
    #[default]
    Keep,
    /// The residual is written in the place of the next level, for a transform of all of it.
    Residual,
    /// Each control point moves by a step.
    Move(Coefficients),
}

/// The steps of a method from level to level.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Relaxation {
    /// Global and weighted: the same factor at every level.
    Scale(f64),
    /// Chebyshev: the recurrence at its first level and now. A pass can be taken again with fewer
    /// levels.
    Chebyshev {
        /// At level 0.
        first: Recurrence,
        /// Now.
        now: Recurrence,
        /// The level.
        level: usize,
    },
    /// `X ← X + U Δ`, with the transform of the equations.
    Transformed {
        /// Direct: there is rarely a second step, so that the residual of the next level is not
        /// kept.
        once: bool,
    },
}

impl Relaxation {
    /// Chebyshev steps at level 0.
    pub(super) fn chebyshev(first: Recurrence) -> Self {
        Self::Chebyshev {
            first,
            now: first,
            level: 0,
        }
    }

    /// Returns true if all adjusting vectors are transformed together.
    pub(crate) fn is_transformed(&self) -> bool {
        matches!(self, Self::Transformed { .. })
    }

    /// Returns true if the fit rarely continues after a step, so that no further step is prepared.
    pub(crate) fn is_done_at_once(&self) -> bool {
        matches!(self, Self::Transformed { once: true })
    }

    /// Returns true if the last step matters for the next one.
    pub(crate) fn has_momentum(&self) -> bool {
        matches!(self, Self::Chebyshev { .. })
    }

    /// The step from the current level to the next.
    pub(crate) fn step(&self) -> Step {
        match self {
            Self::Scale(gain) => Step::Move(Coefficients {
                momentum: 0.0,
                gain: *gain,
            }),
            Self::Chebyshev { now, .. } => {
                let mut now = *now;
                let (momentum, gain) = now.advance();
                Step::Move(Coefficients { momentum, gain })
            }
            Self::Transformed { .. } => Step::Residual,
        }
    }

    /// Moves on to the next level.
    pub(crate) fn advance(&mut self) {
        if let Self::Chebyshev { now, level, .. } = self {
            now.advance();
            *level += 1;
        }
    }

    /// Moves back by some levels. The recurrence is repeated from level 0, as rounding cannot be
    /// undone.
    pub(crate) fn go_back(&mut self, levels: usize) {
        if let Self::Chebyshev { first, now, level } = self {
            *now = *first;
            *level -= levels;
            for _ in 0..*level {
                now.advance();
            }
        }
    }
}
