//! The loop `X ← X + U (P − B X)`, its errors and its stop rules.

use std::sync::Arc;

use super::method::Method;
use super::norms::{FitError, Norms};
use super::points::Points;
use super::system::System;
use super::update::{self, Change, Stall, State, Update};

/// A least-squares fit whose residual shrinks by less than this part in one iteration has converged.
const STATIONARY: f64 = 1e-6;

/// A level of the iteration: how far the curve of these control points is from the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// The number of updates so far.
    pub iteration: usize,
    /// The distances from the data.
    pub error: FitError,
    /// By how much the last update has reduced the largest distance.
    pub rate: Option<f64>,
    /// How many control points the last update moved.
    pub moved: usize,
    /// Homogeneous fits: the first control point whose weight is not positive, and that weight.
    pub bad_weight: Option<(usize, f64)>,
}

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The largest distance is within the tolerance.
    Converged,
    /// A least-squares fit is at its minimum.
    Stationary,
    /// The last allowed level is reached, and the tolerance is not.
    Exhausted,
    /// The method cannot go on.
    Stalled(Stall),
    /// The distances are not finite numbers any more.
    Overflow,
}

/// The iteration of one problem at some level.
#[derive(Debug)]
pub struct Iteration {
    system: Arc<System>,
    update: Box<dyn Update>,
    state: State,
    norms: Norms,
    level: Level,
    /// The length of the residual, and its relative decrease in the last update.
    length: f64,
    decrease: f64,
}

impl Iteration {
    /// Level 0: of most methods, the data are the control points.
    pub fn start(system: Arc<System>) -> Self {
        let problem = Arc::clone(system.problem());
        let data = problem.data();
        let mut state = State {
            control_points: update::start(&system),
            residual: Points::zeros(data.dimension(), data.len()),
            scratch: vec![0.0; system.collocation().scratch()],
            changed: Vec::new(),
        };
        let mut norms = Norms::new(
            data,
            problem.grid(),
            problem.diagonal(),
            problem.is_homogeneous(),
            update::counted(&system),
        );
        let mut update = update::new(&system);
        compute_residual(&system, &mut state);
        if matches!(problem.method(), Method::Adaptive { .. }) {
            state.changed.extend(0..data.len());
        }
        update.measured(&system, &mut state);
        let mut error = norms.measure(data, &state.residual);
        error.gradient = update.gradient();
        let level = Level {
            iteration: 0,
            error,
            rate: None,
            moved: 0,
            bad_weight: bad_weight(&system, &state),
        };
        Self {
            system,
            update,
            state,
            length: norms.residual_length(),
            norms,
            level,
            decrease: 1.0,
        }
    }

    /// What does not change from level to level.
    pub fn system(&self) -> &Arc<System> {
        &self.system
    }

    /// The current level.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The free control points of the current level, in homogeneous coordinates if the fit is.
    pub fn control_points(&self) -> &Points {
        &self.state.control_points
    }

    /// The free control points that the last step moved, where it left others alone. All others
    /// are to the last bit what they were a level before.
    pub fn moved(&self) -> Option<&[usize]> {
        let moved = self.update.moved()?;
        let some = self.level.iteration > 0 && moved.len() < self.state.control_points.len();
        some.then_some(moved)
    }

    /// `Δ = P − B X`.
    pub fn residual(&self) -> &Points {
        &self.state.residual
    }

    /// Moves on to the next level.
    pub fn step(&mut self) -> Level {
        let Self {
            system,
            update,
            state,
            norms,
            ..
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
        let length = norms.residual_length();
        self.decrease = if self.length > 0.0 {
            1.0 - length / self.length
        } else {
            0.0
        };
        self.length = length;
        let rate = error.max / self.level.error.max;
        self.level = Level {
            iteration: self.level.iteration + 1,
            error,
            rate: rate.is_finite().then_some(rate),
            moved,
            bad_weight: bad_weight(&self.system, &self.state),
        };
        self.level
    }

    /// Whether the iteration ends at the current level, and why.
    pub fn outcome(&self) -> Option<Outcome> {
        let problem = self.system.problem();
        let Level {
            iteration, error, ..
        } = self.level;
        let updated_least_squares =
            matches!(problem.method(), Method::LeastSquares(_)) && iteration > 0;
        // Homogeneous distances can be infinite where a weight is not positive; residuals cannot.
        if !self.length.is_finite() {
            Some(Outcome::Overflow)
        } else if error.max <= problem.tolerance() {
            Some(Outcome::Converged)
        } else if updated_least_squares && self.decrease.abs() < STATIONARY {
            Some(Outcome::Stationary)
        } else if updated_least_squares && self.decrease < 0.0 {
            Some(Outcome::Stalled(Stall::Diverging))
        } else if let Some(stall) = self.update.stalled() {
            Some(Outcome::Stalled(stall))
        } else if iteration >= problem.max_iterations() {
            Some(Outcome::Exhausted)
        } else {
            None
        }
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

/// A control point that has no place, or whose curve may leave the hull of its control points.
fn bad_weight(system: &System, state: &State) -> Option<(usize, f64)> {
    if !system.problem().is_homogeneous() {
        return None;
    }
    let weights = state.control_points.lanes().last()?;
    let index = weights.iter().position(|weight| *weight <= 0.0)?;
    Some((index, weights[index]))
}
