//! Classical progressive iterative approximation: every control point moves by its adjusting
//! vector.
//!
//! ```text
//! X⁰ = P,   X ← X + (P − B X),   U = I
//! ```
//!
//! (LBW05 (2.9), DP07 (1)). For a normalized totally positive basis with nonsingular B all
//! eigenvalues of B lie in (0, 1], so that it converges, in the long run by the factor
//! `1 − λ_min(B)` in each level (LBW05, Theorem 2.1). A level costs one application of B: O(n p)
//! for B-splines of degree p.

use super::algorithm::{Algorithm, Demand};
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
use crate::setup::Setup;
use crate::warning::Warning;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "global",
    title: "Classical PIA",
    summary: "Every control point moves by the difference vector of its data point.",
    source: "LBW05 (2.9), DP07 (1)",
};

/// The method, which has no settings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Global;

impl Algorithm for Global {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// With the Wang–Ball basis eigenvalues can be complex or larger than 2.
    fn check_convergence(&self, setup: &Setup) -> Result<(), Invalid> {
        divergence::check_relaxation(setup, INFO.name, 1.0)
    }

    /// The residual is the step: this needs no further vector and no factorization.
    fn demand(&self) -> Demand {
        Demand {
            vectors: 0,
            matrices: 1,
            bytes: 0,
        }
    }

    /// `1 − λ_min`, unless there are many points.
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        eigenvalues::classical(setup, collocation)
    }

    fn update(&self, _equations: &Equations) -> Box<dyn Update> {
        Box::new(Linear::endless())
    }

    /// Every control point moves by its own adjusting vector.
    fn relaxation(&self, _equations: &Equations) -> Option<Relaxation> {
        Some(Relaxation::Scale(1.0))
    }

    /// Warns of ill-conditioned bases, whose slowest part of the error would hardly change.
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
