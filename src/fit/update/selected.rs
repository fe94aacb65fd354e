//! Fits that move only some control points: local (Lin10, sections 2–5) and adaptive (section 6).
//!
//! Moving control point i by δ changes the residual only where its basis function does not vanish.
//! So an update costs as much as the supports of the moved points, whatever the number of data.

use std::sync::Arc;

use super::{Change, State, Update};
use crate::fit::linear::columns::Columns;
use crate::fit::norms::Norms;
use crate::fit::system::System;
use crate::fit::tensor::TensorColumns;

/// Moves selected control points by their adjusting vectors.
#[derive(Debug)]
pub struct Selected {
    choice: Choice,
    /// The control points that the next update moves, increasing.
    active: Vec<usize>,
    /// Those that the last one moved, where each update has its own.
    moved: Vec<usize>,
    /// Their adjusting vectors, one coordinate.
    deltas: Vec<f64>,
    matrix: Arc<TensorColumns>,
    /// The update that last changed the residual of each point.
    stamps: Vec<u32>,
    stamp: u32,
    /// Multiplications of computing the whole residual anew, and of an update by one point.
    whole_cost: usize,
    point_cost: usize,
}

/// How the moved control points are chosen.
#[derive(Debug)]
enum Choice {
    /// Always the same.
    Fixed,
    /// Those of one row, until they are within the tolerance; then the next row's.
    Rows(RowSweep),
    /// Those whose data point is further away than the threshold.
    Far { threshold: f64, norms: Norms },
}

/// Sweeps over rows with something to adjust. One pass is not enough: later rows disturb earlier
/// ones (Lin10, section 5; repeated until all are within the tolerance).
#[derive(Debug)]
struct RowSweep {
    rows: Vec<Vec<usize>>,
    current: usize,
    norms: Norms,
}

impl Selected {
    /// Of a local fit.
    pub fn local(system: &System, row_by_row: bool) -> Self {
        let grid = system.problem().grid();
        let mut indices = match system.problem().selected() {
            Some(indices) => indices.to_vec(),
            None => (0..grid.count()).collect(),
        };
        indices.sort_unstable();
        if !row_by_row {
            return Self::new(system, Choice::Fixed, indices);
        }
        let rows = indices
            .chunk_by(|a, b| a / grid.columns == b / grid.columns)
            .map(<[usize]>::to_vec)
            .collect();
        let sweep = RowSweep {
            rows,
            current: 0,
            norms: all_points(system),
        };
        Self::new(system, Choice::Rows(sweep), Vec::new())
    }

    /// Of an adaptive fit.
    pub fn adaptive(system: &System, threshold: f64) -> Self {
        let norms = all_points(system);
        Self::new(system, Choice::Far { threshold, norms }, Vec::new())
    }

    fn new(system: &System, choice: Choice, active: Vec<usize>) -> Self {
        let collocation = system.collocation();
        let grid = system.problem().grid();
        let matrix = Arc::clone(collocation.columns());
        let width_u = matrix.u.longest();
        let width_v = matrix.v.as_ref().map(Columns::longest);
        let point_cost = width_u * width_v.unwrap_or(1);
        let whole = width_u + width_v.unwrap_or(0);
        Self {
            choice,
            active,
            moved: Vec::new(),
            deltas: Vec::new(),
            matrix,
            stamps: vec![0; grid.count()],
            stamp: 0,
            whole_cost: whole * grid.count(),
            point_cost,
        }
    }

    /// `Δ ← Δ − B δ` for the moved points; notes which points have changed.
    fn update_residual(&mut self, columns: usize, state: &mut State) {
        let mut deltas = std::mem::take(&mut self.deltas);
        for (x, residual) in state
            .control_points
            .lanes_mut()
            .iter_mut()
            .zip(state.residual.lanes_mut())
        {
            deltas.clear();
            deltas.extend(self.active.iter().map(|&index| residual[index]));
            for (&index, delta) in self.active.iter().zip(&deltas) {
                x[index] += delta;
                self.matrix.visit(index, columns, |row, value| {
                    residual[row] -= value * delta;
                });
            }
        }
        self.deltas = deltas;
        self.note_changes(columns, &mut state.changed);
    }

    fn note_changes(&mut self, columns: usize, changed: &mut Vec<usize>) {
        self.stamp += 1;
        let stamp = self.stamp;
        let mut stamps = std::mem::take(&mut self.stamps);
        changed.clear();
        for &index in &self.active {
            self.matrix.visit(index, columns, |row, _| {
                if stamps[row] != stamp {
                    stamps[row] = stamp;
                    changed.push(row);
                }
            });
        }
        changed.sort_unstable();
        self.stamps = stamps;
    }
}

fn all_points(system: &System) -> Norms {
    Norms::new(system.problem(), None)
}

impl Update for Selected {
    fn update(&mut self, system: &System, state: &mut State) -> Change {
        let moved = self.active.len();
        if moved * self.point_cost < self.whole_cost {
            self.update_residual(system.problem().grid().columns, state);
            return Change::Some { moved };
        }
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, residual) in lanes.zip(state.residual.lanes()) {
            for &index in &self.active {
                x[index] += residual[index];
            }
        }
        state.changed.clear();
        state.changed.extend(0..state.residual.len());
        Change::All { moved }
    }

    fn measured(&mut self, system: &System, state: &mut State) {
        let data = system.problem().data();
        let residual = &state.residual;
        if !matches!(self.choice, Choice::Fixed) {
            std::mem::swap(&mut self.active, &mut self.moved);
        }
        match &mut self.choice {
            Choice::Fixed => {}
            Choice::Far { threshold, norms } => {
                // A point whose residual has not changed is as near as it was.
                let far = |index: &usize| norms.distance(data, residual, *index) > *threshold;
                self.active.clear();
                self.active
                    .extend(state.changed.iter().copied().filter(far));
            }
            Choice::Rows(sweep) => {
                let tolerance = system.problem().tolerance();
                let done = |row: &[usize]| {
                    row.iter()
                        .all(|&index| sweep.norms.distance(data, residual, index) <= tolerance)
                };
                // At most once around: if all are done, the fit has converged.
                for _ in 0..sweep.rows.len() {
                    if !done(&sweep.rows[sweep.current]) {
                        break;
                    }
                    sweep.current = (sweep.current + 1) % sweep.rows.len();
                }
                self.active.clone_from(&sweep.rows[sweep.current]);
            }
        }
    }

    fn moved(&self) -> Option<&[usize]> {
        Some(match self.choice {
            Choice::Fixed => &self.active,
            Choice::Rows(_) | Choice::Far { .. } => &self.moved,
        })
    }
}
