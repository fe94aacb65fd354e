//! Decides whether `X ← X + U (P − B X)` diverges, by the eigenvalues of `M = U B`.
//!
//! The iteration contracts by `ρ(I − M) = max |1 − λ|` over the eigenvalues λ of M; on surfaces
//! they are the products of those of both directions. Computed eigenvalues of a matrix that is not
//! normal can be far from the exact ones: of a Jordan block of n rows they lie on a circle with a
//! radius of about `ε^(1/n)`. So an eigenvalue counts as diverging only if it does whatever
//! rounding has done to it. By first-order perturbation theory it is wrong by at most
//!
//! ```text
//! κ(λ) n ε ‖M‖,   κ(λ) = ‖x‖ ‖y‖ / |yᴴ x|
//! ```
//!
//! with its right and left eigenvectors x and y (Golub, Van Loan, *Matrix Computations*, section
//! 7.2.2).
//!
//! The QR algorithm takes about 25 n³ operations, and each condition number two complex LU
//! decompositions: for n = 500 less than a second in all. Doubtful cases are accepted; divergence
//! then shows during the fit.

use nalgebra::{Complex, DMatrix, DVector, Schur};

/// The most steps of the QR algorithm for each eigenvalue.
const MOST_QR_STEPS: usize = 100;

/// The most eigenvalues that are examined: those that seem to diverge the most.
const MAX_CANDIDATES: usize = 4;

/// Steps of the inverse iteration for an eigenvector.
const STEPS: usize = 3;

/// An eigenvalue with at most this error is well known.
const WELL_KNOWN: f64 = 1e-9;

/// One, as a complex number.
const ONE: Complex<f64> = Complex::new(1.0, 0.0);

/// An eigenvalue of each direction, and the distance of their product from one.
struct Candidate {
    /// The eigenvalue of each direction.
    values: Vec<Complex<f64>>,
    /// `|1 − λ|` of their product λ.
    rate: f64,
}

/// ρ(I − M) of the tensor product M of the matrices of all directions, as computed. `None` if the
/// QR algorithm does not end.
pub(crate) fn rate(matrices: &[DMatrix<f64>]) -> Option<f64> {
    let first = candidates(matrices)?.into_iter().next();
    first.map(|candidate| candidate.rate)
}

/// ρ(I − M), if that is certainly not less than one.
///
/// An eigenvalue λ with `|1 − λ| > 1` by more than its error diverges. One with `|1 − λ| = 1` but
/// for a small error oscillates if it is far from zero; near zero its part of the error stays
/// constant, as that of a selection does.
pub(crate) fn diverging_rate(matrices: &[DMatrix<f64>]) -> Option<f64> {
    let candidates = candidates(matrices)?;
    let certain = candidates
        .into_iter()
        .take(MAX_CANDIDATES)
        .find(|candidate| {
            if candidate.rate < 1.0 - WELL_KNOWN {
                return false;
            }
            let error = error(matrices, &candidate.values);
            let overshoots = candidate.product().norm() >= 1.0 && error < WELL_KNOWN;
            candidate.rate > 1.0 + error || (overshoots && candidate.rate >= 1.0 - error)
        });
    certain.map(|candidate| candidate.rate)
}

impl Candidate {
    /// The eigenvalue of the tensor product.
    fn product(&self) -> Complex<f64> {
        self.values.iter().product()
    }
}

/// The eigenvalues of the tensor product, the least contracting first: at most [`MAX_CANDIDATES`] of
/// them. `None` if the QR algorithm does not end.
fn candidates(matrices: &[DMatrix<f64>]) -> Option<Vec<Candidate>> {
    let mut products = vec![Vec::new()];
    for matrix in matrices {
        let steps = MOST_QR_STEPS * matrix.nrows();
        let schur = Schur::try_new(matrix.clone(), f64::EPSILON, steps)?;
        let values = schur.complex_eigenvalues();
        products = products
            .iter()
            .flat_map(|before| values.iter().map(move |&value| (before, value)))
            .map(|(before, value): (&Vec<Complex<f64>>, _)| {
                before.iter().copied().chain([value]).collect()
            })
            .collect();
    }
    let mut candidates: Vec<Candidate> = products
        .into_iter()
        .map(|values| {
            let product: Complex<f64> = values.iter().product();
            let rate = (ONE - product).norm();
            Candidate { values, rate }
        })
        .collect();
    candidates.sort_by(|a, b| f64::total_cmp(&b.rate, &a.rate));
    candidates.truncate(MAX_CANDIDATES);
    Some(candidates)
}

/// How far the product of these eigenvalues of the matrices can be from the exact one.
fn error(matrices: &[DMatrix<f64>], values: &[Complex<f64>]) -> f64 {
    let product: Complex<f64> = values.iter().product();
    let each = matrices.iter().zip(values).map(|(matrix, &value)| {
        let n = matrix.nrows() as f64;
        let own = condition(matrix, value) * n * f64::EPSILON * matrix.norm();
        // Relative to this eigenvalue, and then of the product.
        if values.len() == 1 || value.norm() == 0.0 {
            own
        } else {
            own * product.norm() / value.norm()
        }
    });
    each.sum::<f64>()
}

/// The condition number κ of an eigenvalue; infinite if its eigenvectors are not found.
fn condition(matrix: &DMatrix<f64>, value: Complex<f64>) -> f64 {
    let right = eigenvector(matrix, value);
    let left = eigenvector(&matrix.transpose(), value);
    match right.zip(left) {
        // The left eigenvector y is the conjugate of that of the transpose.
        Some((x, y)) => {
            1.0 / x
                .iter()
                .zip(y.iter())
                .map(|(x, y)| x * y)
                .sum::<Complex<f64>>()
                .norm()
        }
        None => f64::INFINITY,
    }
}

/// The eigenvector of unit length that belongs to an eigenvalue, by inverse iteration. `None` if it
/// overflows.
fn eigenvector(matrix: &DMatrix<f64>, value: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let n = matrix.nrows();
    // Not quite singular: the direction of the solution is what counts.
    let shift = value + Complex::from(f64::EPSILON * matrix.norm().max(f64::MIN_POSITIVE));
    let mut shifted = matrix.map(Complex::from);
    for i in 0..n {
        shifted[(i, i)] -= shift;
    }
    let lu = shifted.lu();
    let mut x = DVector::from_fn(n, |i, _| Complex::from(1.0 + 0.1 * (i as f64).sin()));
    for _ in 0..STEPS {
        x = lu.solve(&x)?;
        let length = x.norm();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        x.unscale_mut(length);
    }
    Some(x)
}
