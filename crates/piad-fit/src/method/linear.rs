//! `X ← X + U Δ` with a fixed linear map U, shared by all methods that have one.
//!
//! The residual becomes the step in place, so that no other vector is needed, and is computed anew
//! from the next control points. A level costs one application of U and one of B. Where the error
//! is also reported in transformed coordinates, `max_i ‖(U Δ)_i‖` (Deng13), the step is computed
//! when the residual is, and kept in a vector of its own until it is taken: no more work.

use super::equations::Equations;
use super::update::{Change, State, Update};
use crate::data::points::Points;
use crate::matrix::transform::Transform;
use crate::termination::Reason;

/// The update with the transform of the equations.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    /// Updates that are left until `(I − U B)ᵏ` has vanished, if it does.
    left: Option<usize>,
    /// The step from the current level, if its length is reported.
    step: Option<Points>,
}

impl Linear {
    /// An update that never stalls.
    pub(super) fn endless() -> Self {
        Self {
            left: None,
            step: None,
        }
    }

    /// An update that stalls after `levels` levels, as `(I − U B)ᵏ` is zero from there on.
    pub(super) fn nilpotent_after(levels: Option<usize>) -> Self {
        Self {
            left: levels,
            step: None,
        }
    }

    /// The same, which also reports the largest distance in transformed coordinates.
    pub(super) fn with_transformed_error(self, equations: &Equations) -> Self {
        let data = equations.setup.data();
        let step = Some(Points::zeros(data.dimension(), data.len()));
        Self { step, ..self }
    }
}

impl Update for Linear {
    fn copy(&self) -> Box<dyn Update> {
        Box::new(self.clone())
    }

    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        self.left = self.left.map(|left| left.saturating_sub(1));
        let factor = match (&equations.transform, &self.step) {
            (_, Some(_)) => 1.0,
            (Transform::Scale(omega), None) => *omega,
            _ => {
                // The residual becomes the step, and is computed anew.
                equations.transform(&mut state.residual, &mut state.scratch);
                1.0
            }
        };
        let steps = self.step.as_ref().unwrap_or(&state.residual);
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, step) in lanes.zip(steps.lanes()) {
            x.iter_mut()
                .zip(step)
                .for_each(|(x, step)| *x += factor * step);
        }
        Change::All {
            moved: state.control_points.len(),
        }
    }

    /// Prepares the step, if its length is reported.
    fn measured(&mut self, equations: &Equations, state: &mut State) {
        let Some(step) = &mut self.step else {
            return;
        };
        for (step, residual) in step.lanes_mut().iter_mut().zip(state.residual.lanes()) {
            step.copy_from_slice(residual);
        }
        equations.transform(step, &mut state.scratch);
    }

    /// The largest length of a step, without squares that could overflow.
    fn transformed_error(&self) -> Option<f64> {
        let step = self.step.as_ref()?;
        let length = |i: usize| {
            let lanes = step.lanes().iter();
            lanes.fold(0.0, |length, lane| f64::hypot(length, lane[i]))
        };
        let longer = |longest: f64, length: f64| {
            if length > longest || length.is_nan() {
                length
            } else {
                longest
            }
        };
        Some((0..step.len()).map(length).fold(0.0, longer))
    }

    fn stalled(&self) -> Option<Reason> {
        (self.left == Some(0)).then_some(Reason::Nilpotent)
    }
}
