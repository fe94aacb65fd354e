//! `X ← X + U Δ` with a fixed linear map U.

use super::{Change, Stall, State, Update};
use crate::fit::system::{System, Transform};

/// Global, weighted, extended, transpose and direct.
#[derive(Debug)]
pub struct Linear {
    /// One coordinate of the step.
    step: Vec<f64>,
    /// Updates that are left until the extended method is exact.
    left: Option<usize>,
    /// Direct: the largest residual before the last update, and now.
    residuals: Option<(f64, f64)>,
}

impl Linear {
    /// Before the first update.
    pub fn new(system: &System) -> Self {
        let transform = system.transform();
        let scaled = matches!(transform, Transform::Scale(_));
        let extended = matches!(transform, Transform::Orthogonal(..));
        let direct = matches!(transform, Transform::Inverse(..));
        let count = system.problem().grid().count();
        Self {
            step: vec![0.0; if scaled { 0 } else { count }],
            left: system.forecast().exact_after.filter(|_| extended),
            residuals: direct.then_some((f64::INFINITY, f64::INFINITY)),
        }
    }
}

impl Update for Linear {
    fn update(&mut self, system: &System, state: &mut State) -> Change {
        self.left = self.left.map(|left| left.saturating_sub(1));
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, residual) in lanes.zip(state.residual.lanes()) {
            if let Transform::Scale(omega) = system.transform() {
                for (x, delta) in x.iter_mut().zip(residual) {
                    *x += omega * delta;
                }
            } else {
                system.apply_transform(residual, &mut self.step, &mut state.scratch);
                for (x, step) in x.iter_mut().zip(&self.step) {
                    *x += step;
                }
            }
        }
        Change::All {
            moved: state.control_points.len(),
        }
    }

    fn measured(&mut self, _system: &System, state: &mut State) {
        if let Some((before, now)) = &mut self.residuals {
            *before = *now;
            *now = state.residual.magnitude();
        }
    }

    fn stalled(&self) -> Option<Stall> {
        if self.left == Some(0) {
            return Some(Stall::Nilpotent);
        }
        // Solving once more refines the solution, until rounding is all that is left.
        self.residuals
            .filter(|(before, now)| *now >= before / 2.0 && now.is_finite())
            .map(|_| Stall::Rounding)
    }
}
