//! After the last attempt: knots are removed from the best level, where data are sparse, first several at once, then
//! one by one.

use std::sync::Arc;

use super::super::equations::Minimum;
use super::super::minimax::Weights;
use super::super::pruning::{fewer, in_batches};
use super::{Level, NEAR, Schedule, Values, WEIGHINGS, values_of};
use crate::knot_selection::breaks::Breaks;

/// Single knots are removed if there are fewer data than this for each control point.
const SPARSE: usize = 8;

/// The number of removals tried in a row without success.
const CANDIDATES: usize = 12;

/// With fewer spans knots are removed one by one.
const MANY: usize = 64;

/// At least this part of the knots is removed at once.
const FEWEST: usize = 128;

impl<M: Minimum> Schedule<M> {
    /// The best level without some of its knots; returns true if there is such a level within the tolerance.
    pub(super) fn prune(&mut self) -> bool {
        let sparse = |it: &Arc<Level<1>>| SPARSE * it.count() > self.points.len();
        let Some(best) = self.levels.best.clone().filter(sparse) else {
            return false;
        };
        self.prune_several(&best) || self.prune_one(&best)
    }

    /// Without several knots at once: half as many after each failure.
    fn prune_several(&mut self, best: &Level<1>) -> bool {
        let ([line], mut batch) = (&best.lines, self.batch);
        let fewest = (line.spans() / FEWEST).max(1);
        let curve = (line, &best.control_points);
        let is_found = line.spans() >= MANY
            && in_batches(&mut batch, curve, fewest, |line| {
                let level = self.fit_over(line, best);
                self.levels.accept(level)
            });
        self.batch = batch;
        is_found
    }

    /// Without one of its knots.
    fn prune_one(&mut self, best: &Level<1>) -> bool {
        let ([line], tolerance) = (&best.lines, self.options.tolerance);
        let enough = (self.prunings / line.spans()).clamp(1, CANDIDATES);
        let mut nearest: Option<Arc<Level<1>>> = None;
        let candidates = fewer(line, &best.control_points).take(CANDIDATES);
        for (tried, line) in candidates.enumerate() {
            let largest = nearest
                .as_ref()
                .map_or(f64::INFINITY, |it| it.distances.max);
            if self.prunings == 0 || tried >= enough && largest <= tolerance {
                break;
            }
            self.prunings -= 1;
            let level = self.fit_over(line, best);
            nearest = level.filter(|it| it.distances.max < largest).or(nearest);
        }
        let level = nearest.and_then(|nearest| self.weighed(nearest));
        self.levels.accept(level)
    }

    /// A level over other knots than the best one has, at its parameters.
    pub(super) fn fit_over(&self, line: Breaks, best: &Level<1>) -> Option<Arc<Level<1>>> {
        let [t] = &best.parameters;
        let is_determined = line.is_determined(t);
        is_determined.then(|| self.fit(&Values::new(&line, t), None))?
    }

    /// A level within the tolerance over the knots of this one, if weights achieve it.
    fn weighed(&mut self, level: Arc<Level<1>>) -> Option<Arc<Level<1>>> {
        let mut weights = Weights::new(self.points.len());
        let mut now = level;
        for _ in 0..WEIGHINGS {
            if self.levels.is_within(&now) {
                return Some(now);
            }
            if now.distances.max > NEAR * self.options.tolerance {
                return None;
            }
            weights.raise(&now.distances.each, now.distances.max);
            self.prunings = self.prunings.checked_sub(1)?;
            now = self.fit(&values_of(&now), Some(weights.values()))?;
        }
        Some(now).filter(|it| self.levels.is_within(it))
    }
}
