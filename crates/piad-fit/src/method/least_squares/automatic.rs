//! As few control points as the tolerance needs: what can be chosen, and what does not go with it.

use super::constraints::{At, Constraint};
use super::settings::{Automatic, EndPoints, LeastSquares, Variant};
use crate::basis::knots::Knots;
use crate::choice::{BasisChoice, DirectionChoice};
use crate::invalid::{Axis, Invalid, Place, Setting};
use crate::problem::Weights;
use crate::request::Request;

impl LeastSquares {
    /// With at most so many control points in both directions, and as few as will do.
    pub fn automatic(u: usize, v: usize) -> Self {
        Self {
            automatic: Some(Automatic::default()),
            ..Self::new(u, v)
        }
    }

    /// Whether the schedule of knots can take steps of plain least squares: nothing is to be obeyed but
    /// the end points, and nothing weighed but the data.
    pub(crate) fn is_plain(&self) -> bool {
        self.constraints.is_empty() && !self.has_energy() && self.ends != EndPoints::Free
    }

    /// The same of a surface, whose data all count alike.
    pub(crate) fn is_plain_surface(&self) -> bool {
        self.is_plain() && self.data_weights.is_none()
    }
}

/// Refuses what an automatic fit does not do.
pub(crate) fn check_request(request: &Request) -> Result<(), Invalid> {
    let Some((settings, automatic)) = request.method.automatic() else {
        return Ok(());
    };
    if settings.variant != Variant::ConjugateGradients {
        return Err(Invalid::at(
            Place::Setting(Setting::Variant),
            "with control_points \"auto\" the fit takes steps of conjugate gradients and minima in turn: variant is left out, or cg",
        ));
    }
    let choices = || std::iter::once(&request.u).chain(&request.v);
    let fixed = |choice: &DirectionChoice| choice.weights.is_some();
    if request.weights != Weights::None || choices().any(fixed) {
        return Err(Invalid::at(
            Place::Weights,
            "with control_points \"auto\" curves and surfaces have no weights",
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
    if automatic.correct_parameters && (request.v.is_some() || !settings.is_plain()) {
        return Err(Invalid::at(
            Place::Setting(Setting::CorrectParameters),
            "correct_parameters is for curves without constraints and fairness whose ends are interpolated",
        ));
    }
    if let Some(&index) = request.missing.first() {
        return Err(Invalid::at(
            Place::Point(index),
            "with control_points \"auto\" no point of a grid is missing: give those that are there as scattered points",
        ));
    }
    let along = |constraint: &Constraint| matches!(constraint.at, At::Boundary(..));
    match settings.constraints.iter().position(along) {
        Some(index) => Err(Invalid::at(
            Place::Constraint(index),
            "with control_points \"auto\" the knots along a boundary change from level to level: one with given control points needs a number of them",
        )),
        None => Ok(()),
    }
}
