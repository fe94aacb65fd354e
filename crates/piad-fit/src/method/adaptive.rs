//! Adaptive PIA: only the control points of data points that are far away move.
//!
//! ```text
//! X⁰ = P,   X ← X + ω Sᵏ (P − B X),   Sᵏ = diag(1 where ‖Δ_i‖ > threshold, else 0)
//! ```
//!
//! (Lin10, section 6), with ω = 1 unless another relaxation is given, 0 < ω < 2. The points are chosen anew at every
//! level: points that were near enough can move away again, and freezing them forever does not converge. Each point can
//! have a threshold of its own. A level costs as much as the supports of the points that move, fewer and fewer of them.
//! The rate of weighted PIA with this ω, `max(|1 − ω λ_min|, |1 − ω|)` and `1 − λ_min` for ω = 1, is an upper bound.
//! The fit ends when no point is further away than its threshold, even if the tolerance is less, or when all are within
//! the tolerance.

use super::algorithm::{Algorithm, Demand, Scope};
use super::eigenvalues;
use super::equations::Equations;
use super::omega::Omega;
use super::selection::{Choice, Selection, all_points};
use super::threshold::Threshold;
use super::update::{State, Update};
use crate::data::blocks::BLOCK;
use crate::geometry::norms::Norms;
use crate::invalid::Invalid;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::tensor::Tensor;
use crate::setup::Setup;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "adaptive",
    title: "Adaptive PIA",
    summary: "Only control points move whose data points are further away than a threshold, chosen anew at every level.",
    source: "Lin10, section 6",
};

/// Adaptive PIA with its threshold and its relaxation.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Adaptive {
    /// In data units, greater than 0: points that are no further away stay.
    pub threshold: Threshold,
    /// The relaxation ω, between 0 and 2; that of the papers is 1.
    pub omega: f64,
}

impl Adaptive {
    /// The same without the thresholds of points.
    pub(super) fn outline(&self) -> Self {
        let threshold = match self.threshold {
            Threshold::Each(_) => Threshold::Each([].into()),
            Threshold::All(_) => self.threshold.clone(),
        };
        Self { threshold, ..*self }
    }
}

impl Algorithm for Adaptive {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// At 0 all points would move forever.
    fn check(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        self.threshold.check(scope.grid.count())?;
        Omega::Given(self.omega).check()
    }

    /// Points that are nearer than the threshold are left alone; no distance above the largest one
    /// is.
    fn tolerance(&self, requested: f64) -> f64 {
        requested.max(self.threshold.largest())
    }

    /// Checks of other methods, and of the thresholds of points.
    fn demand(&self) -> Demand {
        let each = match &self.threshold {
            Threshold::All(_) => 0,
            Threshold::Each(each) => size_of_val(&**each),
        };
        Demand {
            bytes: each,
            ..Demand::default()
        }
    }

    /// The rate of all points, as an upper bound: principal blocks have larger eigenvalues.
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        eigenvalues::relaxed(setup, collocation, Omega::Given(self.omega))
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        let far = Far {
            threshold: self.threshold.clone(),
            norms: all_points(equations),
        };
        Box::new(Selection::new(equations, far, Vec::new()))
    }

    /// The points that move have larger eigenvalues than all together.
    fn rate_is_sharp(&self) -> bool {
        false
    }

    /// The largest distance does not decide for points with thresholds of their own.
    fn decays(&self) -> bool {
        !self.threshold.is_each()
    }
}

/// The points whose data point is further away than the threshold.
#[derive(Clone, Debug)]
struct Far {
    threshold: Threshold,
    norms: Norms,
}

impl Choice for Far {
    const VARIES: bool = true;

    /// With one threshold for all points the fit ends when the largest distance is below it.
    fn decides_the_end(&self) -> bool {
        self.threshold.is_each()
    }

    /// At level 0 all points have changed.
    fn begin(&mut self, state: &mut State) {
        state.changed.extend(0..state.residual.len());
    }

    fn choose(&mut self, equations: &Equations, state: &State, active: &mut Vec<usize>) {
        let data = equations.setup.data();
        let mut room = [0.0; BLOCK];
        active.clear();
        // A point whose residual has not changed is as near as it was.
        let runs = state.changed.chunk_by(|a, b| a + 1 == *b);
        for run in runs.flat_map(|run| run.chunks(BLOCK)) {
            let distances = &mut room[..run.len()];
            self.norms
                .distances(data, &state.residual, run[0], distances);
            let points = run.iter().copied().zip(distances);
            let far = points.filter(|(index, distance)| **distance > self.threshold.of(*index));
            active.extend(far.map(|(index, _)| index));
        }
    }
}
