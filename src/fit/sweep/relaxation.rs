//! What methods do with the adjusting vectors: move every control point by its own, or transform all of
//! them together.

use crate::fit::method::Method;
use crate::fit::system::{System, Transform};
use crate::fit::update::chebyshev::Recurrence;

/// `d ← momentum d + gain Δ`, `X ← X + d`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// How much of the last step is repeated.
    pub momentum: f64,
    /// The factor of the residual.
    pub gain: f64,
}

/// What a pass does with the residual of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Step {
    /// Nothing: the control points stay.
    #[default]
    Keep,
    /// It is written in the place of the next level.
    Residual,
    /// A step of each control point.
    Move(Coefficients),
}

/// The coefficients of each level.
#[derive(Clone, Copy, Debug)]
pub enum Relaxation {
    /// Global and weighted: the same factor at every level.
    Scale(f64),
    /// Chebyshev: the recurrence at its first level, and how many levels have passed.
    Chebyshev {
        /// At level 0.
        first: Recurrence,
        /// Now.
        now: Recurrence,
        /// The level.
        level: usize,
    },
    /// `X ← X + U Δ`.
    Transformed {
        /// Direct: hardly ever is there a second step.
        once: bool,
    },
}

impl Relaxation {
    /// At level 0, for the methods that are steps of this kind.
    pub fn new(system: &System) -> Option<Self> {
        match (system.problem().method(), system.transform()) {
            (Method::Global | Method::Weighted { .. }, Transform::Scale(omega)) => {
                Some(Self::Scale(*omega))
            }
            (Method::Chebyshev, _) => {
                let first = Recurrence::new(system);
                Some(Self::Chebyshev {
                    first,
                    now: first,
                    level: 0,
                })
            }
            (Method::Direct, _) => Some(Self::Transformed { once: true }),
            (Method::Transpose, _) => Some(Self::Transformed { once: false }),
            _ => None,
        }
    }

    /// Whether all adjusting vectors are transformed together.
    pub fn is_transformed(&self) -> bool {
        matches!(self, Self::Transformed { .. })
    }

    /// Whether the residual of a level is seldom needed for another one.
    pub fn is_done_at_once(&self) -> bool {
        matches!(self, Self::Transformed { once: true })
    }

    /// Whether the last step matters.
    pub fn has_momentum(&self) -> bool {
        matches!(self, Self::Chebyshev { .. })
    }

    /// From the current level to the next.
    pub fn step(&self) -> Step {
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
    pub fn advance(&mut self) {
        if let Self::Chebyshev { now, level, .. } = self {
            now.advance();
            *level += 1;
        }
    }

    /// Moves back by some levels: forward from the first, as rounding cannot be undone.
    pub fn go_back(&mut self, levels: usize) {
        if let Self::Chebyshev { first, now, level } = self {
            *now = *first;
            *level -= levels;
            for _ in 0..*level {
                now.advance();
            }
        }
    }
}
