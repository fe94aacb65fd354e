//! Extended fits in advance: whether rounding will leave more than the tolerance.
//!
//! The extended method is exact after a known number of levels, but its distances grow before they
//! vanish: `(I − U B)ᵏ` can be as large as 10¹⁵⁰. How large depends on the whole matrix, so that the
//! quickest way to know it is to try.

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
