//! Chebyshev semi-iteration on [λ_min, 1]: steps of classical PIA with momentum.

use super::{Change, State, Update};
use crate::fit::points::Points;
use crate::fit::system::System;

/// The two-term recurrence (Golub, Varga 1961): with the centre θ and the half-width δ of the
/// interval and σ = θ/δ, `d⁰ = Δ⁰/θ`, then `X ← X + d` and
/// `d ← ρ' ρ d + (2 ρ'/δ) Δ` with `ρ' = 1 / (2σ − ρ)`. Single errors may rise for a few levels.
#[derive(Debug)]
pub struct Chebyshev {
    theta: f64,
    delta: f64,
    rho: f64,
    step: Points,
    begun: bool,
}

impl Chebyshev {
    /// Before the first update.
    pub fn new(system: &System) -> Self {
        let problem = system.problem();
        let data = problem.data();
        let least = system.forecast().lambda_min.unwrap_or(1.0);
        // All eigenvalues are one if B = I; the interval must not be empty.
        let delta = ((1.0 - least) / 2.0).max(f64::EPSILON);
        let theta = f64::midpoint(1.0, least);
        Self {
            theta,
            delta,
            rho: delta / theta,
            step: Points::zeros(data.dimension(), data.len()),
            begun: false,
        }
    }
}

impl Update for Chebyshev {
    fn update(&mut self, _system: &System, state: &mut State) -> Change {
        let next = 1.0 / (2.0 * self.theta / self.delta - self.rho);
        let (momentum, gain) = if self.begun {
            (next * self.rho, 2.0 * next / self.delta)
        } else {
            (0.0, 1.0 / self.theta)
        };
        let lanes = state.control_points.lanes_mut().iter_mut();
        for ((x, step), residual) in lanes.zip(self.step.lanes_mut()).zip(state.residual.lanes()) {
            for ((x, step), delta) in x.iter_mut().zip(step).zip(residual) {
                *step = momentum * *step + gain * delta;
                *x += *step;
            }
        }
        if self.begun {
            self.rho = next;
        }
        self.begun = true;
        Change::All {
            moved: state.control_points.len(),
        }
    }
}
