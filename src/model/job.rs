//! A requested job, and its way to a fitting problem.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::{OrErrors, SpecPart, ValidationError, ValidationErrors};
use super::method::MethodInput;
use super::scattered::{FootPoints, no_base, on_surface};
use super::schema;
use super::serde_helpers::object;
use super::shape::CurveInput;
use super::stop::StopRules;
use super::stream::StreamSpec;
use super::surface::SurfaceInput;
use super::weights::Rational;
use piad_files::json::check_count;
use piad_fit::data::Grid;
use piad_fit::engine::{Admission, Problem, Request, Tolerance};
use piad_fit::geometry::Nurbs;
use piad_fit::invalid as fit;
use piad_fit::method::{AS_MANY_AS_DATA, LeastSquares, Method};
use piad_fit::parameters::Scattered;

/// The most characters of a name.
pub const LONGEST_NAME: usize = 200;

/// A fit of a curve or of a surface: one of `curve` and `surface` is given. Fields that are not known are
/// refused.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_job())]
pub struct JobRequest {
    /// A name for people. Answers and files repeat it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = LONGEST_NAME), example = &"wing section")]
    pub(crate) name: Option<String>,
    /// The curve to fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) curve: Option<CurveInput>,
    /// The surface to fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) surface: Option<SurfaceInput>,
    /// The use of weights; only with weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rational: Option<Rational>,
    /// The method; without one `global`, and of polylines, sections, meshes, and, with a tolerance, scattered points and grids with missing points least squares with `control_points` `"auto"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) method: Option<MethodInput>,
    /// When the iteration ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stop: Option<StopRules>,
    /// The default stream options of the job.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stream: Option<StreamSpec>,
}

object!(JobRequest, "an object");

/// A valid job.
#[derive(Debug)]
pub struct ValidJob {
    /// The client's name for it.
    pub name: Option<String>,
    /// The default options of its streams.
    pub stream: Option<Arc<StreamSpec>>,
    /// The problem.
    pub problem: Problem,
}

/// The limits of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most data points.
    pub(crate) points: usize,
    /// The most iterations.
    pub(crate) iterations: usize,
    /// The limits of a fit.
    pub(crate) admission: Admission,
}

impl JobRequest {
    /// The request for the same problem. The start of an edit is not a part of it: that is its iteration 0.
    pub(crate) fn of(name: Option<String>, stream: Option<StreamSpec>, request: &Request) -> Self {
        Self {
            name,
            curve: request.v.is_none().then(|| CurveInput::of(request)),
            surface: request.v.as_ref().map(|v| SurfaceInput::of(request, v)),
            rational: Rational::of(request),
            method: Some(MethodInput::of(request)),
            stop: Some(StopRules::of(request)),
            stream,
        }
    }

    /// The job on whose surface scattered points have their foot points.
    pub(crate) fn base(&self) -> Option<&FootPoints> {
        self.surface.as_ref().and_then(SurfaceInput::base)
    }

    /// Validates the job. `base` is the surface of `Self::base`, or why there is none.
    pub fn validate(
        self,
        limits: Limits,
        base: Result<&Nurbs, ValidationError>,
    ) -> OrErrors<ValidJob> {
        let mut errors = ValidationErrors::default();
        let (name, stream) = (self.name.clone(), self.stream.clone());
        errors.keep(check_name(name.as_deref()));
        let request = self.problem(limits.points, limits.iterations, base, &mut errors);
        // The points and the basis may have further errors.
        let problem =
            request.and_then(|request| errors.fit(request, &limits.admission, SpecPart::Fit));
        ValidJob::new(name, stream, problem, errors)
    }

    /// The problem of a job that was accepted before: no limit is checked.
    pub(crate) fn request(self) -> OrErrors<Request> {
        let mut errors = ValidationErrors::default();
        match self.problem(usize::MAX, usize::MAX, Err(no_base()), &mut errors) {
            Some(request) => errors.or(request),
            None => Err(errors),
        }
    }

    /// The requested problem, with at most this many points and iterations.
    fn problem(
        self,
        most_points: usize,
        most_iterations: usize,
        base: Result<&Nurbs, ValidationError>,
        errors: &mut ValidationErrors,
    ) -> Option<Request> {
        let (is_surface, has_base) = (self.surface.is_some(), self.base().is_some());
        let (grid, request) = match (self.curve, self.surface) {
            (Some(curve), None) => (
                Some(curve.points.grid()),
                curve.request(self.rational, errors),
            ),
            (None, Some(surface)) => (surface.grid(), surface.request(self.rational, errors)),
            (None, None) => {
                let detail = "a curve or a surface is needed";
                errors.push(ValidationError::at(SpecPart::Whole, detail));
                (None, None)
            }
            (Some(_), Some(_)) => {
                let detail = "the job has a curve, so it cannot have a surface as well";
                errors.push(ValidationError::at_text("/surface", detail));
                (None, None)
            }
        };
        let count = grid.map_or(0, Grid::count);
        let too_many = |detail| ValidationError::at(SpecPart::Fit(fit::Place::Points), detail);
        let is_small = check_count(count, most_points).map_err(too_many);
        let is_small = errors.keep(is_small).is_some();
        let stop = self.stop.unwrap_or_default();
        let (tolerance, max_iterations) = stop.resolve(most_iterations, errors);
        if let Some(stream) = &self.stream {
            errors.keep(stream.check(is_surface));
        }
        // Without points the method is not validated.
        let method = match self.method {
            None if request
                .as_ref()
                .is_some_and(|it| has_one_method(it, tolerance)) =>
            {
                let fewest = LeastSquares::automatic(AS_MANY_AS_DATA, AS_MANY_AS_DATA);
                Ok(Method::LeastSquares(fewest).into())
            }
            method => method.unwrap_or_default().choice(grid?, is_surface),
        };
        let method = errors.keep(method);
        let mut request = request.filter(|_| is_small)?;
        let method = method?;
        (request.method, request.selected) = (method.method, method.selected);
        (request.tolerance, request.max_iterations) = (tolerance, max_iterations);
        if has_base {
            request.scattered = Some(errors.keep(on_surface(&request.points, base))?);
        }
        Some(request)
    }
}

/// Returns true if only least squares with as few control points as the tolerance needs fits the request: the edges of
/// a polyline, sections, meshes, and scattered points and grids with missing points for which there is a tolerance.
fn has_one_method(request: &Request, tolerance: Option<Tolerance>) -> bool {
    let scattered = request.scattered.as_ref();
    let is_one_kind =
        scattered.is_some_and(|it| matches!(it, Scattered::Sections(_) | Scattered::Mesh(_)));
    let is_incomplete = scattered.is_some() || !request.missing.is_empty();
    request.polyline || is_one_kind || is_incomplete && tolerance.is_some()
}

impl ValidJob {
    /// The job, if there are no errors.
    pub(super) fn new(
        name: Option<String>,
        stream: Option<StreamSpec>,
        problem: Option<Problem>,
        mut errors: ValidationErrors,
    ) -> OrErrors<Self> {
        let Some(problem) = problem.filter(|_| errors.none()) else {
            return Err(errors);
        };
        let fits = stream.as_ref().map(|stream| stream.check_range(&problem));
        errors.keep(fits.transpose());
        errors.or(Self {
            name,
            stream: stream.map(Arc::new),
            problem,
        })
    }
}

pub(super) fn check_name(name: Option<&str>) -> OrErrors<()> {
    match name {
        Some(name) if name.chars().count() > LONGEST_NAME => {
            let detail = format!("the name is longer than {LONGEST_NAME} characters");
            Err(ValidationError::at(SpecPart::Name, detail).into())
        }
        _ => Ok(()),
    }
}
