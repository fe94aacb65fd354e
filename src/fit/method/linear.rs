//! `X ← X + U Δ` with a fixed linear map U, shared by all methods that have one.
//!
//! The residual becomes the step in place, so that no other vector is needed, and is computed anew
//! from the next control points. A level costs one application of U and one of B.

use super::update::{Change, State, Update};
use crate::fit::equations::Equations;
use crate::fit::outcome::Stall;
use crate::fit::transform::Transform;

/// The update with the transform of the equations.
#[derive(Debug)]
pub(super) struct Linear {
    /// Updates that are left until `(I − U B)ᵏ` has vanished, if it does.
    left: Option<usize>,
}

impl Linear {
    /// An update that goes on as long as it is asked to.
    pub(super) fn endless() -> Self {
        Self { left: None }
    }

    /// An update that stalls after so many levels, as `(I − U B)ᵏ` is zero from there on.
    pub(super) fn nilpotent_after(levels: Option<usize>) -> Self {
        Self { left: levels }
    }
}

impl Update for Linear {
    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        self.left = self.left.map(|left| left.saturating_sub(1));
        let factor = match &equations.transform {
            Transform::Scale(omega) => *omega,
            _ => {
                // The residual becomes the step, and is computed anew.
                equations.transform(&mut state.residual, &mut state.scratch);
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
