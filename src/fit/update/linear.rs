//! `X ← X + U Δ` with a fixed linear map U.

use super::{Change, Stall, State, Update};
use crate::fit::method::Method;
use crate::fit::problem::Problem;
use crate::fit::system::{System, Transform};

/// Global, weighted, extended, transpose and direct.
#[derive(Debug)]
pub struct Linear {
    /// One coordinate of the step.
    step: Vec<f64>,
    updates: usize,
    /// The largest residual before the last update and after it.
    before: f64,
    now: f64,
}

impl Linear {
    /// Before the first update.
    pub fn new(problem: &Problem) -> Self {
        let scaled = matches!(problem.method(), Method::Global | Method::Weighted { .. });
        Self {
            step: vec![0.0; if scaled { 0 } else { problem.grid().count() }],
            updates: 0,
            before: f64::INFINITY,
            now: f64::INFINITY,
        }
    }
}

impl Update for Linear {
    fn update(&mut self, system: &System, state: &mut State) -> Change {
        self.updates += 1;
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

    fn measured(&mut self, system: &System, state: &mut State) {
        if matches!(system.transform(), Transform::Inverse(..)) {
            self.before = self.now;
            self.now = state.residual.magnitude();
        }
        // Kept here so that `stalled` can tell without the system.
        if let Some(levels) = system.forecast().exact_after
            && matches!(system.transform(), Transform::Orthogonal(..))
            && self.updates >= levels
        {
            self.updates = usize::MAX;
        }
    }

    fn stalled(&self) -> Option<Stall> {
        if self.updates == usize::MAX {
            return Some(Stall::Nilpotent);
        }
        // Solving once more refines the solution, until rounding is all that is left.
        (self.now >= self.before / 2.0 && self.now.is_finite()).then_some(Stall::Rounding)
    }
}
