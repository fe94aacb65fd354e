//! After the last attempt: knot lines are removed from the best surface of a grid, first several at once, then one by
//! one.
//!
//! The distances of a direction give a knot density, but not that knots around a crease belong together. The lines that
//! cost least are removed until none can be.

use super::super::lines::curves;
use super::SurfaceSchedule;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::knot_selection::pruning::{fewer, in_batches};

/// Single lines of a direction that are tried without success.
const CANDIDATES: usize = 6;

impl SurfaceSchedule {
    /// The best level without some lines of a direction; returns true if there is such a level within the tolerance.
    pub(super) fn prune(&mut self) -> bool {
        let Some(best) = self.levels.best.clone() else {
            return false;
        };
        // A line of u has as many control points as there are lines of v.
        let [rows, columns] = best.counts();
        let first = usize::from(rows > columns);
        [first, 1 - first]
            .into_iter()
            .any(|axis| self.prune_lines(&best, axis))
    }

    fn prune_lines(&mut self, best: &Level<2>, axis: usize) -> bool {
        let line = &best.lines[axis];
        let curves = curves(&best.control_points, best.counts(), axis);
        let mut batch = self.batches[axis];
        let mut succeeds = |line| self.is_within_without(best, axis, line);
        let is_found = in_batches(&mut batch, (line, &curves), 1, &mut succeeds)
            || fewer(line, &curves).take(CANDIDATES).any(succeeds);
        self.batches[axis] = batch;
        is_found
    }

    /// Fits over fewer lines of a direction, and returns the level if it is within the tolerance.
    fn is_within_without(&mut self, best: &Level<2>, axis: usize, line: Breaks) -> bool {
        if self.prunings == 0 || !line.is_determined(self.data.parameters(axis)) {
            return false;
        }
        self.prunings -= 1;
        let mut lines = best.lines.clone();
        lines[axis] = line;
        let fit = self.fit(lines);
        self.levels.accept(fit.map(|fit| fit.level))
    }
}
