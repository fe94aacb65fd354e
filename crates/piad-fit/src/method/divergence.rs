//! Tests by all eigenvalues whether relaxations converge, where theory does not guarantee it.

use nalgebra::{Complex, Schur};

use crate::basis::direction::Direction;
use crate::basis::{Basis, Polynomial};
use crate::invalid::{Invalid, Place};
use crate::matrix::collocation::Collocation;
use crate::setup::Setup;

/// Bases that are not totally positive are checked up to this number of control points in a
/// direction: all eigenvalues take O(n³).
const CHECKED: usize = 60;

/// The most steps of the QR algorithm for each eigenvalue: it takes about two, and with numbers
/// near the ends of their range it may not end.
const MOST_QR_STEPS: usize = 100;

/// The largest imaginary part of an eigenvalue that can be rounding.
const REAL: f64 = 1e-9;

/// Refuses relaxations `U = ω I` that diverge: some eigenvalue of `I − ω B` is larger than one.
/// `method` is the name that the error gives.
pub(crate) fn check_relaxation(
    setup: &Setup,
    method: &'static str,
    omega: f64,
) -> Result<(), Invalid> {
    if !is_doubtful(setup) {
        return Ok(());
    }
    // Nothing is known for extreme weights.
    let Some(values) = eigenvalues(setup) else {
        return Ok(());
    };
    check_rate(&values, method, omega)
}

/// Refuses methods that choose their steps by λ_min, unless all eigenvalues are real and positive.
pub(crate) fn check_real(setup: &Setup, method: &'static str) -> Result<(), Invalid> {
    if !is_doubtful(setup) {
        return Ok(());
    }
    let values = eigenvalues(setup).ok_or_else(|| complex_spectrum(method))?;
    if values.iter().any(|z| z.im.abs() > REAL || z.re <= 0.0) {
        return Err(complex_spectrum(method));
    }
    check_rate(&values, method, 1.0)
}

/// A method that chooses its steps by λ_min has eigenvalues that are not real and positive.
fn complex_spectrum(method: &str) -> Invalid {
    let detail = format!(
        "{method} needs a collocation matrix with positive real eigenvalues, and this one, of a basis that is not totally positive, has others; use extended or direct"
    );
    Invalid::at(Place::Method, detail)
}

/// Refuses relaxations with which some eigenvalue `1 − ω z` of `I − ω B` is larger than one.
fn check_rate(values: &[Complex<f64>], method: &'static str, omega: f64) -> Result<(), Invalid> {
    let rate = values
        .iter()
        .map(|z| (Complex::new(1.0, 0.0) - z * omega).norm())
        .fold(0.0, f64::max);
    if rate > 1.0 + REAL {
        return Err(Invalid::at(
            Place::Method,
            format!(
                "{method} PIA diverges: with this basis and these parameters the error grows by {rate:.3} per iteration; use extended or direct"
            ),
        ));
    }
    Ok(())
}

/// Returns true if the eigenvalues of the collocation matrix must be computed. Only the Wang–Ball
/// basis needs that. The other bases are totally positive, or periodic with a diagonally dominant,
/// positive matrix.
fn is_doubtful(setup: &Setup) -> bool {
    let wang_ball = |direction: &Direction| {
        matches!(
            direction.basis,
            Basis::Polynomial {
                kind: Polynomial::WangBall,
                ..
            }
        )
    };
    let small = setup
        .directions()
        .all(|direction| direction.free() <= CHECKED);
    small && setup.directions().any(wang_ball)
}

/// All eigenvalues of the collocation matrix: of a surface the products of those of both
/// directions. `None` if the QR algorithm does not end.
fn eigenvalues(setup: &Setup) -> Option<Vec<Complex<f64>>> {
    let mut products = vec![Complex::new(1.0, 0.0)];
    for direction in setup.directions() {
        let matrix = Collocation::new(direction).to_dense();
        let steps = MOST_QR_STEPS * matrix.nrows();
        let schur = Schur::try_new(matrix, f64::EPSILON, steps)?;
        let values = schur.complex_eigenvalues();
        products = products
            .iter()
            .flat_map(|a| values.iter().map(move |b| a * b))
            .collect();
    }
    Some(products)
}
