//! The steps of the methods that move every control point by its own adjusting vector.

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
            _ => None,
        }
    }

    /// Whether the last step matters.
    pub fn has_momentum(&self) -> bool {
        matches!(self, Self::Chebyshev { .. })
    }

    /// Of the step from the current level to the next.
    pub fn coefficients(&self) -> Coefficients {
        match self {
            Self::Scale(gain) => Coefficients {
                momentum: 0.0,
                gain: *gain,
            },
            Self::Chebyshev { now, .. } => {
                let mut now = *now;
                let (momentum, gain) = now.advance();
                Coefficients { momentum, gain }
            }
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

impl Coefficients {
    /// `X' = X + gain Δ`.
    #[inline(always)]
    pub fn relax(self, x: &[f64], delta: &[f64], next: &mut [f64]) {
        for ((next, x), delta) in next.iter_mut().zip(x).zip(delta) {
            *next = x + self.gain * delta;
        }
    }

    /// `d ← momentum d + gain Δ`, `X' = X + d`.
    #[inline(always)]
    pub fn relax_with_momentum(self, x: &[f64], delta: &[f64], step: &mut [f64], next: &mut [f64]) {
        for ((step, next), (x, delta)) in step.iter_mut().zip(next).zip(x.iter().zip(delta)) {
            *step = self.momentum * *step + self.gain * delta;
            *next = x + *step;
        }
    }
}
