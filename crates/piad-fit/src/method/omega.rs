//! The relaxation ω of methods that move some control points, `U = ω S`.

use crate::invalid::Invalid;

/// A relaxation, between 0 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Omega {
    /// The given number.
    Given(f64),
    /// The best one for eigenvalues between λ_min and one, `2 / (1 + λ_min)`.
    Best,
}

impl Default for Omega {
    /// ω = 1: the adjusting vectors themselves.
    fn default() -> Self {
        Self::Given(1.0)
    }
}

impl Omega {
    /// The given number, unless it is the default.
    pub fn other_than_one(self) -> Option<Self> {
        (self != Self::default()).then_some(self)
    }

    /// Its number, where it is given.
    pub fn given(self) -> Option<f64> {
        match self {
            Self::Given(omega) => Some(omega),
            Self::Best => None,
        }
    }

    /// ω = 0 would make no progress, and ω = 2 oscillate where 1 is an eigenvalue.
    pub(super) fn check(self) -> Result<(), Invalid> {
        match self {
            Self::Given(value) if !(value > 0.0 && value < 2.0) => Err(Invalid::omega(value)),
            _ => Ok(()),
        }
    }

    /// The number for matrices with this least eigenvalue; 1, the safe one, if it is not known.
    pub(super) fn of(self, least: Option<f64>) -> f64 {
        match self {
            Self::Given(omega) => omega,
            Self::Best => least.map_or(1.0, |least| 2.0 / (1.0 + least)),
        }
    }
}
