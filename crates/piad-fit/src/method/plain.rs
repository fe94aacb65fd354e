//! The plain loop: residual, update and errors one after the other.
//!
//! ```text
//! Δ = P − B X
//! X ← X + U Δ
//! ```
//!
//! It works for every method and every basis; the [sweeps](crate::iteration::sweep) must match it to the last bit. A
//! level costs an application of B and one of U, and three passes over memory.

use std::sync::Arc;

use super::equations::Equations;
use super::update::{Change, State, Update};
use crate::data::points::Points;
use crate::geometry::norms::{FitError, Norms};

/// An iteration by the plain loop: control points and residual of the current level, and the update
/// of the method.
#[derive(Debug)]
pub(crate) struct Plain {
    update: Box<dyn Update>,
    state: State,
    norms: Norms,
}

impl Plain {
    /// Level 0, from given control points, and its error, for which the `counted` points count; all
    /// of them without it.
    pub(crate) fn start(
        equations: &Equations,
        update: Box<dyn Update>,
        control_points: Arc<Points>,
        counted: Option<Vec<bool>>,
    ) -> (Self, FitError) {
        let setup = &equations.setup;
        let data = setup.data();
        let mut plain = Self {
            update,
            state: State {
                control_points: Arc::unwrap_or_clone(control_points),
                residual: Points::zeros(data.dimension(), data.len()),
                scratch: vec![0.0; equations.scratch()],
                changed: Vec::new(),
            },
            norms: Norms::new(setup, counted),
        };
        compute_residual(equations, &mut plain.state);
        plain.update.begin(equations, &mut plain.state);
        let mut error = plain.norms.measure(data, &plain.state.residual);
        error.gradient = plain.update.gradient();
        error.transformed = plain.update.transformed_error();
        (plain, error)
    }

    /// The same at the same level.
    pub(crate) fn copy(&self) -> Self {
        Self {
            update: self.update.copy(),
            state: self.state.clone(),
            norms: self.norms.clone(),
        }
    }

    /// Moves on to the next level: how many control points have moved, and the error. Where the
    /// update has changed the residual of some points only, only their errors are computed anew.
    pub(crate) fn step(&mut self, equations: &Equations) -> (usize, FitError) {
        let Self {
            update,
            state,
            norms,
        } = self;
        let change = update.update(equations, state);
        if let Change::All { .. } = change {
            compute_residual(equations, state);
        }
        update.measured(equations, state);
        let data = equations.setup.data();
        let (moved, mut error) = match change {
            Change::All { moved } | Change::Residual { moved } => {
                (moved, norms.measure(data, &state.residual))
            }
            Change::Some { moved } => {
                let changed = &state.changed;
                (moved, norms.measure_again(data, &state.residual, changed))
            }
        };
        error.gradient = update.gradient();
        error.transformed = update.transformed_error();
        (moved, error)
    }

    /// The update of the control points.
    pub(crate) fn update(&self) -> &dyn Update {
        &*self.update
    }

    /// The control points.
    pub(crate) fn control_points(&self) -> &Points {
        &self.state.control_points
    }

    /// `Δ = P − B X`.
    pub(crate) fn residual(&self) -> &Points {
        &self.state.residual
    }

    /// The length of the residual, up to a factor.
    pub(crate) fn residual_length(&self) -> f64 {
        self.norms.residual_length()
    }
}

/// `Δ = P − B X` for all coordinates, of P without the share of constants at the ends; that of missing points is zero.
pub(crate) fn compute_residual(equations: &Equations, state: &mut State) {
    let data = equations.setup.target().lanes();
    let State {
        control_points,
        residual,
        scratch,
        ..
    } = state;
    let operator = &equations.collocation;
    operator.apply_to_all(control_points, residual, scratch);
    for (residual, data) in residual.lanes_mut().iter_mut().zip(data) {
        for (residual, data) in residual.iter_mut().zip(data) {
            *residual = data - *residual;
        }
        if let Some(missing) = equations.setup.missing() {
            missing.clear(residual);
        }
    }
}
