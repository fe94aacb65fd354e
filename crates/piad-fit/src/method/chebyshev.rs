//! Chebyshev semi-iteration on [λ_min, 1], or a shorter interval: steps of classical PIA with
//! momentum.
//!
//! ```text
//! X ← X + d,   d ← ρ' ρ d + (2 ρ'/δ) Δ
//! ```
//!
//! (Golub, Varga 1961; [`Recurrence`] has the coefficients). With eigenvalues of B in [λ, 1] the
//! error shrinks in the long run by `(1 − √λ)/(1 + √λ)` in each level, where classical PIA has
//! `1 − λ`: on B-splines a third to an eighth of the iterations, for one more vector. The level is
//! an optimal polynomial in B applied to the error, and errors may rise for some levels; the
//! interval is chosen so that they do not rise far. Bases that are not totally positive are
//! refused, as their eigenvalues are not real.

use super::algorithm::{Algorithm, Demand, Progress};
use super::divergence;
use super::eigenvalues;
use super::equations::Equations;
use super::recurrence::Recurrence;
use super::relaxation::Relaxation;
use super::trial_run;
use super::update::{Change, State, Update};
use crate::data::points::Points;
use crate::invalid::Invalid;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::spectrum;
use crate::matrix::tensor::Tensor;
use crate::setup::Setup;
use crate::termination::{Outcome, Reason};
use crate::warning::Warning;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "chebyshev",
    title: "Chebyshev-accelerated PIA",
    summary: "Chebyshev semi-iteration: classical PIA with momentum, a third of its iterations on B-splines.",
    source: "Golub, Varga, Numer. Math. 3 (1961)",
};

/// Once Chebyshev steps have made the residual grow by this factor, it does not fall any more.
const HOPELESS: f64 = 1e4;

/// More iterations than this to a hundredth of the error get a warning.
const SLOW: usize = 200;

/// The method, which has no settings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chebyshev;

impl Algorithm for Chebyshev {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// Steps are chosen for eigenvalues that are real and positive.
    fn check_convergence(&self, setup: &Setup) -> Result<(), Invalid> {
        divergence::check_real(setup, INFO.name)
    }

    /// The last step, in the plain loop and in sweeps.
    fn demand(&self) -> Demand {
        Demand {
            vectors: 2,
            matrices: 4,
            bytes: 0,
        }
    }

    /// λ_min, and the rate of the long run on [λ_min, 1].
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        let lambda = eigenvalues::least(setup, collocation);
        Forecast {
            lambda_min: Some(lambda),
            rate: Some(spectrum::chebyshev_rate(lambda, lambda)),
            ..Forecast::default()
        }
    }

    /// Uses shorter intervals, unless steps by the least eigenvalue keep distances low.
    fn complete(&self, equations: &mut Equations) {
        for interval in trial_run::safe_intervals(equations) {
            if trial_run::stays_low(self, equations) {
                return;
            }
            let forecast = &mut equations.forecast;
            forecast.interval = Some(interval);
            let least = forecast.lambda_min.unwrap_or(1.0);
            forecast.rate = Some(spectrum::chebyshev_rate(least, interval));
        }
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        Box::new(Steps::new(equations))
    }

    /// Every control point moves by its own adjusting vector and its last step.
    fn relaxation(&self, equations: &Equations) -> Option<Relaxation> {
        Some(Relaxation::chebyshev(recurrence(&equations.forecast)))
    }

    /// Residuals that have grown this much will not fall any more.
    fn stop(&self, progress: &Progress) -> Option<Outcome> {
        let hopeless = progress.length > HOPELESS * progress.first_length;
        hopeless.then_some(Outcome::Stalled(Reason::Diverging))
    }

    /// Warns of a shorter interval, which takes more iterations, ill-conditioned bases, and slow
    /// steps.
    fn warnings(
        &self,
        forecast: &Forecast,
        predicted: Option<usize>,
        iterations: usize,
    ) -> Vec<Warning> {
        let least = forecast.lambda_min.unwrap_or(0.0);
        let begin = forecast.interval;
        let interval = begin.map(|begin| Warning::ShorterInterval { least, begin });
        let slow = Warning::of_rate(forecast, predicted, iterations);
        let steps = forecast
            .rate
            .map(|rate| (0.01_f64.ln() / rate.ln()).ceil() as usize);
        let steps = steps.filter(|&steps| slow.is_none() && steps > SLOW);
        let steps = steps.map(|iterations| Warning::SlowSteps { iterations });
        interval.into_iter().chain(slow).chain(steps).collect()
    }
}

/// The recurrence on the interval of the forecast, before the first update.
fn recurrence(forecast: &Forecast) -> Recurrence {
    Recurrence::new(forecast.interval.or(forecast.lambda_min).unwrap_or(1.0))
}

/// The steps of the plain loop.
#[derive(Clone, Debug)]
struct Steps {
    recurrence: Recurrence,
    /// The last step d.
    step: Points,
}

impl Steps {
    /// Before the first update.
    fn new(equations: &Equations) -> Self {
        let data = equations.setup.data();
        Self {
            recurrence: recurrence(&equations.forecast),
            step: Points::zeros(data.dimension(), data.len()),
        }
    }
}

impl Update for Steps {
    fn copy(&self) -> Box<dyn Update> {
        Box::new(self.clone())
    }

    /// `d ← momentum d + gain Δ`, `X ← X + d`.
    fn update(&mut self, _equations: &Equations, state: &mut State) -> Change {
        let (momentum, gain) = self.recurrence.advance();
        let lanes = state.control_points.lanes_mut().iter_mut();
        for ((x, step), residual) in lanes.zip(self.step.lanes_mut()).zip(state.residual.lanes()) {
            for ((x, step), delta) in x.iter_mut().zip(step).zip(residual) {
                *step = momentum * *step + gain * delta;
                *x += *step;
            }
        }
        Change::All {
            moved: state.control_points.len(),
        }
    }
}
