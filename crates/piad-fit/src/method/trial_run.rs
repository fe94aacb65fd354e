//! Trial runs: the growth of distances before they vanish.
//!
//! The extended method is exact after a known number of levels, but its distances grow before they
//! vanish: `(I − U B)ᵏ` can be as large as 10¹⁵⁰. Chebyshev steps are chosen by eigenvalues, and
//! where eigenvectors are nearly parallel these predict little: with knots at the data and an even
//! degree distances of 400 points rise by 10⁸⁸. How far they rise depends on the whole matrix, so
//! that the quickest way to know it is to try.
//!
//! A trial run is made with the data of the fit, by the plain loop, when a system is made. It is
//! limited by a number of multiplications, so that it never takes longer than a moment.

use super::algorithm::Algorithm;
use super::equations::Equations;

/// The most multiplications of a trial run: a moment.
const WORK: usize = 50_000_000;

/// About how large a distance rounding leaves at the end of an extended fit, in data units, if it
/// is beyond the tolerance; infinite if numbers overflow between. Of long fits only the beginning
/// is tried: what is left of them is at least the rounding of the largest distance there.
pub(super) fn left_by_rounding(method: &dyn Algorithm, equations: &Equations) -> Option<f64> {
    let setup = &equations.setup;
    let levels = equations.forecast.exact_after?;
    let steps = levels.min(WORK / setup.residual_cost().max(1));
    let (mut plain, error) = method.plain(equations, method.level_zero(equations));
    let (mut last, mut largest) = (error.max, error.max);
    for _ in 0..steps {
        if last <= setup.tolerance() {
            return None;
        }
        last = plain.step(equations).1.max;
        // Distances that are not finite count as infinite.
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
    (left > setup.tolerance()).then_some(left)
}

/// How far the residual may rise in Chebyshev fits, as a multiple of that of level 0.
const RISE: f64 = 100.0;

/// With λ_min above this residuals rise little, unless it is one of many eigenvalues that nearly
/// coincide.
const WELL_CONDITIONED: f64 = 0.01;

/// An eigenvalue below this one is rounding.
const ROUNDING: f64 = f64::EPSILON;

/// The fewest and the most steps that are tried of a Chebyshev fit.
const STEPS: (usize, usize) = (50, 1000);

/// Where the interval [a, 1] of the Chebyshev steps may begin, if λ_min will not do: √λ_min, its
/// root, and so on up to a = 1, the steps of classical PIA. The first one with which residuals do
/// not rise far is taken. `None` if λ_min is reliable.
pub(super) fn safe_intervals(equations: &Equations) -> impl Iterator<Item = f64> + use<> {
    let least = equations.forecast.lambda_min.unwrap_or(1.0).max(ROUNDING);
    let begin = is_doubtful(equations).then_some(least.sqrt());
    // Seven roots of the least one are above 0.7: another one hardly makes a difference.
    std::iter::successors(begin, |a| {
        (*a < 1.0).then(|| if *a > 0.7 { 1.0 } else { a.sqrt() })
    })
}

/// Returns true if eigenvalues may predict single levels badly.
fn is_doubtful(equations: &Equations) -> bool {
    let setup = &equations.setup;
    let least = equations.forecast.lambda_min.unwrap_or(1.0);
    let ill = least < WELL_CONDITIONED.powi(1 + i32::from(setup.v().is_some()));
    ill || setup.is_clustered()
}

/// Returns true if residuals stay low in a fit with the steps of the forecast, as far as it is
/// tried.
pub(super) fn stays_low(method: &dyn Algorithm, equations: &Equations) -> bool {
    let setup = &equations.setup;
    let steps = (WORK / setup.residual_cost().max(1)).clamp(STEPS.0, STEPS.1);
    let (mut plain, _) = method.plain(equations, method.level_zero(equations));
    let first = plain.residual_length();
    for _ in 0..steps.min(setup.max_iterations()) {
        let error = plain.step(equations).1.max;
        let length = plain.residual_length();
        if error <= setup.tolerance() {
            return true;
        }
        if length > RISE * first || length.is_nan() {
            return false;
        }
    }
    true
}
