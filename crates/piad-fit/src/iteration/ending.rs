//! The rules that end an iteration at its level, and the reason.

use super::{Engine, Iteration};
use crate::method::Progress;
use crate::method::update::Update;
use crate::termination::{Outcome, Reason};

/// The rounding of sums of many terms, in rounding errors of the data.
const SUMS: f64 = 64.0;

impl Iteration {
    /// The outcome of a fit that has succeeded by its distances, unless one of its numbers has left
    /// the range of numbers.
    fn success(&self, outcome: Outcome) -> Outcome {
        if self.level.error.is_finite() && self.has_places() {
            outcome
        } else {
            Outcome::Overflow
        }
    }

    /// Returns true if all control points have a place. At weight zero they are at infinity; and where basis functions
    /// vanish but for rounding, control points can overflow although all distances are finite.
    fn has_places(&self) -> bool {
        let points = self.control_points();
        if self.system.problem().is_homogeneous()
            && let Some((weights, lanes)) = points.lanes().split_last()
        {
            let place = |(x, weight): (&f64, &f64)| (x / weight).is_finite();
            return lanes
                .iter()
                .all(|lane| lane.iter().zip(&**weights).all(place));
        }
        // Without an early end the loop takes several numbers at once.
        let finite = |lane: &[f64]| lane.iter().fold(true, |all, x| all & x.is_finite());
        points.lanes().iter().all(|lane| finite(lane))
    }

    /// Returns true if the curve is as near to the data as requested. A method may have a larger tolerance, may still
    /// have points to move, or may need more than small distances.
    pub(super) fn is_within(&self) -> bool {
        let (problem, largest) = (self.system.problem(), self.level.error.max);
        let first = problem.method().algorithm().first_end();
        if self.level.iteration < first.min(problem.max_iterations()) {
            return false;
        }
        if self.update().is_some_and(Update::seeks_minimum) {
            return false;
        }
        let unfinished = || self.update().is_some_and(Update::is_unfinished);
        largest <= problem.tolerance()
            && (largest <= problem.requested_tolerance() || !unfinished())
    }

    /// How the iteration ends, if the current level is its last one. A fit that leaves its data between neighbours has not
    /// succeeded, whatever its distances at the data.
    pub fn outcome(&self) -> Option<Outcome> {
        match self.outcome_at_data()? {
            Outcome::Converged | Outcome::Minimum if self.leaving().is_some() => {
                Some(Outcome::Stalled(Reason::Between))
            }
            outcome => Some(outcome),
        }
    }

    /// The same by the distances at the data. A minimum above a requested tolerance is no success.
    pub(super) fn outcome_at_data(&self) -> Option<Outcome> {
        match self.ending() {
            Some(Outcome::Minimum) if self.system.problem().has_goal() => {
                Some(Outcome::Stalled(match self.is_rounding() {
                    true => Reason::Rounding,
                    false => Reason::Minimum,
                }))
            }
            Some(Outcome::Stalled(Reason::Diverging)) if self.is_near_rounding() => {
                Some(Outcome::Stalled(Reason::Rounding))
            }
            ending => ending,
        }
    }

    /// Returns true if the distances are rounding errors of the data.
    fn is_rounding(&self) -> bool {
        self.level.error.rms <= self.system.problem().rounding()
    }

    /// Returns true if they are at most what sums of many terms make of rounding errors.
    fn is_near_rounding(&self) -> bool {
        self.level.error.rms <= SUMS * self.system.problem().rounding()
    }

    /// The same, whether or not a tolerance was requested.
    fn ending(&self) -> Option<Outcome> {
        let problem = self.system.problem();
        let iteration = self.level.iteration;
        if let Engine::Automatic(automatic) = &self.engine {
            let last = iteration >= problem.max_iterations();
            return automatic.outcome().or(last.then_some(Outcome::Exhausted));
        }
        // Homogeneous distances can be infinite where a weight is not positive; residuals cannot.
        if !self.length.is_finite() {
            Some(Outcome::Overflow)
        } else if self.is_within() {
            Some(self.success(Outcome::Converged))
        } else if let Some(outcome) = self.rule_of_method() {
            match outcome {
                Outcome::Minimum => Some(self.success(outcome)),
                _ => Some(outcome),
            }
        } else if let Some(stall) = self.update().and_then(Update::stalled) {
            Some(Outcome::Stalled(stall))
        } else if iteration >= problem.max_iterations() {
            Some(Outcome::Exhausted)
        } else {
            None
        }
    }

    /// Returns true if the fit ends for a reason of the method's own, by its errors or by what its update has measured.
    fn rule_of_method(&self) -> Option<Outcome> {
        let rule = self.system.problem().method().algorithm();
        let measured = || self.update().and_then(Update::outcome);
        rule.stop(&self.progress()).or_else(measured)
    }

    /// The input of the stop rule of the method.
    fn progress(&self) -> Progress {
        Progress {
            iteration: self.level.iteration,
            first_length: self.first_length,
            length: self.length,
            decrease: self.decrease,
        }
    }
}
