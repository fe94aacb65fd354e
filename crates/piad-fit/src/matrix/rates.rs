//! How fast classical PIA converges with each basis, at the same parameters.
//!
//! Of all normalized totally positive bases of a space the normalized B-basis converges the fastest
//! (DP07, Theorem 4): of polynomials that is the Bernstein basis. At equal steps its least eigenvalue
//! is known, `m! / m^m` for degree m. The rate is `1 − λ_min`; Wang–Ball functions are not totally
//! positive from degree 4 on, so that theirs is `ρ(I − B)` over all eigenvalues, which can be above
//! one.

use super::collocation::Collocation;
use super::spectrum::{self, DENSE};
use super::stability::rate as spectral_radius;
use crate::basis::Polynomial;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::Direction;
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid};
use crate::parameters::Parametrization;

/// The most points of a comparison.
pub const MOST_POINTS: usize = 500;

/// The highest degree of its B-splines.
pub const MOST_DEGREE: usize = 100;

/// Least eigenvalues of dense matrices below this are spoilt by rounding.
const LEAST_KNOWN: f64 = 1e-10;

/// More iterations than this are not reported.
const MOST_ITERATIONS: f64 = 1e15;

/// The convergence of classical PIA with a basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisRate {
    /// The name of the basis.
    pub basis: &'static str,
    /// Its degree.
    pub degree: usize,
    /// The least eigenvalue of the collocation matrix, of a basis that is not totally positive the
    /// least absolute value of one; `None` where rounding hides it.
    pub lambda_min: Option<f64>,
    /// The factor by which an iteration reduces errors in the long run; above one they grow.
    pub rate: Option<f64>,
}

impl BasisRate {
    /// The number of iterations that reduce an error to the part `tolerance` of it, by the rate:
    /// `ln(tolerance) / ln(rate)`, rounded up. `None` if errors do not fall, or the number is
    /// unreasonably large.
    pub fn iterations(&self, tolerance: f64) -> Option<u64> {
        // Near one the rate has lost the digits that the eigenvalue has.
        let exact = self
            .lambda_min
            .filter(|least| Some(1.0 - least) == self.rate);
        let log = match exact {
            Some(least) => (-least).ln_1p(),
            None => self.rate?.ln(),
        };
        let count = (tolerance.ln() / log).ceil().max(1.0);
        (log < 0.0 && count < MOST_ITERATIONS).then_some(count as u64)
    }
}

/// Compares Bernstein, Said–Ball and Wang–Ball polynomials and B-splines of a degree with knots at
/// the data, for `count` points at equal steps or at the given parameters.
///
/// # Errors
///
/// Parameters that do not increase strictly or are not finite, too few points, or a degree of 0.
pub fn compare(
    count: usize,
    parameters: Option<&[f64]>,
    degree: usize,
) -> Result<Vec<BasisRate>, Invalid> {
    if count < 2 {
        return Err(Invalid::too_few_points(count));
    }
    let polynomials = [
        (Polynomial::Bernstein, "bernstein"),
        (Polynomial::SaidBall, "said_ball"),
        (Polynomial::WangBall, "wang_ball"),
    ];
    let mut rates = Vec::new();
    for (kind, basis) in polynomials {
        let direction = direction(count, parameters, BasisChoice::Polynomial(kind))?;
        let (lambda_min, rate) = match (kind, parameters) {
            (Polynomial::Bernstein, None) => {
                let least = least_of_bernstein(count - 1);
                (Some(least), Some(1.0 - least))
            }
            _ if count <= DENSE => of_polynomial(kind, &direction),
            _ => (None, None),
        };
        rates.push(BasisRate {
            basis,
            degree: count - 1,
            lambda_min,
            rate,
        });
    }
    let knots = Knots::Data;
    let splines = direction(count, parameters, BasisChoice::BSpline { degree, knots })?;
    let least = spectrum::least_eigenvalue(&Collocation::new(&splines));
    rates.push(BasisRate {
        basis: "bspline",
        degree,
        lambda_min: Some(least),
        rate: Some(1.0 - least),
    });
    Ok(rates)
}

/// A curve of `count` points with this basis.
fn direction(
    count: usize,
    parameters: Option<&[f64]>,
    basis: BasisChoice,
) -> Result<Direction, Invalid> {
    let choice = DirectionChoice::new(
        basis,
        match parameters {
            None => Parametrization::Uniform,
            Some(values) => Parametrization::Explicit(values.to_vec().into()),
        },
    );
    let grid = Grid {
        rows: count,
        columns: 1,
    };
    Direction::new(choice, &Points::zeros(1, count), grid, None, Axis::U)
}

/// λ_min and the rate, where rounding does not hide them.
fn of_polynomial(kind: Polynomial, direction: &Direction) -> (Option<f64>, Option<f64>) {
    let matrix = Collocation::new(direction);
    let least = spectrum::least_eigenvalue(&matrix);
    if least < LEAST_KNOWN || least.is_nan() {
        return (None, None);
    }
    let rate = match kind {
        Polynomial::WangBall => spectral_radius(&[matrix.to_dense()]),
        _ => Some(1.0 - least),
    };
    (Some(least), rate)
}

/// `m! / m^m`, the least eigenvalue of Bernstein polynomials at equal steps.
fn least_of_bernstein(m: usize) -> f64 {
    let degree = m as f64;
    (1..=m).map(|i| i as f64 / degree).product()
}
