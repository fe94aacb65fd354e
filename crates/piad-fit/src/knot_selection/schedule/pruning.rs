//! After the last attempt: knots are removed from the best level, where data are sparse, first several at once, then
//! one by one.

use std::sync::Arc;

use super::super::equations::Minimum;
use super::super::minimax::Weights;
use super::super::pruning::{fewer, without};
use super::super::values::Values;
use super::{Level, NEAR, Schedule, WEIGHINGS};
use crate::knot_selection::breaks::Breaks;

/// Single knots are removed if there are fewer data than this for each control point.
const SPARSE: usize = 8;

/// The number of removals tried in a row without success.
const CANDIDATES: usize = 12;

/// With fewer spans knots are removed one by one.
const MANY: usize = 64;

/// The most knots that are removed at once, and the fewest, are these parts of all.
const MOST: usize = 4;

/// See [`MOST`].
const FEWEST: usize = 128;

impl<M: Minimum> Schedule<M> {
    /// The best level without some of its knots; returns true if there is such a level within the tolerance.
    pub(super) fn prune(&mut self) -> bool {
        let sparse = |it: &Arc<Level>| SPARSE * it.line.control_points() > self.points.len();
        let Some(best) = self.best.clone().filter(sparse) else {
            return false;
        };
        self.prune_several(&best) || self.prune_one(&best)
    }

    /// Without several knots at once: half as many after each failure.
    fn prune_several(&mut self, best: &Arc<Level>) -> bool {
        let spans = best.line.spans();
        self.batch = self.batch.min(spans / MOST);
        while spans >= MANY && self.batch > (spans / FEWEST).max(1) {
            let line = without(&best.line, &best.control_points, self.batch);
            let level = line.and_then(|line| self.fit_over(line, best, None));
            if let Some(level) = level.filter(|it| it.distances.max <= self.options.tolerance) {
                self.issue(level);
                return true;
            }
            self.batch /= 2;
        }
        false
    }

    /// Without one of its knots.
    fn prune_one(&mut self, best: &Arc<Level>) -> bool {
        let tolerance = self.options.tolerance;
        let enough = (self.prunings / best.line.spans()).clamp(1, CANDIDATES);
        let mut nearest: Option<Arc<Level>> = None;
        let candidates = fewer(&best.line, &best.control_points).take(CANDIDATES);
        for (tried, line) in candidates.enumerate() {
            let largest = nearest
                .as_ref()
                .map_or(f64::INFINITY, |it| it.distances.max);
            if self.prunings == 0 || tried >= enough && largest <= tolerance {
                break;
            }
            let level = self.over(line, best, None);
            nearest = level.filter(|it| it.distances.max < largest).or(nearest);
        }
        match nearest.and_then(|nearest| self.weighed(nearest)) {
            Some(level) => self.issue(level),
            None => return false,
        }
        true
    }

    /// A level over other knots than the best one has, at its parameters.
    fn over(&mut self, line: Breaks, best: &Level, weights: Option<&[f64]>) -> Option<Arc<Level>> {
        self.prunings = self.prunings.checked_sub(1)?;
        self.fit_over(line, best, weights)
    }

    /// The same, with the requested number of repetitions.
    pub(super) fn fit_over(
        &self,
        line: Breaks,
        best: &Level,
        weights: Option<&[f64]>,
    ) -> Option<Arc<Level>> {
        if !line.is_determined(&best.parameters) {
            return None;
        }
        let values = Values::new(&line, &best.parameters);
        let control_points = self.minimum.minimum(&values, weights)?;
        let parameters = Arc::clone(&best.parameters);
        Some(self.level_at(line, &values, control_points, parameters))
    }

    /// A level within the tolerance over the knots of this one, if weights achieve it.
    fn weighed(&mut self, level: Arc<Level>) -> Option<Arc<Level>> {
        let tolerance = self.options.tolerance;
        let mut weights = Weights::new(self.points.len());
        let mut now = level;
        for _ in 0..WEIGHINGS {
            if now.distances.max <= tolerance {
                return Some(now);
            }
            if now.distances.max > NEAR * tolerance {
                return None;
            }
            weights.raise(&now.distances.each, now.distances.max);
            now = self.over(now.line.clone(), &now, Some(weights.values()))?;
        }
        Some(now).filter(|it| it.distances.max <= tolerance)
    }
}
