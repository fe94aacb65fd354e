//! Eigenvalues of collocation matrices, and the rates of convergence that follow from them.
//!
//! The eigenvalues of a nonsingular totally positive stochastic matrix are real and lie in (0, 1]
//! (LBW05, Theorem 2.1): global PIA contracts by `1 − λ_min`. The least eigenvalue of a tensor
//! product is the product of the least ones.

use nalgebra::DMatrix;

use super::basis::{Basis, Polynomial};
use super::collocation::Collocation;
use super::direction::Direction;
use super::invalid::Invalid;
use super::linear::LineMap;
use super::method::Method;
use super::problem::Problem;

/// Bases that are not totally positive are checked up to this number of points, in O(n³).
const CHECKED: usize = 60;

/// How much of the imaginary part of an eigenvalue can be rounding.
const REAL: f64 = 1e-9;

/// When an iteration for an eigenvalue ends: relative accuracy, most steps. Of long curves nobody
/// needs more than a few digits.
fn effort(matrix: &Collocation) -> (f64, usize) {
    const WORK: usize = 200_000_000;
    let n = matrix.columns();
    let accuracy = if n <= 1000 { 1e-13 } else { 1e-9 };
    (accuracy, (WORK / matrix.entries()).clamp(20, 5000))
}

/// The least eigenvalue of the square matrix of one direction.
///
/// Inverse iteration. The inverse of a totally positive matrix has signs like a checkerboard, so
/// that `|B⁻¹| x = S B⁻¹ S x` with `S = diag(±1)` is non-negative: x stays positive and, by
/// Collatz and Wielandt, the quotients of successive vectors enclose the eigenvalue.
pub fn least_eigenvalue(matrix: &Collocation) -> f64 {
    let n = matrix.columns();
    // Quadratic B-splines with knots at the data: the diagonal tells, and with equal knot spans
    // all eigenvalues coincide in one Jordan block, which iterations approach very slowly.
    if let Some(diagonal) = matrix.diagonal_if_triangular() {
        return diagonal.into_iter().fold(1.0, f64::min);
    }
    let inverse = matrix.inverse();
    let mut x: Vec<f64> = (0..n).map(alternating).collect();
    let mut estimate = 0.0;
    let (accuracy, steps) = effort(matrix);
    for _ in 0..steps {
        let before = length(&x);
        inverse.apply(&mut x);
        let after = length(&x);
        let growth = after / before;
        if !growth.is_finite() || growth == 0.0 {
            return 0.0;
        }
        x.iter_mut().for_each(|x| *x /= after);
        let settled = (growth / estimate - 1.0_f64).abs() < accuracy;
        estimate = growth;
        if settled {
            break;
        }
    }
    (1.0 / estimate).min(1.0)
}

fn alternating(i: usize) -> f64 {
    if i.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// ρ(B Bᵀ), the square of the largest singular value of one direction, by power iteration.
pub fn largest_singular_value_squared(matrix: &Collocation) -> f64 {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    // A constant vector is near the largest one; the ripple has a part of every other.
    let mut x: Vec<f64> = (0..columns).map(|i| 1.0 + 0.1 * (i as f64).sin()).collect();
    let mut y = vec![0.0; rows];
    let mut estimate = 0.0;
    let (accuracy, steps) = effort(matrix);
    for _ in 0..steps {
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

fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Refuses methods that move all control points and cannot converge. Only the Wang–Ball basis is in doubt: the others are
/// totally positive, or periodic with a positive diagonal that dominates.
pub fn check_convergence(problem: &Problem) -> Result<(), Invalid> {
    let doubtful = |direction: &Direction| {
        matches!(
            direction.basis,
            Basis::Polynomial {
                kind: Polynomial::WangBall,
                ..
            }
        )
    };
    let small = problem
        .directions()
        .all(|direction| direction.free() <= CHECKED);
    if !small || !problem.directions().any(doubtful) {
        return Ok(());
    }
    let (method, omega, real_only) = match problem.method() {
        Method::Global => ("global", 1.0, false),
        Method::Weighted { omega: Some(omega) } => ("weighted", omega, false),
        Method::Weighted { omega: None } => ("weighted", 1.0, true),
        Method::Chebyshev => ("chebyshev", 1.0, true),
        _ => return Ok(()),
    };
    let mut products = vec![nalgebra::Complex::new(1.0, 0.0)];
    for direction in problem.directions() {
        let matrix = Collocation::new(direction);
        let n = matrix.columns();
        let identity = DMatrix::<f64>::identity(n, n);
        let mut lines = vec![0.0; n * n];
        matrix.apply_to_lines(identity.as_slice(), &mut lines);
        let values = DMatrix::from_column_slice(n, n, &lines).complex_eigenvalues();
        products = products
            .iter()
            .flat_map(|a| values.iter().map(move |b| a * b))
            .collect();
    }
    if real_only && products.iter().any(|z| z.im.abs() > REAL || z.re <= 0.0) {
        return Err(Invalid::ComplexSpectrum { method });
    }
    let rate = products
        .iter()
        .map(|z| (nalgebra::Complex::new(1.0, 0.0) - z * omega).norm())
        .fold(0.0, f64::max);
    if rate > 1.0 + REAL {
        return Err(Invalid::Diverges { method, rate });
    }
    Ok(())
}
