//! The least eigenvalue of the collocation matrix, for the methods that converge by it.
//!
//! Weighted PIA with its best ω and the Chebyshev semi-iteration choose their steps by λ_min, and
//! always compute it; others only for their forecast, unless there are many points. An edit of a
//! fit passes on what is known, as points that move do not change the matrix while parameters stay.

use super::omega::Omega;
use crate::matrix::forecast::Forecast;
use crate::matrix::spectrum;
use crate::matrix::spectrum::DENSE;
use crate::matrix::tensor::Tensor;
use crate::setup::Setup;

/// Up to this number of points in a direction λ_min is computed for the forecast alone; methods
/// that need it always have it.
const FORECAST: usize = 100_000;

/// Returns true if λ_min is computed for the forecast alone: of polynomials up to [`DENSE`] points.
pub(super) fn is_small(setup: &Setup) -> bool {
    setup.directions().all(|direction| {
        let most = match direction.basis.is_local() {
            true => FORECAST,
            false => DENSE,
        };
        direction.parameters.len() <= most
    })
}

/// λ_min of the collocation matrix, if it is not known yet: of a surface the product of those of
/// both directions.
pub(super) fn least(setup: &Setup, collocation: &Tensor) -> f64 {
    let directions = collocation.directions();
    let compute = || directions.map(spectrum::least_eigenvalue).product();
    setup.lambda_min().unwrap_or_else(compute)
}

/// The forecast of classical PIA, whose error shrinks by `1 − λ_min` in the long run (LBW05,
/// Theorem 2.1), unless there are many points.
pub(super) fn classical(setup: &Setup, collocation: &Tensor) -> Forecast {
    if !is_small(setup) {
        return Forecast::default();
    }
    let lambda = least(setup, collocation);
    Forecast {
        lambda_min: Some(lambda),
        rate: Some(1.0 - lambda),
        ..Forecast::default()
    }
}

/// The forecast of fits that move only some control points with ω: that of classical PIA with this
/// relaxation is a bound. λ_min is also computed of many points if ω depends on it.
pub(super) fn relaxed(setup: &Setup, collocation: &Tensor, omega: Omega) -> Forecast {
    let needed = omega == Omega::Best || is_small(setup);
    let lambda_min = needed.then(|| least(setup, collocation));
    let omega = omega.of(lambda_min);
    Forecast {
        lambda_min,
        omega: Some(omega),
        rate: lambda_min.map(|least| spectrum::relaxed_rate(omega, least, 1.0)),
        ..Forecast::default()
    }
}
