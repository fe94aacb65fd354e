//! The direct solution of the interpolation equations: level 1 is the limit of all other methods.
//!
//! ```text
//! X⁰ = P,   X ← X + B⁻¹ (P − B X),   U = B⁻¹
//! ```
//!
//! B is factorized once, banded in O(n p²) for B-splines and densely in O(n³) for polynomials, and
//! a level costs O(n p) or O(n²). Further levels refine the solution (iterative refinement), until
//! the residual shrinks no more: what is left is rounding.

use super::algorithm::{Algorithm, Progress};
use super::equations::Equations;
use super::linear::Linear;
use super::relaxation::Relaxation;
use super::update::Update;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;
use crate::termination::{Outcome, Reason};

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "direct",
    title: "Direct interpolation",
    summary: "The interpolation equations are solved by an LU decomposition, so that level 1 is the limit.",
    source: "PT97, section 9.2.1",
};

/// Solving once more refines a direct fit, until its residual shrinks by no more than this part:
/// what is left is rounding.
const REFINED: f64 = 0.5;

/// The method, which has no settings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direct;

impl Algorithm for Direct {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// Level 1 is the limit.
    fn forecast(&self, _setup: &Setup, _collocation: &Tensor) -> Forecast {
        Forecast {
            exact_after: Some(1),
            ..Forecast::default()
        }
    }

    /// A factorization for each direction.
    fn transform(&self, collocation: &Tensor, _forecast: &Forecast) -> Transform {
        let (u, v) = (&collocation.u, collocation.v.as_ref());
        Transform::Inverse(u.inverse(), v.map(|v| v.inverse()))
    }

    fn update(&self, _equations: &Equations) -> Box<dyn Update> {
        Box::new(Linear::endless())
    }

    /// One pass measures a level; the step is solved for.
    fn relaxation(&self, _equations: &Equations) -> Option<Relaxation> {
        Some(Relaxation::Transformed { once: true })
    }

    /// There is nothing to predict.
    fn ends_when_exact(&self) -> bool {
        true
    }

    /// Level 1 is the limit, whatever level 0 is.
    fn first_end(&self) -> usize {
        1
    }

    /// When solving once more has not halved the residual.
    fn stop(&self, progress: &Progress) -> Option<Outcome> {
        let refined = progress.iteration > 0 && progress.decrease <= REFINED;
        refined.then_some(Outcome::Stalled(Reason::Rounding))
    }
}
