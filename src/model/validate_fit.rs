//! Validation of a fitting problem, which collects independent errors.

use super::errors::{SpecPart, ValidationError, ValidationErrors};
use piad_fit::basis::{BasisChoice, Knots};
use piad_fit::engine::{Admission, DirectionChoice, Problem, Request, Weights, trimmed};
use piad_fit::invalid::{self as fit, Axis};
use piad_fit::method::{LeastSquares, Method};
use piad_fit::parameters::Parametrization;

/// Up to this many points more than one error is searched for, which takes a copy of the problem.
const MOST_COPIED: usize = 10_000;

impl ValidationErrors {
    /// The problem, or its errors. Each error is corrected in a copy, to find those after it.
    /// `place` maps a part of the problem to the model.
    pub(super) fn fit(
        &mut self,
        request: Request,
        admission: &Admission,
        place: impl Fn(fit::Place) -> SpecPart,
    ) -> Option<Problem> {
        let few = request.grid.count() <= MOST_COPIED;
        let mut copy = few.then(|| request.clone());
        let mut next = Some(request);
        while let Some(request) = next.take() {
            let error = match Problem::admitted(request, admission).and_then(trimmed) {
                Ok(problem) => return Some(problem),
                Err(error) => error,
            };
            let first = error.place;
            for error in error.each() {
                if self.full() {
                    self.more("there are more of them");
                    break;
                }
                let part = match error.place {
                    fit::Place::Whole => SpecPart::Whole,
                    part => place(part),
                };
                self.push(ValidationError::at(part, error.to_string()));
            }
            if self.full() {
                break;
            }
            let corrected = copy.as_mut().is_some_and(|copy| correct(copy, first));
            next = copy.clone().filter(|_| corrected);
        }
        None
    }
}

/// Replaces an invalid part by a valid one; returns true if it could and other errors stay what
/// they are.
fn correct(request: &mut Request, place: fit::Place) -> bool {
    let (u, v) = (&mut request.u, &mut request.v);
    match place {
        fit::Place::Trim | fit::Place::TrimDistance => request.trim.take().is_some(),
        fit::Place::Tolerance | fit::Place::RelativeTolerance => request.tolerance.take().is_some(),
        fit::Place::Setting(_)
        | fit::Place::Index(_)
        | fit::Place::Transform(_)
        | fit::Place::TransformRow(..)
        | fit::Place::TransformEntry(..) => {
            // Other methods have other bases, and need all points.
            let alike = request.missing.is_empty()
                && !matches!(request.method, Method::Global | Method::LeastSquares(_));
            (request.method, request.selected) = (Method::Global, None);
            alike
        }
        fit::Place::Parameters(axis) | fit::Place::Parameter(axis, _) => {
            let choice = match (axis, v) {
                (Axis::V, Some(v)) => v,
                _ => u,
            };
            // Explicit knots depend on the parameters.
            let given = matches!(choice.parameters, Parametrization::Explicit(_));
            choice.parameters = Parametrization::Uniform;
            given && !has_explicit_knots(choice)
        }
        fit::Place::Line(axis, _) => {
            let choice = match (axis, v) {
                (Axis::V, Some(v)) => v,
                _ => u,
            };
            // Settings at parameters have others then.
            let at_parameters = |method: &LeastSquares| !method.constraints.is_empty();
            let depends = has_explicit_knots(choice)
                || matches!(&request.method, Method::LeastSquares(it) if at_parameters(it));
            let by_distance = choice.parameters != Parametrization::Uniform;
            choice.parameters = Parametrization::Uniform;
            by_distance && !depends
        }
        fit::Place::Weights
        | fit::Place::Weight(_)
        | fit::Place::AxisWeights(_)
        | fit::Place::AxisWeight(..) => {
            let given = !matches!(request.weights, Weights::None) || u.weights.is_some();
            request.weights = Weights::None;
            u.weights = None;
            if let Some(v) = v {
                v.weights = None;
            }
            given
        }
        _ => false,
    }
}

fn has_explicit_knots(choice: &DirectionChoice) -> bool {
    match &choice.basis {
        BasisChoice::BSpline { knots, .. } => matches!(knots, Knots::Explicit(_)),
        BasisChoice::Polynomial(_) => false,
    }
}
