//! An attempt with some number of control points of each direction.

use super::{Data, Fit};
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::monitor::Monitor;
use crate::knot_selection::placement::{even, place};

/// Redistributions of an attempt.
const TRIES: usize = 5;

/// Attempts end early if their largest distance is above this many tolerances and would still be
/// above one if it kept falling as in the last redistribution.
const NEAR: f64 = 1.3;

/// How far knots go towards equal distances.
const DAMPING: f64 = 0.7;

/// Redistributions of some number of control points.
#[derive(Debug)]
pub(super) struct Attempt {
    counts: [usize; 2],
    /// The knots of the last fit.
    lines: [Breaks; 2],
    /// The source of the next knots.
    monitors: [Monitor; 2],
    /// True if the first knots follow the data.
    begins_even: bool,
    tries: usize,
    /// The smallest largest distance so far.
    lowest: f64,
    /// The ratio of it to the one before the last redistribution.
    part: f64,
}

impl Attempt {
    /// An attempt with these numbers of control points, whose first knots come from the fit `from`.
    pub(super) fn new(data: &dyn Data, from: &Fit, counts: [usize; 2]) -> Self {
        Self {
            counts,
            lines: from.level.lines.clone(),
            monitors: from.monitors(data, 1.0),
            begins_even: false,
            tries: 0,
            lowest: f64::INFINITY,
            part: 0.0,
        }
    }

    /// The same, but that the first knots follow the data.
    pub(super) fn with_even_knots(self) -> Self {
        Self {
            begins_even: true,
            ..self
        }
    }

    /// The next knots, if the data can determine them.
    pub(super) fn lines(&self, data: &dyn Data) -> Option<[Breaks; 2]> {
        let place = |axis: usize| {
            let (monitor, count) = (&self.monitors[axis], self.counts[axis]);
            if self.begins_even && self.tries == 0 {
                return even(monitor, data.parameters(axis), count);
            }
            // A direction with more control points than data keeps its knots.
            let same = &self.lines[axis];
            let same = || (same.control_points() == count).then(|| same.clone());
            place(monitor, data.parameters(axis), count).or_else(same)
        };
        Some([place(0)?, place(1)?])
    }

    /// Takes the fit over these knots; returns whether it is the closest so far.
    pub(super) fn take(&mut self, data: &dyn Data, fit: &Fit) -> bool {
        let largest = fit.level.distances.max;
        let is_closer = largest < self.lowest;
        self.part = largest / self.lowest;
        self.lowest = self.lowest.min(largest);
        self.monitors = fit.monitors(data, DAMPING);
        self.lines = fit.level.lines.clone();
        self.tries += 1;
        is_closer
    }

    /// Returns true if it has failed.
    pub(super) fn is_over(&self, tolerance: f64) -> bool {
        let left = TRIES.saturating_sub(self.tries);
        let hoped = self.lowest * self.part.powi(left as i32);
        left == 0 || self.lowest > NEAR * tolerance && hoped > tolerance
    }
}
