//! Fits that move only some control points, shared by the local and the adaptive method.
//!
//! Moving control point i by δ changes the residual only in the support of its basis function:
//!
//! ```text
//! X_i ← X_i + ω Δ_i,   Δ ← Δ − B e_i ω Δ_i     for all i that move
//! ```
//!
//! So the cost of an update is that of the supports of the moved points, about `|I| (p + 1)`
//! multiplications for each coordinate of a curve of degree p and `|I| (p + 1)²` of a surface,
//! whatever the number of data; and only the errors of the points that have changed are measured
//! again. Computing the whole residual anew takes more multiplications, but whole arrays at a time:
//! where that is quicker, it is computed anew.

use std::fmt::Debug;

use super::equations::Equations;
use super::update::{Change, State, Update};
use crate::geometry::norms::Norms;
use crate::matrix::tensor::Tensor;

/// The cost of a multiplication of an entry that is looked up, in multiplications of whole arrays.
const LOOK_UP: usize = 6;

/// The rule by which the moved control points are chosen.
pub(super) trait Choice: Clone + Debug + Send + 'static {
    /// True if each update has its own, rather than all of them the same.
    const VARIES: bool;

    /// True if a fit continues while there are points to move, although no distance is above the
    /// tolerance.
    fn decides_the_end(&self) -> bool {
        false
    }

    /// Prepares the choice at level 0.
    fn begin(&mut self, _state: &mut State) {}

    /// Chooses the control points that the next update moves, increasing, now that the residual is
    /// known.
    fn choose(&mut self, equations: &Equations, state: &State, active: &mut Vec<usize>);
}

/// Moves the chosen control points by ω times their adjusting vectors.
#[derive(Clone, Debug)]
pub(super) struct Selection<C> {
    choice: C,
    /// The relaxation ω.
    omega: f64,
    /// The control points that the next update moves, increasing.
    active: Vec<usize>,
    /// Those that the last one moved, where each update has its own.
    moved: Vec<usize>,
    /// The steps of the active ones, one coordinate after the other.
    deltas: Vec<f64>,
    /// The number of the update that last changed the residual of each point, 0 if none has.
    stamps: Vec<u32>,
    /// The number of the current update.
    stamp: u32,
    /// Multiplications of computing the whole residual anew.
    whole_cost: usize,
    /// The same of an update by one point: the size of the support of its function, looked up.
    point_cost: usize,
}

/// The distances of all points, whether they move or not.
pub(super) fn all_points(equations: &Equations) -> Norms {
    Norms::new(&equations.setup, None)
}

impl<C: Choice> Selection<C> {
    /// Before the first update, which moves `active` (increasing) unless the choice varies. The
    /// relaxation is that of the forecast.
    pub(super) fn new(equations: &Equations, choice: C, active: Vec<usize>) -> Self {
        let count = equations.setup.grid().count();
        let tensor = equations.collocation.tensor();
        let widths = || tensor.into_iter().flat_map(Tensor::widths);
        Self {
            choice,
            omega: equations.forecast.omega.unwrap_or(1.0),
            active,
            moved: Vec::new(),
            deltas: Vec::new(),
            stamps: vec![0; count],
            stamp: 0,
            whole_cost: widths().sum::<usize>() * count,
            point_cost: LOOK_UP * widths().product::<usize>(),
        }
    }

    /// `X ← X + δ` and `Δ ← Δ − B δ` for the active points; notes which points have changed, each
    /// once and in increasing order.
    fn update_residual(&mut self, matrix: &Tensor, state: &mut State) {
        let State {
            control_points,
            residual,
            changed,
            ..
        } = state;
        self.deltas.clear();
        for residual in residual.lanes() {
            let steps = self
                .active
                .iter()
                .map(|&index| self.omega * residual[index]);
            self.deltas.extend(steps);
        }
        self.stamp += 1;
        changed.clear();
        for (k, &index) in self.active.iter().enumerate() {
            let column = matrix.column(index);
            let deltas = self.deltas[k..].iter().step_by(self.active.len());
            let lanes = control_points.lanes_mut().iter_mut();
            for ((x, residual), delta) in lanes.zip(residual.lanes_mut()).zip(deltas) {
                x[index] += delta;
                for &(row, value) in &column {
                    residual[row] -= value * delta;
                }
            }
            for (row, _) in column {
                if self.stamps[row] != self.stamp {
                    self.stamps[row] = self.stamp;
                    changed.push(row);
                }
            }
        }
        changed.sort_unstable();
    }
}

impl<C: Choice> Update for Selection<C> {
    fn copy(&self) -> Box<dyn Update> {
        Box::new(self.clone())
    }

    /// Moves the chosen points, and brings the residual up to date where that is less work than all
    /// of it.
    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        let moved = self.active.len();
        let few = moved * self.point_cost < self.whole_cost;
        if let Some(matrix) = equations.collocation.tensor().filter(|_| few) {
            self.update_residual(matrix, state);
            return Change::Some { moved };
        }
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, residual) in lanes.zip(state.residual.lanes()) {
            for &index in &self.active {
                x[index] += self.omega * residual[index];
            }
        }
        state.changed.clear();
        state.changed.extend(0..state.residual.len());
        Change::All { moved }
    }

    fn begin(&mut self, equations: &Equations, state: &mut State) {
        self.choice.begin(state);
        self.measured(equations, state);
    }

    fn measured(&mut self, equations: &Equations, state: &mut State) {
        if C::VARIES {
            std::mem::swap(&mut self.active, &mut self.moved);
            self.choice.choose(equations, state, &mut self.active);
        }
    }

    /// While a choice that decides the end has points to move.
    fn is_unfinished(&self) -> bool {
        self.choice.decides_the_end() && !self.active.is_empty()
    }

    /// The points that the last update moved: of a choice that varies not those of the next one.
    fn moved(&self) -> Option<&[usize]> {
        Some(if C::VARIES { &self.moved } else { &self.active })
    }
}
