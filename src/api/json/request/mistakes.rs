//! All that is wrong with a request, as far as one mistake does not follow from another.

use super::invalid::invalid;
use crate::api::json::read::MOST_MISTAKES;
use crate::api::problem::Problem;
use crate::fit::basis::knots::Knots;
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::invalid::{Axis, Invalid, Place};
use crate::fit::method::Method;
use crate::fit::parameters::Parametrization;
use crate::fit::problem::{self as fit, Tolerance, Weights};

/// What the largest distance is compared with if nobody says it; the right one where a wrong one was given.
pub(super) const DEFAULT_TOLERANCE: Tolerance = Tolerance::Relative(1e-6);

/// Of problems with so many points more than one mistake is looked for, which takes a copy.
const MOST_COPIED: usize = 10_000;

/// Mistakes that were found so far.
#[derive(Debug, Default)]
pub(in crate::api) struct Mistakes(Vec<Problem>);

impl Mistakes {
    /// The value, or a mistake more.
    pub(in crate::api) fn keep<T>(&mut self, result: Result<T, Problem>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(problem) => {
                self.0.push(problem);
                None
            }
        }
    }

    /// Whether there are none.
    pub(in crate::api) fn none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether there are as many as are told.
    pub(super) fn full(&self) -> bool {
        self.0.len() >= MOST_MISTAKES
    }

    /// The problem that tells all of them.
    pub(in crate::api) fn problem(self) -> Problem {
        let unsaid = || invalid("", "the request is not understood");
        Problem::of_all(self.0).unwrap_or_else(unsaid)
    }

    /// Looks for mistakes in the mathematics. Each that is found is set right in a copy, to find
    /// those after it. `pointer` says where they are.
    pub(super) fn fit(
        &mut self,
        request: fit::Request,
        pointer: impl Fn(&Invalid) -> String,
    ) -> Option<fit::Problem> {
        let few = request.grid.count() <= MOST_COPIED;
        let mut copy = few.then(|| request.clone());
        let mut next = Some(request);
        while let Some(request) = next.take() {
            let error = match fit::Problem::new(request) {
                Ok(problem) => return Some(problem),
                Err(error) => error,
            };
            self.0.push(invalid(&pointer(&error), error.to_string()));
            if self.full() {
                break;
            }
            let place = error.place();
            let corrected = copy.as_mut().is_some_and(|copy| correct(copy, place));
            next = copy.clone().filter(|_| corrected);
        }
        None
    }
}

/// Replaces what is wrong by something that is right; tells whether it could, and whether what is
/// wrong beside it is wrong still.
fn correct(request: &mut fit::Request, place: Place) -> bool {
    let (u, v) = (&mut request.u, &mut request.v);
    match place {
        Place::Tolerance | Place::RelativeTolerance => {
            let usual = DEFAULT_TOLERANCE;
            let same = request.tolerance == usual;
            request.tolerance = usual;
            !same
        }
        Place::Setting(_)
        | Place::Index(_)
        | Place::Transform(_)
        | Place::TransformRow(..)
        | Place::TransformEntry(..) => {
            // Other methods have other bases, and need all points.
            let alike = request.missing.is_empty()
                && !matches!(request.method, Method::Global | Method::LeastSquares(_));
            (request.method, request.selected) = (Method::Global, None);
            alike
        }
        Place::Parameters(axis) | Place::Parameter(axis, _) => {
            let choice = match (axis, v) {
                (Axis::V, Some(v)) => v,
                _ => u,
            };
            // What is explicit about the knots depends on the parameters.
            let given = matches!(choice.parameters, Parametrization::Explicit(_));
            choice.parameters = Parametrization::Uniform;
            given && !has_explicit_knots(choice)
        }
        Place::Weights | Place::Weight(_) | Place::AxisWeights(_) | Place::AxisWeight(..) => {
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
