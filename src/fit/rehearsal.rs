//! Fits in advance: what their matrix does to distances before they vanish.
//!
//! The extended method is exact after a known number of levels, but its distances grow before they
//! vanish: `(I − U B)ᵏ` can be as large as 10¹⁵⁰. Chebyshev steps are chosen by eigenvalues, and where
//! eigenvectors are nearly parallel these say little: with knots at the data and an even degree distances
//! of 400 points rise by 10⁸⁸. How far they rise depends on the whole matrix, so that the quickest way
//! to know it is to try.

use std::sync::Arc;

use super::basis::knots::Knots;
use super::direction::{BasisChoice, DirectionChoice};
use super::iteration::{Iteration, Outcome};
use super::method::Method;
use super::plain::Plain;
use super::system::System;
use super::update;

/// Most multiplications of a rehearsal: a moment.
const WORK: usize = 50_000_000;

/// About how large a distance rounding leaves at the end of an extended fit, if it is beyond the
/// tolerance. Of long fits only the beginning is tried: what is left of them is at least the rounding
/// of the largest distance there.
pub fn left_by_rounding(system: &System) -> Option<f64> {
    let problem = system.problem();
    let levels = system.forecast().exact_after?;
    let steps = levels.min(WORK / problem.step_cost().max(1));
    let (mut plain, error) = Plain::start(system, update::start(system));
    let (mut last, mut largest) = (error.max, error.max);
    for _ in 0..steps {
        if last <= problem.tolerance() {
            return None;
        }
        last = plain.step(system).1.max;
        // Distances that are no numbers any more are as good as infinite.
        largest = if last > largest || last.is_nan() {
            last
        } else {
            largest
        };
        if !last.is_finite() {
            return Some(f64::INFINITY);
        }
    }
    let left = if steps == levels {
        last
    } else {
        largest * f64::EPSILON
    };
    (left > problem.tolerance()).then_some(left)
}

/// How far distances may rise in Chebyshev fits, as a multiple of those of level 0.
const RISE: f64 = 100.0;

/// Above this least eigenvalue distances rise little, unless it is one of many that nearly coincide.
const WELL_CONDITIONED: f64 = 0.01;

/// Least eigenvalues below this one are rounding.
const ROUNDING: f64 = f64::EPSILON;

/// Steps that are tried of a Chebyshev fit, however long or short they are.
const STEPS: (usize, usize) = (50, 1000);

/// The beginning of the interval [a, 1] of the Chebyshev steps, if λ_min will not do: the first one
/// with which distances do not rise far. At the end stands a = 1, the steps of classical PIA.
pub fn safe_intervals(system: &System) -> impl Iterator<Item = f64> + use<> {
    let least = system.forecast().lambda_min.unwrap_or(1.0).max(ROUNDING);
    let begin = is_doubtful(system).then_some(least.sqrt());
    // Seven roots of the least one are above 0.7: another one hardly makes a difference.
    std::iter::successors(begin, |a| {
        (*a < 1.0).then(|| if *a > 0.7 { 1.0 } else { a.sqrt() })
    })
}

fn is_doubtful(system: &System) -> bool {
    let request = system.problem().request();
    let nearly_coincide = |choice: &DirectionChoice| {
        let BasisChoice::BSpline { degree, knots } = &choice.basis else {
            return true;
        };
        let averaged = matches!(knots, Knots::Averaged) || choice.closed;
        degree % 2 == 0 && !averaged
    };
    let least = system.forecast().lambda_min.unwrap_or(1.0);
    let ill = least < WELL_CONDITIONED.powi(1 + i32::from(request.v.is_some()));
    ill || std::iter::once(&request.u)
        .chain(&request.v)
        .any(nearly_coincide)
}

/// Whether distances stay low in a fit with these steps, as far as it is tried.
pub fn stays_low(system: &System) -> bool {
    let problem = system.problem();
    let steps = (WORK / problem.step_cost().max(1)).clamp(STEPS.0, STEPS.1);
    let (mut plain, _) = Plain::start(system, update::start(system));
    let first = plain.residual_length();
    for _ in 0..steps.min(problem.max_iterations()) {
        let error = plain.step(system).1.max;
        let length = plain.residual_length();
        if error <= problem.tolerance() {
            return true;
        }
        if length > RISE * first || length.is_nan() {
            return false;
        }
    }
    true
}

/// Most multiplications of looking for the end of a fit: a millisecond or two.
const LOOK: usize = 2_000_000;

/// Fewer steps would say little.
const LEAST_STEPS: usize = 8;

/// Where a fit will end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreseen {
    /// It was tried: at this level, but for rounding.
    End(usize),
    /// The beginning was tried: at about this level, as long as no more is known.
    About {
        /// The level at which it ends.
        end: usize,
        /// The level up to which that is the best that is known.
        seen: usize,
    },
}

/// Where a fit will end. Short ones are tried; of longer ones the beginning, if that says it.
pub fn end(system: &Arc<System>) -> Option<Foreseen> {
    let problem = system.problem();
    let exact = system.forecast().exact_after;
    if matches!(problem.method(), Method::Direct) {
        return exact.map(Foreseen::End);
    }
    // Of the other exact methods nothing better is known on the way.
    let exact = exact.map(|end| Foreseen::About { end, seen: end });
    let steps = LOOK / problem.step_cost().max(1);
    // Errors do not fall to zero: fits without a tolerance go on as long as they may.
    let endless = problem.tolerance() <= 0.0
        && !matches!(problem.method(), Method::LeastSquares(_) | Method::Convex);
    if endless || steps < LEAST_STEPS {
        return exact;
    }
    let mut iteration = Iteration::start_unforeseen(Arc::clone(system));
    for _ in 0..steps {
        match iteration.outcome() {
            None => iteration.step(),
            Some(Outcome::Exhausted) => break,
            Some(Outcome::Overflow) => return None,
            Some(_) => return Some(Foreseen::End(iteration.level().iteration)),
        };
    }
    let seen = iteration.level().iteration;
    let end = iteration.end_of_decay();
    exact.or(end.map(|end| Foreseen::About { end, seen }))
}
