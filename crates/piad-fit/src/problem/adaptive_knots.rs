//! Knots that are placed where the data ask for them, for a given number of control points.

use std::sync::Arc;

use super::request::Request;
use crate::basis::Basis;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::Direction;
use crate::basis::knots::Knots;
use crate::invalid::{Axis, Invalid, Place};
use crate::knot_selection::adaptive;
use crate::knot_selection::breaks::Breaks;
use crate::method::Method;
use crate::setup::Setup;

/// Returns true if the knots of a direction are placed by the data.
fn is_adaptive(choice: &DirectionChoice) -> bool {
    let BasisChoice::BSpline { knots, .. } = &choice.basis else {
        return false;
    };
    *knots == Knots::Adaptive
}

/// Asks for the knots of an open direction as they have been placed.
pub(super) fn keep(choice: &mut DirectionChoice, direction: &Direction) {
    let is_open = is_adaptive(choice) && !choice.closed;
    if let (true, BasisChoice::BSpline { knots, .. }, Basis::BSpline { knots: own, .. }) =
        (is_open, &mut choice.basis, &direction.basis)
    {
        *knots = Knots::Explicit(Arc::clone(own));
    }
}

/// Refuses what they cannot be combined with.
pub(super) fn check(request: &Request) -> Result<(), Invalid> {
    let wrong = |axis, detail| Err(Invalid::at(Place::Knots(axis), detail));
    if request.v.as_ref().is_some_and(is_adaptive) {
        return wrong(
            Axis::V,
            "\"adaptive\" places the knots of curves: a surface has them spread",
        );
    }
    if !is_adaptive(&request.u) {
        return Ok(());
    }
    let found = match &request.method {
        _ if request.v.is_some() => {
            "\"adaptive\" places the knots of curves: a surface has them spread"
        }
        Method::LeastSquares(_) if request.u.weights.is_some() => {
            "\"adaptive\" places the knots of curves without fixed weights"
        }
        Method::LeastSquares(_) => return Ok(()),
        _ => {
            "\"adaptive\" places knots for fewer control points than data: it is for least squares"
        }
    };
    wrong(Axis::U, found)
}

/// How many multiplications it takes.
pub(super) fn cost(request: &Request, setup: &Setup) -> usize {
    if !is_adaptive(&request.u) {
        return 0;
    }
    let width = setup.u().basis.degree() + 1;
    let each = width * (width + 2 * setup.dimension());
    2 * adaptive::ROUNDS * setup.grid().count() * each
}

/// The same curve over the knots that its data ask for, if it is to have them.
pub(super) fn placed(request: &Request, setup: &Setup) -> Option<Setup> {
    let Method::LeastSquares(settings) = &request.method else {
        return None;
    };
    if !is_adaptive(&request.u) {
        return None;
    }
    let u = setup.u();
    let t = &u.parameters;
    let end = u.period().map_or(t[t.len() - 1], |period| t[0] + period);
    let coarsest = Breaks::coarsest(u.basis.degree(), u.is_closed(), t[0], end)?;
    let weights = settings.data_weights.as_deref();
    let weights = weights.map(|weights| Arc::new(weights.to_vec()));
    let line = adaptive::adapted(setup.data(), weights, t, &coarsest, u.free())?;
    let mut placed = setup.clone();
    placed.u = line.direction(Arc::clone(t));
    Some(placed)
}
