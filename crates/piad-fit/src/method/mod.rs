//! The methods with their settings.
//!
//! Every method is a choice of level 0 and of the transform U in `X ← X + U (P − B X)` (Deng13):
//!
//! | method | U | X⁰ | converges | source |
//! |---|---|---|---|---|
//! | `global` | I | P | by 1 − λ_min | LBW05 (2.9), DP07 (1) |
//! | `weighted` | ω I, ω = 2/(1 + λ_min) | P | by (1 − λ_min)/(1 + λ_min) | Lu 2010; Deng13, Cor. 2.3 |
//! | `local` | ω S, S diagonal of 0 and 1 | P | at the selected points | Lin10, sections 2–5 |
//! | `adaptive` | such a one at every level | P | to the threshold | Lin10, section 6 |
//! | `extended` | H Qᵀ, B = Q R | U P or P | exact after n + 1 levels | Deng13 (9) |
//! | `transpose` | Bᵀ/ρ(B Bᵀ) | P | for any nonsingular B | Deng13, Lemma 2.1 |
//! | `convex` | ε_k I, by bisection | P | while it keeps the turns | LWD04, Algorithm 1 |
//! | `chebyshev` | ω_k I and momentum | P | by (1 − √λ_min)/(1 + √λ_min) | Golub, Varga 1961 |
//! | `direct` | B⁻¹ | P | at level 1 | PT97, section 9.2.1 |
//! | `least_squares` | D Aᵀ | sampled data | to the minimum | Deng, Lin 2014 |
//! | `custom` | any matrix | P | if ρ(I − U B) < 1 | Deng13, Theorem 2.1 |

// What a method is for the rest of the crate is the trait `Algorithm`: its checks, its demand of memory,
// its forecast, its transform, its level 0, its update, its stop rule and its warnings. Functions
// of it that a method does not have are those of classical PIA.
//
// # To add a method
//
// Write a file with a type that implements `Algorithm`, whose documentation gives its formula and its source, and add a
// line to each of `Method`, `Method::algorithm` and `METHODS`. Nothing else in the crate distinguishes methods.
//
// # What methods share
//
// - `linear`: the update with a fixed linear map U; `recurrence`: that of the Chebyshev
//   semi-iteration;
// - `selection`: updates that move only some control points;
// - `update` and `relaxation`: how the plain loop and the sweeps take a method's steps;
// - `equations`: `B X = P` and the transform of a method; `plain`: the loop in its basic form;
// - `eigenvalues`: forecasts by the least eigenvalue; `divergence`: whether a relaxation diverges;
// - `trial_run`: fits in advance.

mod adaptive;
mod algorithm;
mod chebyshev;
mod convex;
mod custom;
mod direct;
pub(crate) mod divergence;
mod eigenvalues;
pub(crate) mod equations;
mod extended;
mod global;
mod least_squares;
mod linear;
mod local;
mod omega;
pub(crate) mod plain;
mod recurrence;
pub(super) mod relaxation;
mod selection;
mod threshold;
mod transpose;
mod trial_run;
pub(super) mod update;
mod weighted;

use super::kind_info::KindInfo;
use super::warning::Warning;
use crate::matrix::forecast::Forecast;

pub use adaptive::Adaptive;
pub(super) use algorithm::{Algorithm, Progress, Scope};
pub use convex::Convex;
pub use custom::{Custom, LARGEST};
pub use extended::{Extended, Start};
pub(super) use least_squares::constrained::Constrained;
pub(super) use least_squares::constrained_surface::ConstrainedSurface;
pub(super) use least_squares::cross_validation;
pub(super) use least_squares::fair_surface::{FairSurface, MORE_NUMBERS};
pub use least_squares::{
    AS_MANY_AS_DATA, At, BY_KNOTS, Constraint, EndPoints, Fairness, KnotSelection, LeastSquares,
    MOST_CONDITIONS, Variant, Wanted,
};
pub use local::{Local, Sweeps};
pub use omega::Omega;
pub use threshold::Threshold;
pub use weighted::Weighted;

/// A method with its settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(tag = "kind", rename_all = "snake_case"))]
pub enum Method {
    /// Classical PIA, U = I.
    Global,
    /// Weighted PIA, U = ω I.
    Weighted(Weighted),
    /// Only the selected control points move.
    Local(Local),
    /// Only control points move whose data points are further away than a threshold.
    Adaptive(Adaptive),
    /// Extended PIA, U = H Qᵀ of the QR decomposition of B.
    Extended(Extended),
    /// U = Bᵀ / ρ(B Bᵀ).
    Transpose,
    /// Steps as long as the control polygon keeps the turns of the data.
    Convex(Convex),
    /// Chebyshev semi-iteration on [λ_min, 1].
    Chebyshev,
    /// U = B⁻¹: level 1 is the limit.
    Direct,
    /// Fewer control points than data points.
    LeastSquares(LeastSquares),
    /// U is a given matrix.
    Custom(Custom),
}

/// All methods, in the order in which they are listed.
///
/// ```
/// use piad_fit::method::{METHODS, Method};
///
/// for method in METHODS {
///     println!("{}: {} ({})", method.title, method.summary, method.source);
/// }
/// assert_eq!(Method::Direct.name(), "direct");
/// ```
#[doc(hidden)]
pub const METHODS: [&KindInfo; 11] = [
    &global::INFO,
    &weighted::INFO,
    &local::INFO,
    &adaptive::INFO,
    &extended::INFO,
    &transpose::INFO,
    &convex::INFO,
    &chebyshev::INFO,
    &direct::INFO,
    &least_squares::INFO,
    &custom::INFO,
];

impl Method {
    /// The algorithm of the method: the only place in the crate that distinguishes methods.
    pub(super) fn algorithm(&self) -> &dyn Algorithm {
        match self {
            Self::Global => &global::Global,
            Self::Weighted(method) => method,
            Self::Local(method) => method,
            Self::Adaptive(method) => method,
            Self::Extended(method) => method,
            Self::Transpose => &transpose::Transpose,
            Self::Convex(method) => method,
            Self::Chebyshev => &chebyshev::Chebyshev,
            Self::Direct => &direct::Direct,
            Self::LeastSquares(method) => method,
            Self::Custom(method) => method,
        }
    }

    /// The same without matrices, constraints, and thresholds and weights of points, for lists of fits.
    #[must_use]
    pub fn outline(&self) -> Self {
        match self {
            Self::Custom(_) => Self::Custom(Custom::new(Vec::new(), None)),
            Self::Adaptive(method) => Self::Adaptive(method.outline()),
            Self::LeastSquares(method) => Self::LeastSquares(method.outline()),
            _ => self.clone(),
        }
    }

    /// The settings of a fit that chooses its knots.
    pub(crate) fn automatic(&self) -> Option<(&LeastSquares, &KnotSelection)> {
        match self {
            Self::LeastSquares(settings) => Some((settings, settings.automatic.as_ref()?)),
            _ => None,
        }
    }

    /// Returns true if it chooses its knots.
    pub fn is_automatic(&self) -> bool {
        self.automatic().is_some()
    }

    /// Returns true if there are fewer control points than data points.
    pub fn has_fewer_control_points(&self) -> bool {
        self.algorithm().control_points().is_some()
    }

    /// Its names, what it does, and its source.
    pub fn info(&self) -> &'static KindInfo {
        self.algorithm().info()
    }

    /// The fairness of a least-squares fit, also if the data have chosen it.
    pub fn fairness(&self) -> Option<f64> {
        match self {
            Self::LeastSquares(method) => method.fairness.map(|it| it.value),
            _ => None,
        }
    }

    /// What to do if a least-squares fit is at its minimum, and further from the data than requested.
    pub fn advice_at_minimum(&self) -> String {
        match self {
            Self::LeastSquares(method) => method.advice_at_minimum(),
            _ => "use another method".to_owned(),
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// Warnings by what is known before the first step. The fit is predicted to end at level `predicted`, and is
    /// computed up to level `iterations`.
    pub fn warnings(
        &self,
        forecast: &Forecast,
        predicted: Option<usize>,
        iterations: usize,
    ) -> Vec<Warning> {
        self.algorithm().warnings(forecast, predicted, iterations)
    }
}
