//! The levels of a search: of curves, with one direction, and of surfaces, with two.

use std::collections::VecDeque;
use std::sync::Arc;

use super::breaks::Breaks;
use crate::data::distances::Distances;
use crate::data::points::Points;
use crate::termination::Outcome;

/// A B-spline of `D` directions during the search.
#[derive(Clone, Debug)]
pub(crate) struct Level<const D: usize> {
    /// The knots of each direction.
    pub lines: [Breaks; D],
    /// The control points, of surfaces row by row.
    pub control_points: Points,
    /// The distances from the data, in their order.
    pub distances: Distances,
    /// The parameters of the data in each direction.
    pub parameters: [Arc<Vec<f64>>; D],
}

impl<const D: usize> Level<D> {
    /// The number of control points of each direction.
    pub(crate) fn counts(&self) -> [usize; D] {
        self.lines.each_ref().map(Breaks::control_points)
    }

    /// The number of control points.
    pub(crate) fn count(&self) -> usize {
        self.counts().iter().product()
    }
}

/// The levels that a schedule has found, and how it has ended.
#[derive(Debug)]
pub(super) struct Levels<const D: usize> {
    tolerance: f64,
    queue: VecDeque<Arc<Level<D>>>,
    /// The last level.
    pub last: Option<Arc<Level<D>>>,
    /// The level within the tolerance with the fewest control points.
    pub best: Option<Arc<Level<D>>>,
    /// The level with the smallest largest distance.
    closest: Option<Arc<Level<D>>>,
    outcome: Option<Outcome>,
}

impl<const D: usize> Levels<D> {
    /// No levels yet.
    pub(super) fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            queue: VecDeque::new(),
            last: None,
            best: None,
            closest: None,
            outcome: None,
        }
    }

    /// How the search has ended, after the last level.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        self.outcome.filter(|_| self.queue.is_empty())
    }

    /// Returns true if the next level has to be found.
    pub(super) fn is_next_missing(&self) -> bool {
        self.queue.is_empty() && self.outcome.is_none()
    }

    /// The next level, or `None` after the last one.
    pub(super) fn pop(&mut self) -> Option<Arc<Level<D>>> {
        self.queue.pop_front()
    }

    /// Returns true if a level is within the tolerance.
    pub(super) fn is_within(&self, level: &Level<D>) -> bool {
        level.distances.max <= self.tolerance
    }

    /// Queues a level, and keeps it if it is the best or the closest.
    pub(super) fn issue(&mut self, level: Arc<Level<D>>) {
        let fewer = |best: &Arc<Level<D>>| level.count() <= best.count();
        if self.is_within(&level) && self.best.as_ref().is_none_or(fewer) {
            self.best = Some(Arc::clone(&level));
        }
        let closer = |best: &Arc<Level<D>>| level.distances.max < best.distances.max;
        if self.closest.as_ref().is_none_or(closer) {
            self.closest = Some(Arc::clone(&level));
        }
        self.last = Some(Arc::clone(&level));
        self.queue.push_back(level);
    }

    /// Queues a level that is there and within the tolerance; returns true in that case.
    pub(super) fn accept(&mut self, level: Option<Arc<Level<D>>>) -> bool {
        match level.filter(|it| self.is_within(it)) {
            Some(level) => self.issue(level),
            None => return false,
        }
        true
    }

    /// Ends with the best level again, unless it is the last one; without one it ends as `failed`, with the closest.
    pub(super) fn end(&mut self, failed: Outcome) {
        let end = self.best.as_ref().or(self.closest.as_ref());
        if let (Some(end), Some(last)) = (end, &self.last)
            && !Arc::ptr_eq(end, last)
        {
            self.queue.push_back(Arc::clone(end));
        }
        self.outcome = Some(match self.best {
            Some(_) => Outcome::Converged,
            None => failed,
        });
    }
}
