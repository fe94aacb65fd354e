//! Eigenvalues of collocation matrices, and the rates of convergence that follow from them.
//!
//! The eigenvalues of a nonsingular totally positive stochastic matrix are real and lie in (0, 1]
//! (LBW05, Theorem 2.1), so that the error of classical PIA, `(I − B)ᵏ` times that of level 0,
//! shrinks in the long run by `1 − λ_min` in each level. The eigenvalues of a tensor product are
//! the products of those of both directions, so that its least one is the product of the least
//! ones.
//!
//! λ_min is found by Noda's iteration on banded factorizations, O(n p²) for each of a few shifts.

use nalgebra::DVector;

use super::collocation::{Collocation, ROUGH_EIGENVALUE_COLUMNS};
use super::tensor::Tensor;
use crate::basis::direction::Direction;
use crate::interrupt;
use crate::linear::LineMap;
use crate::linear::vectors::length;

/// Dense matrices up to this number of rows have their eigenvalues computed, in O(n³).
pub(crate) const DENSE: usize = 100;

/// The most steps of the iterations for the extreme eigenvalues of a block.
const BLOCK_STEPS: usize = 500;
/// The relative accuracy at which they end.
const BLOCK_ACCURACY: f64 = 1e-9;

/// When a power iteration ends: its relative accuracy, and the most steps. A few digits are enough
/// for long curves.
fn effort(matrix: &Collocation) -> (f64, usize) {
    let n = matrix.columns();
    let accuracy = if n <= ROUGH_EIGENVALUE_COLUMNS {
        1e-13
    } else {
        1e-9
    };
    (accuracy, most_steps(matrix.entries()))
}

/// The most steps for a matrix with this number of entries.
fn most_steps(entries: usize) -> usize {
    /// The most multiplications.
    const WORK: usize = 200_000_000;
    (WORK / entries.max(1)).clamp(20, 5000)
}

/// The most multiplications of [`largest_singular_value_squared`] for a direction.
pub(crate) fn singular_value_cost(direction: &Direction) -> usize {
    let width = direction.basis.support_width();
    let entries = direction.parameters.len().saturating_mul(width);
    entries.saturating_mul(2 * most_steps(entries))
}

/// The least eigenvalue λ_min of the square matrix of one direction, at most 1.
///
/// The inverse of a totally positive matrix has signs like a checkerboard, so that with
/// `S = diag(1, −1, 1, …)`
///
/// ```text
/// M = |B⁻¹| = S B⁻¹ S
/// ```
///
/// is a non-negative matrix, whose largest eigenvalue 1/λ_min has a positive eigenvector (Perron).
/// Of matrices that are not totally positive it is the eigenvalue of least absolute value.
pub fn least_eigenvalue(matrix: &Collocation) -> f64 {
    // Quadratic B-splines with knots at the data: the diagonal suffices. With equal knot spans all
    // eigenvalues coincide in one Jordan block, which iterations approach very slowly.
    if let Some(diagonal) = matrix.diagonal_if_triangular() {
        return diagonal.into_iter().fold(1.0, f64::min);
    }
    let largest = by_shifts(matrix).unwrap_or_else(|| by_powers(matrix));
    (1.0 / largest).min(1.0)
}

/// When Noda's iteration ends: the relative step below which it does, and the most shifts. Near the
/// end each shift doubles the digits, unless eigenvalues nearly coincide, as they do for even
/// degrees. A few digits are enough for long curves: the step after one of 3 in 100 is less than 1
/// in 100.
fn precision(matrix: &Collocation) -> (f64, usize) {
    match matrix.columns() {
        n if n <= ROUGH_EIGENVALUE_COLUMNS => (1e-13, 100),
        ..=20_000 => (1e-6, 20),
        _ => (3e-2, 8),
    }
}

/// After a relative step larger than this the shift is far enough from the eigenvalue for
/// elimination without pivots.
const PIVOTED_STEP: f64 = 1e-3;

/// A relative step less than this is one of the last two: the next one is below rounding.
const NEARLY: f64 = 1e-7;

/// The largest eigenvalue of `M = S B⁻¹ S` by Noda's iteration (Noda, Numer. Math. 17 (1971)).
///
/// For a positive vector x the bound of Collatz and Wielandt `σ = max_i (M x)_i / x_i` is at least
/// the eigenvalue. Solve
///
/// ```text
/// (σ I − M) y = x,   or with x = S z, y = S w:   (σ B − I) w = B z
/// ```
///
/// Then y is positive as well, and as `M y = σ y − x` its bound is `σ − min_i x_i / y_i`: the
/// bounds fall to the eigenvalue, finally quadratically. What is not found to the last digit is too
/// large, so that λ_min is too small, and steps that are chosen by it are safe.
///
/// `None` if a matrix that is not totally positive spoils a sign.
fn by_shifts(matrix: &Collocation) -> Option<f64> {
    let n = matrix.columns();
    let (accuracy, shifts) = precision(matrix);
    let inverse = matrix.inverse();
    let mut z: Vec<f64> = (0..n).map(alternating).collect();
    let mut w = z.clone();
    inverse.apply(&mut w);
    let mut upper = extremes(&w, &z).1;
    set_direction(&mut z, &w);
    let mut step = f64::INFINITY;
    for _ in 0..shifts {
        interrupt::check();
        matrix.apply_to_lines(&z, &mut w);
        let exact = step < PIVOTED_STEP;
        matrix.shifted_inverse(upper, exact)?.apply(&mut w);
        let (least, largest) = extremes(&z, &w);
        if !(least > 0.0 && largest.is_finite()) {
            // Where the shift is the eigenvalue but for rounding, signs are arbitrary.
            return (step < NEARLY).then_some(upper);
        }
        step = least / upper;
        upper -= least;
        set_direction(&mut z, &w);
        if step <= accuracy {
            break;
        }
    }
    // The bound of the vector holds whatever the rounding before.
    w.copy_from_slice(&z);
    inverse.apply(&mut w);
    let (least, largest) = extremes(&w, &z);
    (least > 0.0).then_some(largest)
}

/// The least and the largest of the quotients `over_i / under_i`; both are NaN if one of them is.
fn extremes(over: &[f64], under: &[f64]) -> (f64, f64) {
    let quotients = over.iter().zip(under).map(|(a, b)| a / b);
    quotients.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| {
        if q.is_nan() {
            (f64::NAN, f64::NAN)
        } else {
            (low.min(q), high.max(q))
        }
    })
}

/// The extreme eigenvalues of a block of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockSpectrum {
    /// The least one.
    pub least: f64,
    /// The largest one.
    pub largest: f64,
}

impl BlockSpectrum {
    /// By how much a relaxation with ω reduces errors in each level, in the long run.
    pub(crate) fn rate(&self, omega: f64) -> f64 {
        relaxed_rate(omega, self.least, self.largest)
    }
}

/// `max |1 − ω λ|` over eigenvalues λ from `least` to `largest`. Up to ω = 1 the least one decides,
/// as no eigenvalue is above one.
pub(crate) fn relaxed_rate(omega: f64, least: f64, largest: f64) -> f64 {
    let slow = 1.0 - omega * least;
    if omega <= 1.0 {
        return slow;
    }
    slow.abs().max((1.0 - omega * largest).abs())
}

/// The extreme eigenvalues of the block `B_II` of a square matrix that belongs to some points I, by
/// inverse iteration on its dense LU decomposition, in O(|I|³), and power iteration. Principal
/// blocks of totally positive matrices are totally positive, so that they are real and positive.
/// `None` if the block is singular.
pub(crate) fn of_block(matrix: &Tensor, points: &[usize]) -> Option<BlockSpectrum> {
    let mut points = points.to_vec();
    points.sort_unstable();
    let mut place = vec![None; matrix.data_grid().count()];
    for (k, &index) in points.iter().enumerate() {
        place[index] = Some(k);
    }
    let block = matrix.principal_block(&points, &place);
    let lu = block.clone().lu();
    let n = points.len();
    let inverse = growth(DVector::from_fn(n, |i, _| alternating(i)), |x| lu.solve(x))?;
    // The entries are not negative, and neither are those of the vector.
    let largest = growth(DVector::from_element(n, 1.0), |x| Some(&block * x))?;
    let least = (1.0 / inverse).min(1.0);
    let largest = largest.clamp(least, 1.0);
    (least > 0.0).then_some(BlockSpectrum { least, largest })
}

/// The factor by which a map makes vectors grow in the long run, by power iteration from `x`.
/// `None` if there is no such factor.
fn growth(mut x: DVector<f64>, map: impl Fn(&DVector<f64>) -> Option<DVector<f64>>) -> Option<f64> {
    let mut largest = 0.0;
    for _ in 0..BLOCK_STEPS {
        interrupt::check();
        let next = map(&x)?;
        let growth = next.norm() / x.norm();
        x = next.normalize();
        let settled = (growth / largest - 1.0_f64).abs() < BLOCK_ACCURACY;
        largest = growth;
        if settled {
            break;
        }
    }
    Some(largest)
}

/// The largest absolute value of an eigenvalue of `B⁻¹` by power iteration, for matrices that are
/// not totally positive; infinite if the matrix is singular.
fn by_powers(matrix: &Collocation) -> f64 {
    let n = matrix.columns();
    let inverse = matrix.inverse();
    let mut x: Vec<f64> = (0..n).map(alternating).collect();
    let mut estimate = 0.0;
    let (accuracy, steps) = effort(matrix);
    for _ in 0..steps {
        interrupt::check();
        let before = length(&x);
        inverse.apply(&mut x);
        let after = length(&x);
        let growth = after / before;
        if !growth.is_finite() || growth == 0.0 {
            return f64::INFINITY;
        }
        if growth > 1.0 / f64::EPSILON {
            // Singular to working precision: more steps would not find a right digit.
            return growth;
        }
        x.iter_mut().for_each(|x| *x /= after);
        let settled = (growth / estimate - 1.0_f64).abs() < accuracy;
        estimate = growth;
        if settled {
            break;
        }
    }
    estimate
}

/// The diagonal of S: 1, −1, 1, …
fn alternating(i: usize) -> f64 {
    if i.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// ρ(B Bᵀ), the square of the largest singular value of the matrix of one direction, by power
/// iteration on `Bᵀ B`.
pub(crate) fn largest_singular_value_squared(matrix: &Collocation) -> f64 {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    // A constant vector is near the largest one; the ripple has a part of every other.
    let mut x: Vec<f64> = (0..columns).map(|i| 1.0 + 0.1 * (i as f64).sin()).collect();
    let mut y = vec![0.0; rows];
    let mut estimate = 0.0;
    let (accuracy, steps) = effort(matrix);
    for _ in 0..steps {
        interrupt::check();
        let before = length(&x);
        x.iter_mut().for_each(|x| *x /= before);
        matrix.apply_to_lines(&x, &mut y);
        matrix.apply_transposed_to_lines(&y, &mut x);
        let growth = length(&x);
        let settled = (growth / estimate - 1.0_f64).abs() < accuracy;
        estimate = growth;
        if settled {
            break;
        }
    }
    estimate
}

/// By how much each step of the Chebyshev semi-iteration on [a, 1] reduces the part of the error
/// that belongs to an eigenvalue λ ≤ a, in the long run:
///
/// ```text
/// (z + √(z² − 1)) / (z₀ + √(z₀² − 1)),   z = (1 + a − 2 λ)/(1 − a),   z₀ = (1 + a)/(1 − a)
/// ```
///
/// With λ = a it is `(1 − √a)/(1 + √a)` (Golub, Varga 1961).
pub(crate) fn chebyshev_rate(lambda: f64, a: f64) -> f64 {
    // Both times (1 − a), so that a = 1 is no exception: 1 − λ, the rate of classical PIA.
    let grown = |lambda: f64| {
        let excess = a - lambda;
        1.0 + a - 2.0 * lambda + 2.0 * (excess * (1.0 - lambda)).sqrt()
    };
    grown(lambda) / grown(0.0)
}

/// Sets a vector to another one, scaled to unit length.
fn set_direction(z: &mut [f64], w: &[f64]) {
    let size = length(w);
    z.iter_mut().zip(w).for_each(|(z, w)| *z = w / size);
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::basis::choice::{BasisChoice, DirectionChoice};
    use crate::basis::direction::Direction;
    use crate::basis::{Polynomial, knots::Knots};
    use crate::data::grid::Grid;
    use crate::data::points::Points;
    use crate::invalid::Axis;
    use crate::parameters::Parametrization;

    /// The matrix of a curve whose points are more or less evenly spaced.
    fn collocation(count: usize, unevenness: f64, basis: BasisChoice) -> Collocation {
        let mut points = Points::new(1);
        (0..count).for_each(|i| points.push(&[i as f64 + unevenness * ((i * 7) as f64).sin()]));
        let grid = Grid {
            rows: count,
            columns: 1,
        };
        let choice = DirectionChoice::new(basis, Parametrization::ChordLength);
        Collocation::new(&Direction::new(choice, &points, grid, None, Axis::U).unwrap())
    }

    /// Inner rows of equal knot spans are (1, 4, 1) / 6, so that the least eigenvalue of many is
    /// 1/3.
    #[test]
    fn shifts_find_the_least_eigenvalue_of_long_curves() {
        // As accurate as `precision` allows for this number of points.
        for (count, accuracy) in [(20_000, 1e-5), (120_000, 1e-2)] {
            let knots = Knots::Usual;
            let cubic = BasisChoice::BSpline { degree: 3, knots };
            let found = least_eigenvalue(&collocation(count, 0.0, cubic));
            assert!((3.0 * found - 1.0).abs() < accuracy, "{count}: {found}");
        }
    }

    /// `m!/mᵐ` is 1e-18 at m = 44, where a matrix of 64 bits has lost it.
    #[test]
    fn an_eigenvalue_below_rounding_is_found_to_be_so() {
        for count in [45, 60, 100] {
            let kind = Polynomial::Bernstein;
            let matrix = collocation(count, 0.0, BasisChoice::Polynomial(kind));
            let found = least_eigenvalue(&matrix);
            assert!((0.0..f64::EPSILON).contains(&found), "{count}: {found}");
        }
    }

    /// The eigenvalues of the dense matrix, by the QR algorithm. Those of even degrees nearly
    /// coincide, which costs half of the digits there.
    #[test]
    fn shifts_find_the_least_eigenvalue() {
        for (degree, digits) in [(3, 1e-11), (4, 1e-4), (5, 1e-11), (7, 1e-10)] {
            for count in [degree + 1, 12, 25] {
                let knots = Knots::Usual;
                let matrix = collocation(count, 0.3, BasisChoice::BSpline { degree, knots });
                let identity = DMatrix::<f64>::identity(count, count);
                let mut columns = vec![0.0; count * count];
                matrix.apply_to_lines(identity.as_slice(), &mut columns);
                let dense = DMatrix::from_column_slice(count, count, &columns);
                let values = dense.complex_eigenvalues();
                let least = values.iter().map(|z| z.norm()).fold(1.0, f64::min);
                let found = least_eigenvalue(&matrix);
                let near = (found / least - 1.0).abs() < digits;
                assert!(near, "{degree} {count}: {found} {least}");
            }
        }
    }
}
