//! An attempt with a number of control points: the results of its redistributions so far.

use std::sync::Arc;

use super::levels::Level;
use super::monitor::Monitor;

/// This many redistributions without gain end an attempt.
const PATIENCE: usize = 6;

/// A gain is a largest distance below this part of the lowest before.
const GAIN: f64 = 0.98;

/// An attempt that is still this many tolerances away ends after [`ENOUGH`] redistributions, unless
/// the last ones have reduced the largest distance to [`FAST`] of what it was.
const HOPELESS: f64 = 4.0;

/// See [`HOPELESS`].
const ENOUGH: usize = 3;

/// See [`HOPELESS`].
const FAST: f64 = 0.75;

/// Redistributions of some number of control points.
#[derive(Debug)]
pub(super) struct Attempt {
    count: usize,
    /// The source of the next knots.
    monitor: Monitor,
    /// The level with the lowest largest distance, and the knot density of its distances.
    lowest: Option<(Arc<Level<1>>, Monitor)>,
    /// The last level with weights.
    weighed: Option<Arc<Level<1>>>,
    tries: usize,
    /// Redistributions since the last gain.
    without_gain: usize,
    /// Redistributions since the last fast one.
    slow: usize,
}

impl Attempt {
    /// Nothing tried yet.
    pub(super) fn new(count: usize, monitor: Monitor) -> Self {
        Self {
            count,
            monitor,
            lowest: None,
            weighed: None,
            tries: 0,
            without_gain: 0,
            slow: 0,
        }
    }

    /// The number of control points.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Returns true if nothing was tried yet.
    pub(super) fn is_fresh(&self) -> bool {
        self.tries == 0
    }

    /// The source of the next knots.
    pub(super) fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// The largest distance of the lowest level.
    pub(super) fn lowest(&self) -> f64 {
        self.lowest
            .as_ref()
            .map_or(f64::INFINITY, |(level, _)| level.distances.max)
    }

    /// The level with the lowest largest distance.
    pub(super) fn lowest_level(&self) -> Option<&Arc<Level<1>>> {
        self.lowest.as_ref().map(|(level, _)| level)
    }

    /// Takes the outcome of a redistribution, and the knot density of its distances; returns true
    /// if it is the lowest so far.
    pub(super) fn take(&mut self, level: &Arc<Level<1>>, monitor: Monitor) -> bool {
        let (largest, before) = (level.distances.max, self.lowest());
        self.tries += 1;
        self.without_gain = if largest < GAIN * before {
            0
        } else {
            self.without_gain + 1
        };
        self.slow = if largest < FAST * before {
            0
        } else {
            self.slow + 1
        };
        let lower = largest < before;
        if lower {
            self.lowest = Some((Arc::clone(level), monitor.clone()));
        }
        self.monitor = monitor;
        lower
    }

    /// Returns true if more redistributions are not worth it. With the largest allowed number of
    /// control points, `most`, there is no other way to get closer.
    pub(super) fn is_over(&self, tolerance: f64, most: usize) -> bool {
        let elsewhere = self.count < most && self.is_hopeless(tolerance);
        self.without_gain >= PATIENCE || elsewhere && self.tries >= ENOUGH && self.slow > 1
    }

    /// Returns true if the tolerance is so far away that distances are no guide to the number of
    /// control points needed.
    pub(super) fn is_hopeless(&self, tolerance: f64) -> bool {
        self.lowest() > HOPELESS * tolerance
    }

    /// The last level with weights.
    pub(super) fn weighed(&self) -> Option<&Arc<Level<1>>> {
        self.weighed.as_ref()
    }

    /// Remembers a level with weights.
    pub(super) fn with_weighed(mut self, level: Arc<Level<1>>) -> Self {
        self.weighed = Some(level);
        self
    }

    /// The knot density of the last redistribution.
    pub(super) fn into_last_monitor(self) -> Monitor {
        self.monitor
    }

    /// The knot density of the lowest level.
    pub(super) fn into_lowest_monitor(self) -> Monitor {
        match self.lowest {
            Some((_, monitor)) => monitor,
            None => self.monitor,
        }
    }
}
