//! The loop as it is written down: residual, update and errors one after the other.
//!
//! It does for every method and every basis; the [sweeps](super::sweep) are measured by it.

use std::sync::Arc;

use super::method::Method;
use super::norms::{FitError, Norms};
use super::points::Points;
use super::system::System;
use super::update::{self, Change, State, Update};

/// An iteration by the plain loop.
#[derive(Debug)]
pub struct Plain {
    update: Box<dyn Update>,
    state: State,
    norms: Norms,
}

impl Plain {
    /// Level 0, from given control points, and its error.
    pub fn start(system: &System, control_points: Arc<Points>) -> (Self, FitError) {
        let problem = system.problem();
        let data = problem.data();
        let mut plain = Self {
            update: update::new(system),
            state: State {
                control_points: Arc::unwrap_or_clone(control_points),
                residual: Points::zeros(data.dimension(), data.len()),
                scratch: vec![0.0; system.scratch()],
                changed: Vec::new(),
            },
            norms: Norms::new(problem, update::counted(system)),
        };
        compute_residual(system, &mut plain.state);
        if matches!(problem.method(), Method::Adaptive { .. }) {
            plain.state.changed.extend(0..data.len());
        }
        plain.update.measured(system, &mut plain.state);
        let mut error = plain.norms.measure(data, &plain.state.residual);
        error.gradient = plain.update.gradient();
        (plain, error)
    }

    /// Moves on to the next level: how many control points have moved, and the error.
    pub fn step(&mut self, system: &System) -> (usize, FitError) {
        let Self {
            update,
            state,
            norms,
        } = self;
        let change = update.update(system, state);
        if let Change::All { .. } = change {
            compute_residual(system, state);
        }
        update.measured(system, state);
        let data = system.problem().data();
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
        (moved, error)
    }

    /// How the control points are moved.
    pub fn update(&self) -> &dyn Update {
        &*self.update
    }

    /// The control points.
    pub fn control_points(&self) -> &Points {
        &self.state.control_points
    }

    /// `Δ = P − B X`.
    pub fn residual(&self) -> &Points {
        &self.state.residual
    }

    /// The length of the residual, up to a factor.
    pub fn residual_length(&self) -> f64 {
        self.norms.residual_length()
    }
}

/// `Δ = P − B X`.
fn compute_residual(system: &System, state: &mut State) {
    let data = system.problem().data().lanes();
    let lanes = state.residual.lanes_mut().iter_mut();
    for ((residual, x), data) in lanes.zip(state.control_points.lanes()).zip(data) {
        system.collocation().apply(x, residual, &mut state.scratch);
        for (residual, data) in residual.iter_mut().zip(data) {
            *residual = data - *residual;
        }
        if let Some(missing) = system.problem().missing() {
            missing.clear(residual);
        }
    }
}
