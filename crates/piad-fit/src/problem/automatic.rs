//! Settings that cannot be combined with the fewest control points for a tolerance.

use super::request::{Request, Weights};
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::invalid::{Axis, Invalid, Place, Setting};
use crate::method::{At, Constraint, Variant};
use crate::parameters::Scattered;

/// Refuses settings that an automatic fit does not support.
pub(crate) fn check_request(request: &Request) -> Result<(), Invalid> {
    let Some((settings, automatic)) = request.method.automatic() else {
        return Ok(());
    };
    if settings.variant != Variant::ConjugateGradients {
        return Err(Invalid::at(
            Place::Setting(Setting::Variant),
            "a fit that chooses the number of its control points alternates steps of conjugate gradients with minima: no other variant is possible",
        ));
    }
    let choices = || std::iter::once(&request.u).chain(&request.v);
    let fixed = |choice: &DirectionChoice| choice.weights.is_some();
    if request.weights != Weights::None || choices().any(fixed) {
        return Err(Invalid::at(
            Place::Weights,
            "a fit that chooses the number of its control points cannot have weights",
        ));
    }
    let free = |choice: &DirectionChoice| match &choice.basis {
        BasisChoice::BSpline { knots, .. } => matches!(knots, Knots::Usual | Knots::Spread),
        BasisChoice::Polynomial(_) => false,
    };
    let mut axes = choices().zip([Axis::U, Axis::V]);
    if let Some((_, axis)) = axes.find(|(choice, _)| !free(choice)) {
        return Err(Invalid::automatic_knots(axis));
    }
    let has_parameters_that_move = match request.v {
        None => settings.is_plain(),
        Some(_) => {
            let moves = !matches!(request.scattered, None | Some(Scattered::Sections(_)));
            moves && settings.allows_poles() && !settings.robust
        }
    };
    if automatic.correct_parameters && !has_parameters_that_move {
        return Err(Invalid::at(
            Place::Setting(Setting::CorrectParameters),
            "correct_parameters is for curves without constraints and fairness whose ends are interpolated, and for scattered points that are no sections, without constraints, data_weights and robust",
        ));
    }
    let along = |constraint: &Constraint| matches!(constraint.at, At::Boundary(..));
    match settings.constraints.iter().position(along) {
        Some(index) => Err(Invalid::at(
            Place::Constraint(index),
            "a fit that chooses the number of its control points changes the knots along a boundary from level to level: a boundary with given control points needs a given number of them",
        )),
        None => Ok(()),
    }
}
