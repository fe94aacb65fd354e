//! PIA with the transpose of the collocation matrix: converges for any nonsingular one, slowly.
//!
//! ```text
//! X⁰ = P,   X ← X + Bᵀ (P − B X) / ρ(B Bᵀ),   U = Bᵀ / ρ(B Bᵀ)
//! ```
//!
//! (Deng13, Lemma 2.1): the Landweber iteration. The eigenvalues of `U B` are the squares of the
//! singular values of B over that of the largest, in (0, 1], so that the rate is `1 − 1/κ(B)²` with
//! the condition number κ(B): where classical PIA takes k levels, this one takes about κ(B) k. It
//! needs no total positivity, and is the only method of this kind that converges for every basis
//! and all parameters.
//!
//! Of a surface ρ is the product of those of both directions. A level costs two applications of B;
//! ρ is found by power iteration before.

use super::algorithm::Algorithm;
use super::equations::Equations;
use super::linear::Linear;
use super::relaxation::Relaxation;
use super::update::Update;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::spectrum;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "transpose",
    title: "PIA with the transpose",
    summary: "Difference vectors are multiplied with the scaled transpose of the collocation matrix, which converges for any basis, slowly.",
    source: "Deng13, Lemma 2.1",
};

/// The method, which has no settings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transpose;

impl Algorithm for Transpose {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// ρ(B Bᵀ) by power iteration in each direction.
    fn transform(&self, collocation: &Tensor, _forecast: &Forecast) -> Transform {
        Transform::Transposed {
            rho: collocation
                .directions()
                .map(spectrum::largest_singular_value_squared)
                .product(),
        }
    }

    /// The power iterations.
    fn start_cost(&self, setup: &Setup) -> usize {
        let costs = setup.directions().map(spectrum::singular_value_cost);
        costs.fold(0, usize::saturating_add)
    }

    fn update(&self, _equations: &Equations) -> Box<dyn Update> {
        Box::new(Linear::endless())
    }

    /// All adjusting vectors are multiplied with Bᵀ together.
    fn relaxation(&self, _equations: &Equations) -> Option<Relaxation> {
        Some(Relaxation::Transformed { once: false })
    }
}
