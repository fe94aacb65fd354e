//! Weighted PIA: every control point moves by ω times its adjusting vector.
//!
//! ```text
//! X⁰ = P,   X ← X + ω (P − B X),   U = ω I
//! ```
//!
//! (Lu 2010; Deng13, Corollary 2.3). With eigenvalues of B in [λ_min, 1] it converges for 0 < ω <
//! 2, by the factor `max(|1 − ω λ_min|, |1 − ω|)` in each level, which is least for ω = 2 / (1 +
//! λ_min): `(1 − λ_min) / (1 + λ_min)`. A level costs as much as one of classical PIA.

use super::algorithm::{Algorithm, Demand, Scope};
use super::divergence;
use super::eigenvalues;
use super::equations::Equations;
use super::linear::Linear;
use super::relaxation::Relaxation;
use super::update::Update;
use crate::invalid::Invalid;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;
use crate::warning::Warning;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "weighted",
    title: "Weighted PIA (WPIA)",
    summary: "Every control point moves by the difference vector of its data point times a relaxation factor.",
    source: "Lu, CAGD 27 (2010); Deng13, Corollary 2.3",
};

/// Weighted PIA with its relaxation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Weighted {
    /// The given ω, between 0 and 2; without it the best one, 2 / (1 + λ_min), is computed.
    pub omega: Option<f64>,
}

impl Algorithm for Weighted {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// ω = 0 would make no progress, and ω = 2 oscillate, as 1 is an eigenvalue of most matrices.
    fn check(&self, _scope: &Scope<'_>) -> Result<(), Invalid> {
        match self.omega {
            Some(value) if !(value > 0.0 && value < 2.0) => Err(Invalid::omega(value)),
            _ => Ok(()),
        }
    }

    /// The best ω is chosen for eigenvalues that are real and positive.
    fn check_convergence(&self, setup: &Setup) -> Result<(), Invalid> {
        match self.omega {
            Some(omega) => divergence::check_relaxation(setup, INFO.name, omega),
            None => divergence::check_real(setup, INFO.name),
        }
    }

    /// No other vector, but factorizations for λ_min.
    fn demand(&self) -> Demand {
        Demand {
            vectors: 0,
            matrices: 4,
            bytes: 0,
        }
    }

    /// The best ω takes λ_min; for a given one it is the forecast only.
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        let needed = eigenvalues::is_small(setup) || self.omega.is_none();
        let lambda = needed.then(|| eigenvalues::least(setup, collocation));
        let best = |lambda: f64| 2.0 / (1.0 + lambda);
        let omega = self.omega.or_else(|| lambda.map(best));
        let rate = omega
            .zip(lambda)
            .map(|(omega, lambda)| (1.0 - omega * lambda).abs().max((1.0 - omega).abs()));
        Forecast {
            lambda_min: lambda,
            omega,
            rate,
            ..Forecast::default()
        }
    }

    /// `ω I` with the given ω or the best one.
    fn transform(&self, _collocation: &Tensor, forecast: &Forecast) -> Transform {
        Transform::Scale(forecast.omega.unwrap_or(1.0))
    }

    fn update(&self, _equations: &Equations) -> Box<dyn Update> {
        Box::new(Linear::endless())
    }

    /// Every control point moves by ω times its adjusting vector.
    fn relaxation(&self, equations: &Equations) -> Option<Relaxation> {
        let omega = equations.forecast.omega.unwrap_or(1.0);
        Some(Relaxation::Scale(omega))
    }

    /// Ill-conditioned bases, whose slowest part of the error would hardly change.
    fn warnings(
        &self,
        forecast: &Forecast,
        predicted: Option<usize>,
        iterations: usize,
    ) -> Vec<Warning> {
        Warning::of_rate(forecast, predicted, iterations)
            .into_iter()
            .collect()
    }
}
