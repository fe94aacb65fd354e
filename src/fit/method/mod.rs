//! The methods: one file for each, in which all that is particular to it stands together.
//!
//! Every method is a choice of level 0 and of the transform U in `X ← X + U (P − B X)`. What a
//! method is for the rest of `fit` is the trait [`Scheme`]; what a new method takes is a file with
//! a type that implements it, and a line in each of [`Method`], [`Method::scheme`] and [`METHODS`].
//!
//! - [`global`], [`weighted`], [`transpose`], [`direct`], [`extended`], [`custom`]: U is a fixed
//!   linear map ([`linear`]);
//! - [`chebyshev`]: momentum over steps of classical PIA ([`recurrence`]);
//! - [`local`], [`adaptive`]: only some control points move ([`selection`]);
//! - [`convex`]: steps that keep the turns of the control polygon;
//! - [`least_squares`]: fewer control points than data points;
//! - [`update`] and [`relaxation`]: how the plain loop and the sweeps take a method's steps;
//! - [`rehearsal`]: fits in advance, and [`eigenvalues`]: forecasts by the least eigenvalue.

mod adaptive;
mod chebyshev;
mod convex;
mod custom;
mod direct;
mod eigenvalues;
mod extended;
mod global;
mod least_squares;
mod linear;
mod local;
mod recurrence;
mod rehearsal;
pub(super) mod relaxation;
mod scheme;
mod selection;
mod stability;
mod transpose;
pub(super) mod update;
mod weighted;

use super::about::About;
use super::forecast::Forecast;
use super::warning::Warning;

pub use adaptive::Adaptive;
pub use custom::{Custom, LARGEST};
pub use extended::{Extended, Start};
pub use least_squares::{LeastSquares, Variant};
pub use local::Local;
pub(super) use scheme::{Progress, Scheme, Scope};
pub use weighted::Weighted;

/// A method with its settings.
#[derive(Clone, Debug, PartialEq)]
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
    Convex,
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
pub const METHODS: [&About; 11] = [
    &global::ABOUT,
    &weighted::ABOUT,
    &local::ABOUT,
    &adaptive::ABOUT,
    &extended::ABOUT,
    &transpose::ABOUT,
    &convex::ABOUT,
    &chebyshev::ABOUT,
    &direct::ABOUT,
    &least_squares::ABOUT,
    &custom::ABOUT,
];

impl Method {
    /// What the method is for the rest of `fit`: the only place that tells methods apart.
    pub(super) fn scheme(&self) -> &dyn Scheme {
        match self {
            Self::Global => &global::Global,
            Self::Weighted(method) => method,
            Self::Local(method) => method,
            Self::Adaptive(method) => method,
            Self::Extended(method) => method,
            Self::Transpose => &transpose::Transpose,
            Self::Convex => &convex::Convex,
            Self::Chebyshev => &chebyshev::Chebyshev,
            Self::Direct => &direct::Direct,
            Self::LeastSquares(method) => method,
            Self::Custom(method) => method,
        }
    }

    /// The same without matrices, as lists of fits show it.
    #[must_use]
    pub fn outline(&self) -> Self {
        match self {
            Self::Custom(_) => Self::Custom(Custom::new(Vec::new(), None)),
            _ => self.clone(),
        }
    }

    /// What it is called, what it does, and where it comes from.
    pub fn about(&self) -> &'static About {
        self.scheme().about()
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.about().name
    }

    /// What is doubtful about a fit by what was found out before the first step, if it will end at
    /// level `predicted`, as far as is known at level 0, and is computed up to level `iterations`.
    pub fn warnings(
        &self,
        forecast: &Forecast,
        predicted: Option<usize>,
        iterations: usize,
    ) -> Vec<Warning> {
        self.scheme().warnings(forecast, predicted, iterations)
    }
}
