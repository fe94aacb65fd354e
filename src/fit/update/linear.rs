//! `X ← X + U Δ` with a fixed linear map U.

use super::{Change, Stall, State, Update};
use crate::fit::system::{System, Transform};

/// Global, weighted, extended, transpose and direct.
#[derive(Debug)]
pub struct Linear {
    /// Updates that are left until the extended method is exact.
    left: Option<usize>,
}

impl Linear {
    /// Before the first update.
    pub fn new(system: &System) -> Self {
        let extended = matches!(system.transform(), Transform::Orthogonal(..));
        Self {
            left: system.forecast().exact_after.filter(|_| extended),
        }
    }
}

impl Update for Linear {
    fn update(&mut self, system: &System, state: &mut State) -> Change {
        self.left = self.left.map(|left| left.saturating_sub(1));
        let factor = match system.transform() {
            Transform::Scale(omega) => *omega,
            _ => {
                // The residual becomes the step, and is computed anew.
                system.transform_all(&mut state.residual, &mut state.scratch);
                1.0
            }
        };
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, step) in lanes.zip(state.residual.lanes()) {
            x.iter_mut()
                .zip(step)
                .for_each(|(x, step)| *x += factor * step);
        }
        Change::All {
            moved: state.control_points.len(),
        }
    }

    fn stalled(&self) -> Option<Stall> {
        (self.left == Some(0)).then_some(Stall::Nilpotent)
    }
}
