//! Knots that follow the data, for a given number of control points.

use std::sync::Arc;

use super::request::Request;
use crate::basis::choice::DirectionChoice;
use crate::invalid::{Axis, Invalid, Place};
use crate::knot_selection::adaptive;
use crate::knot_selection::breaks::Breaks;
use crate::method::{LeastSquares, Method};
use crate::setup::Setup;

/// Refuses settings that they cannot be combined with.
pub(super) fn check(request: &Request) -> Result<(), Invalid> {
    let wrong = |axis, detail| Err(Invalid::at(Place::Knots(axis), detail));
    if request.v.as_ref().is_some_and(DirectionChoice::is_adaptive) {
        return wrong(
            Axis::V,
            "\"adaptive\" places the knots of curves: a surface has them spread",
        );
    }
    if !request.u.is_adaptive() {
        return Ok(());
    }
    let found = match &request.method {
        _ if request.v.is_some() => {
            "\"adaptive\" places the knots of curves: a surface has them spread"
        }
        Method::LeastSquares(_) if request.u.weights.is_some() => {
            "\"adaptive\" places the knots of curves without fixed weights"
        }
        Method::LeastSquares(settings) if settings.robust => {
            "\"adaptive\" places knots by all points, and a robust fit leaves some out: leave knots out"
        }
        Method::LeastSquares(_) => return Ok(()),
        _ => {
            "\"adaptive\" places knots for fewer control points than data: it is for least squares"
        }
    };
    wrong(Axis::U, found)
}

/// The number of multiplications that it takes.
pub(super) fn cost(request: &Request, setup: &Setup) -> usize {
    if !request.u.is_adaptive() {
        return 0;
    }
    let width = setup.u().basis.degree() + 1;
    let each = width * (width + 2 * setup.dimension());
    2 * adaptive::ROUNDS * setup.grid().count() * each
}

/// The number of bytes that it takes: the values of the functions at all data, twice while one fit replaces another,
/// and distances.
pub(super) fn memory(request: &Request, setup: &Setup) -> usize {
    match request.u.is_adaptive() {
        true => {
            let each = 3 * (setup.u().basis.degree() + 1) + 4;
            setup.grid().count().saturating_mul(each * size_of::<f64>())
        }
        false => 0,
    }
}

/// The same curve over knots that follow the data, or over those of the fit that it starts from, if it is to have
/// adaptive ones.
pub(super) fn placed(request: &Request, setup: &Setup) -> Result<Option<Setup>, Invalid> {
    let Method::LeastSquares(settings) = &request.method else {
        return Ok(None);
    };
    if !request.u.is_adaptive() {
        return Ok(None);
    }
    let detail = "the data do not determine a fit with adaptive knots and this number of control points: give fewer, or leave knots out";
    let line = line(request, settings, setup);
    let line = line.ok_or_else(|| Invalid::at(Place::Knots(Axis::U), detail))?;
    let mut placed = setup.clone();
    placed.u = line.direction(Arc::clone(&setup.u().parameters));
    Ok(Some(placed))
}

/// The knots that follow the data, or those of the fit that this one starts from.
fn line(request: &Request, settings: &LeastSquares, setup: &Setup) -> Option<Breaks> {
    let u = setup.u();
    match &request.start_breaks {
        Some(breaks) => Breaks::new(u.basis.degree(), u.is_closed(), breaks.first()?.to_vec()),
        None => {
            let coarsest = Breaks::coarsest_of(u)?;
            let weights = settings.data_weights.as_deref();
            let weights = weights.map(|weights| Arc::new(weights.to_vec()));
            adaptive::adapted(setup.data(), weights, &u.parameters, &coarsest, u.free())
        }
    }
}
