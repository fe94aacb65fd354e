//! The next numbers of control points of each direction.
//!
//! First the number that the distances after growth suggest, and if it is too small, numbers in between; then one line
//! less at a time (of many lines a small part of them), as long as either direction can spare one. Where growth has not
//! come within the tolerance, redistribution may still reach it with the largest allowed number; and at last, where
//! data of both directions together limit them, knots that follow the data, as in an interpolation.

use super::Fit;

/// Attempts with fewer lines.
const ATTEMPTS: usize = 40;

/// The search tries to remove one in this many lines at a time.
const PART: usize = 32;

/// Bisections where only the largest allowed number is known to suffice.
const BISECTIONS: usize = 4;

/// The numbers of control points that are known to suffice, and those that are not.
#[derive(Debug)]
pub(super) struct Search {
    /// The fewest control points.
    fewest: [usize; 2],
    /// The most control points, and the most where both directions have as many.
    most: [usize; 2],
    even: [usize; 2],
    goal: Goal,
    /// The last fit within the tolerance.
    within: Option<Fit>,
    /// The fit that it starts from.
    start: Fit,
    /// For each direction, the number from which one line fewer has failed.
    failed: [Option<[usize; 2]>; 2],
    /// For each direction, the number of lines that are tried to be removed.
    spared: [usize; 2],
    /// Attempts with fewer lines that are left.
    attempts: usize,
}

/// The purpose of an attempt.
#[derive(Clone, Copy, Debug)]
enum Goal {
    /// The number that follows from the distances.
    Asked([usize; 2]),
    /// The largest allowed number; the largest that is known to fail.
    Most([usize; 2]),
    /// The same number in both directions, with knots that follow the data; the largest that is known to fail.
    Even([usize; 2]),
    /// Between a number that is known to fail and one that suffices; the remaining steps.
    Between([usize; 2], usize),
    /// Fewer lines of a direction.
    Fewer(usize),
}

impl Search {
    /// After growth: `start` is its last fit, within the tolerance or not, and `asked` the numbers that follow from its
    /// distances.
    pub(super) fn new(
        start: Fit,
        is_within: bool,
        asked: [usize; 2],
        fewest: [usize; 2],
        [most, even]: [[usize; 2]; 2],
    ) -> Self {
        let now = start.level.counts();
        let above = if is_within { now } else { most };
        let asked = [0, 1].map(|axis| asked[axis].clamp(fewest[axis], above[axis]));
        Self {
            fewest,
            most,
            even,
            goal: Goal::Asked(asked),
            within: is_within.then(|| start.clone()),
            start,
            failed: [None; 2],
            spared: above.map(|count| (count / PART).max(1)),
            attempts: ATTEMPTS,
        }
    }

    /// The fit that the next attempt starts from.
    pub(super) fn from(&self) -> &Fit {
        self.within.as_ref().unwrap_or(&self.start)
    }

    /// Returns true if the next attempt has knots that follow the data.
    pub(super) fn is_even(&self) -> bool {
        matches!(self.goal, Goal::Even(_))
    }

    /// The numbers of the next attempt, or `None` if there is none left.
    pub(super) fn counts(&mut self) -> Option<[usize; 2]> {
        let now = self.within.as_ref().map(|fit| fit.level.counts());
        let counts = match (self.goal, now) {
            (Goal::Asked(asked), _) => asked,
            (Goal::Most(_), _) => self.most,
            (Goal::Even(_), _) => self.even,
            (Goal::Between(low, _), Some(now)) => [0, 1].map(|axis| low[axis].midpoint(now[axis])),
            (Goal::Fewer(_), Some(now)) => return self.fewer(now),
            (Goal::Between(..) | Goal::Fewer(_), None) => return None,
        };
        if now == Some(counts) {
            self.goal = Goal::Fewer(0);
            return self.counts();
        }
        Some(counts)
    }

    /// Fewer lines of the direction that saves more, if one line fewer is not known to fail.
    fn fewer(&mut self, now: [usize; 2]) -> Option<[usize; 2]> {
        self.attempts = self.attempts.checked_sub(1)?;
        // A line of u has as many control points as there are lines of v.
        let first = usize::from(now[0] > now[1]);
        let can_spare =
            |&axis: &usize| now[axis] > self.fewest[axis] && self.failed[axis] != Some(now);
        let axis = [first, 1 - first].into_iter().find(can_spare)?;
        self.goal = Goal::Fewer(axis);
        let mut counts = now;
        counts[axis] -= self.spared[axis].min(now[axis] - self.fewest[axis]);
        Some(counts)
    }

    /// Continues after an attempt came within the tolerance.
    pub(super) fn succeed(&mut self, fit: Fit) {
        self.goal = match self.goal {
            Goal::Most(low) | Goal::Even(low) => Goal::Between(low, BISECTIONS),
            Goal::Between(low, left) if left > 1 => Goal::Between(low, left - 1),
            _ => Goal::Fewer(0),
        };
        self.within = Some(fit);
    }

    /// Continues after an attempt has failed.
    pub(super) fn fail(&mut self) -> bool {
        let now = self.within.as_ref().map(|fit| fit.level.counts());
        self.goal = match (self.goal, now) {
            (Goal::Asked(asked), Some(_)) => Goal::Between(asked, 1),
            (Goal::Asked(asked), None) if asked != self.most => Goal::Most(asked),
            (Goal::Asked(asked) | Goal::Most(asked), None) if self.even != self.most => {
                Goal::Even(asked)
            }
            (Goal::Between(low, left), Some(now)) if left > 1 => {
                let middle = [0, 1].map(|axis| low[axis].midpoint(now[axis]));
                Goal::Between(middle, left - 1)
            }
            (Goal::Fewer(axis), Some(now)) => {
                if self.spared[axis] == 1 {
                    self.failed[axis] = Some(now);
                }
                self.spared[axis] = (self.spared[axis] / 2).max(1);
                Goal::Fewer(axis)
            }
            (_, Some(_)) => Goal::Fewer(0),
            (_, None) => return false,
        };
        true
    }
}
