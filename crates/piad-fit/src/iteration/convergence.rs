//! Predicts when a fit will end, before its first step.
//!
//! Methods say what they know by eigenvalues and trial runs ([`Forecast`](crate::matrix::forecast::Forecast)); clients see it
//! before they wait. That alone is far too pessimistic, as data has little of the slowest eigenvectors. So a
//! millisecond or two are spent on the first levels: short fits end within it, and the [decay](super::decay) of errors
//! predicts the end of the others.

use std::sync::Arc;

use super::Iteration;
use super::system::System;
use crate::matrix::forecast::Prediction;
use crate::termination::Outcome;

/// The most multiplications of looking for the end of a fit: a millisecond or two.
const LOOK: usize = 2_000_000;

/// The fewest steps that allow an estimate.
const LEAST_STEPS: usize = 8;

impl Iteration {
    /// Level 0 of a fit. Where the fit will end is found out before, once for all iterations of a
    /// system.
    pub fn start(system: Arc<System>) -> Self {
        // The last level of fits that choose their knots is unknown.
        if !system.problem().is_automatic() {
            system.predict(end);
        }
        Self::start_unpredicted(system)
    }
}

/// The predicted end of a fit: short fits are tried, of longer ones the beginning. `None` if that is not enough.
fn end(system: &Arc<System>) -> Option<Prediction> {
    let problem = system.problem();
    let method = problem.method().algorithm();
    let exact = system.forecast().exact_after;
    if method.ends_when_exact() {
        return exact.map(Prediction::End);
    }
    // Of the other exact methods there is no better prediction.
    let exact = exact.map(|end| Prediction::Estimate { end, seen: end });
    let steps = LOOK / problem.step_cost().max(1);
    // Errors do not fall to zero: fits without a tolerance run to the last allowed level.
    let endless = problem.tolerance() <= 0.0 && !method.ends_by_itself();
    if endless || steps < LEAST_STEPS {
        return exact;
    }
    let mut iteration = Iteration::start_unpredicted(Arc::clone(system));
    for _ in 0..steps {
        // Where the fit is between its data does not change where it ends.
        match iteration.outcome_at_data() {
            None => iteration.step(),
            Some(Outcome::Exhausted) => break,
            Some(Outcome::Overflow) => return None,
            Some(_) => return Some(Prediction::End(iteration.level().iteration)),
        };
    }
    let seen = iteration.level().iteration;
    let end = iteration.end_of_decay();
    exact.or(end.map(|end| Prediction::Estimate { end, seen }))
}
