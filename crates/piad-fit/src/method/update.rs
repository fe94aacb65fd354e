//! How the plain loop moves control points: `X ← X + U Δ`, one level at a time.
//!
//! An update is given X and Δ, and moves X. If it knows how Δ changes, it brings Δ up to date, too;
//! otherwise the loop computes `Δ = P − B X` anew. It is called once for each level, and runs over
//! all points by itself.

use std::fmt::Debug;

use super::equations::Equations;
use crate::data::points::Points;
use crate::termination::{Outcome, Reason};

/// What an update has changed.
#[derive(Debug)]
pub(crate) enum Change {
    /// Any control point: the residual is to be computed.
    All {
        /// The number of control points that moved.
        moved: usize,
    },
    /// Any control point; the residual is up to date.
    Residual {
        /// The number of control points that moved.
        moved: usize,
    },
    /// Some control points; the residual is up to date, and has changed at the points of
    /// [`State::changed`] only.
    Some {
        /// The number of control points that moved.
        moved: usize,
    },
}

/// What an update works on.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// The free control points X.
    pub control_points: Points,
    /// The residual Δ = P − B X.
    pub residual: Points,
    /// Room for one coordinate, as the maps of the equations need it.
    pub scratch: Vec<f64>,
    /// The points whose residual an update has changed, increasing.
    pub changed: Vec<usize>,
}

/// A way to move control points.
pub(crate) trait Update: Debug + Send {
    /// Moves the control points once.
    fn update(&mut self, equations: &Equations, state: &mut State) -> Change;

    /// A copy of the update at the same level, from which the iteration can continue.
    fn copy(&self) -> Box<dyn Update>;

    /// Called when the residual of level 0 is known.
    fn begin(&mut self, equations: &Equations, state: &mut State) {
        self.measured(equations, state);
    }

    /// Called when the residual is known after an update.
    fn measured(&mut self, _equations: &Equations, _state: &mut State) {}

    /// The control points that the last update moved, if it moved only some.
    fn moved(&self) -> Option<&[usize]> {
        None
    }

    /// The squared gradient of a least-squares fit, `‖Aᵀr‖²/‖Aᵀr⁰‖²`.
    fn gradient(&self) -> Option<f64> {
        None
    }

    /// The largest distance in transformed coordinates, `max_i ‖(U Δ)_i‖`, if requested.
    fn transformed_error(&self) -> Option<f64> {
        None
    }

    /// Returns true if there is something left to do, although no distance is above the tolerance of the method.
    fn is_unfinished(&self) -> bool {
        false
    }

    /// Returns true if distances within the tolerance do not end the fit yet, as it minimizes more than distances.
    fn seeks_minimum(&self) -> bool {
        false
    }

    /// The outcome if the fit ends by what the update has measured.
    fn outcome(&self) -> Option<Outcome> {
        None
    }

    /// The reason if another update would change nothing.
    fn stalled(&self) -> Option<Reason> {
        None
    }
}
