//! Extended PIA: the transform of a QR decomposition makes the fit exact after finitely many
//! levels.
//!
//! ```text
//! B = Q R,   H = diag(1 / r_ii),   U = H Qᵀ
//! X⁰ = U P or P,   X ← X + U (P − B X)
//! ```
//!
//! (Deng13 (9)). `I − U B = I − H R` is strictly upper triangular, so that its power n + 1
//! vanishes, whatever the basis and the parameters: the error is zero after n + 1 levels from P, or
//! n from `U P`, with n the highest index of a control point. On surfaces `U = U_u ⊗ U_v`, and it
//! takes m + n + 1 levels with highest indices m and n, not (m + 1)(n + 1). The error is not
//! monotone: it can grow by many orders of magnitude before it vanishes, and rounding of that is
//! what is left; a trial run finds out how much. For B-splines R is banded: O(n p²) to prepare, O(n
//! p) for each level; that of closed ones has full columns at its end.
//!
//! Levels between depend on the order of the columns in the decomposition. It is the natural one, so
//! that they are those of the paper. Up to degree 3, of closed curves 4, their errors stay of the
//! order of that of level 0; from there on they grow exponentially with the number of points.

use std::sync::Arc;

use super::algorithm::{Algorithm, Demand};
use super::equations::Equations;
use super::linear::Linear;
use super::trial_run;
use super::update::Update;
use crate::data::points::Points;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;
use crate::warning::Warning;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "extended",
    title: "Extended PIA",
    summary: "A QR decomposition of the collocation matrix gives a transform with which the fit is exact after finitely many levels.",
    source: "Deng13 (9)",
};

/// Extended PIA with its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Extended {
    /// The control points of level 0.
    pub start: Start,
    /// True if the error is also reported in transformed coordinates, `max_i ‖(U Δ)_i‖`: how far
    /// control points move in the next update.
    pub transformed_error: bool,
}

/// Level 0 of the extended method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Start {
    /// `X⁰ = U P`.
    #[default]
    Transformed,
    /// `X⁰ = P`.
    Data,
}

impl Extended {
    /// The number of levels after which the error is zero. The start `U P` is one ahead of all
    /// others.
    fn nilpotency(self, setup: &Setup) -> usize {
        let highest: usize = setup
            .directions()
            .map(|direction| direction.free() - 1)
            .sum();
        match self.start {
            Start::Transformed if setup.start().is_none() => highest,
            _ => highest + 1,
        }
    }
}

impl Algorithm for Extended {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// The step, if its length is reported.
    fn demand(&self) -> Demand {
        let usual = Demand::default();
        Demand {
            vectors: usual.vectors + usize::from(self.transformed_error),
            ..usual
        }
    }

    /// The level at which the error is zero, but for rounding.
    fn forecast(&self, setup: &Setup, _collocation: &Tensor) -> Forecast {
        Forecast {
            exact_after: Some(self.nilpotency(setup)),
            ..Forecast::default()
        }
    }

    /// The QR decomposition of each direction.
    fn transform(&self, collocation: &Tensor, _forecast: &Forecast) -> Transform {
        let (u, v) = (&collocation.u, collocation.v.as_ref());
        Transform::Orthogonal(u.orthogonal(), v.map(|v| v.orthogonal()))
    }

    /// How much rounding will leave, by a trial run.
    fn complete(&self, equations: &mut Equations) {
        equations.forecast.rounding = trial_run::left_by_rounding(self, equations);
    }

    /// `U P`, which is one level ahead, unless a start from the data is requested.
    fn start(&self, equations: &Equations) -> Arc<Points> {
        match self.start {
            Start::Data => Arc::clone(equations.setup.data()),
            Start::Transformed => {
                let mut control_points = Points::clone(equations.setup.target());
                equations.transform(&mut control_points, &mut vec![0.0; equations.scratch()]);
                Arc::new(control_points)
            }
        }
    }

    /// It stalls when `(I − U B)ᵏ` has vanished: what remains is rounding.
    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        let update = Linear::nilpotent_after(equations.forecast.exact_after);
        Box::new(match self.transformed_error {
            true => update.with_transformed_error(equations),
            false => update,
        })
    }

    /// Warns of rounding that leaves more than the tolerance.
    fn warnings(
        &self,
        forecast: &Forecast,
        _predicted: Option<usize>,
        _iterations: usize,
    ) -> Vec<Warning> {
        let rounding = forecast.rounding.zip(forecast.exact_after);
        let rounding = rounding.map(|(left, iterations)| Warning::Rounding { left, iterations });
        rounding.into_iter().collect()
    }
}

#[cfg(test)]
mod tests;
