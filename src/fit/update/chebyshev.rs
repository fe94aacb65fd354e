//! Chebyshev semi-iteration on [λ_min, 1], or a shorter interval: steps of classical PIA with momentum.

use super::{Change, State, Update};
use crate::fit::points::Points;
use crate::fit::system::System;

/// The coefficients of the two-term recurrence (Golub, Varga 1961): with the centre θ and the
/// half-width δ of the interval and σ = θ/δ, `d⁰ = Δ⁰/θ`, then `X ← X + d` and
/// `d ← ρ' ρ d + (2 ρ'/δ) Δ` with `ρ' = 1 / (2σ − ρ)`.
#[derive(Clone, Copy, Debug)]
pub struct Recurrence {
    theta: f64,
    delta: f64,
    rho: f64,
    begun: bool,
}

impl Recurrence {
    /// Before the first update.
    pub fn new(system: &System) -> Self {
        let forecast = system.forecast();
        let least = forecast.interval.or(forecast.lambda_min).unwrap_or(1.0);
        // All eigenvalues are one if B = I; the interval must not be empty.
        let delta = ((1.0 - least) / 2.0).max(f64::EPSILON);
        let theta = f64::midpoint(1.0, least);
        Self {
            theta,
            delta,
            rho: delta / theta,
            begun: false,
        }
    }

    /// Moves on to the next update: the factors of the last step and of the residual.
    pub fn advance(&mut self) -> (f64, f64) {
        if !self.begun {
            self.begun = true;
            return (0.0, 1.0 / self.theta);
        }
        let next = 1.0 / (2.0 * self.theta / self.delta - self.rho);
        let coefficients = (next * self.rho, 2.0 * next / self.delta);
        self.rho = next;
        coefficients
    }
}

/// Steps by that recurrence. Errors may rise for some levels: the interval is chosen so that they do not
/// rise far.
#[derive(Debug)]
pub struct Chebyshev {
    recurrence: Recurrence,
    step: Points,
}

impl Chebyshev {
    /// Before the first update.
    pub fn new(system: &System) -> Self {
        let data = system.problem().data();
        Self {
            recurrence: Recurrence::new(system),
            step: Points::zeros(data.dimension(), data.len()),
        }
    }
}

impl Update for Chebyshev {
    fn update(&mut self, _system: &System, state: &mut State) -> Change {
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
