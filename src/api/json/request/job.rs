//! The JSON of a job, and its way to a fitting problem.

use std::sync::Arc;

use schemars::JsonSchema;

use super::invalid::invalid;
use super::method::MethodRequest;
use super::mistakes::{DEFAULT_TOLERANCE, Mistakes};
use super::schema;
use super::shape::{CurveRequest, SurfaceRequest, check_count};
use super::stop::StopRequest;
use super::weights::RationalRequest;
use crate::api::json::read::object;
use crate::api::json::read::values::LONGEST_TEXT;
use crate::api::problem::Problem;
use crate::api::stream::options;
use crate::config::Config;
use crate::fit::method::Method;
use crate::fit::problem as fit;
use crate::model::stream::StreamSpec;

pub(super) const LONGEST_NAME: usize = LONGEST_TEXT;

/// A fit of a curve or of a surface: one of `curve` and `surface` is given. Fields that are not known are
/// refused.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(example = schema::example_job())]
pub struct JobRequest {
    /// A name for people. Answers and files repeat it.
    #[schemars(length(max = LONGEST_NAME), example = &"wing section")]
    pub(in crate::api) name: Option<String>,
    /// The curve to fit.
    pub(in crate::api) curve: Option<CurveRequest>,
    /// The surface to fit.
    pub(in crate::api) surface: Option<SurfaceRequest>,
    /// How weights are used; only with weights.
    pub(in crate::api) rational: Option<RationalRequest>,
    /// The method; without one `global`.
    pub(in crate::api) method: Option<MethodRequest>,
    /// When the iteration ends.
    pub(in crate::api) stop: Option<StopRequest>,
    /// What the event streams of the job are like if they do not say it themselves.
    pub(in crate::api) stream: Option<StreamSpec>,
}

object!(
    JobRequest,
    "an object",
    [name, curve, surface, rational, method, stop, stream]
);
/// A job that can be computed.
#[derive(Debug)]
pub struct ValidJob {
    /// The client's name for it.
    pub name: Option<String>,
    /// How its streams go if they do not say it themselves.
    pub stream: Option<Arc<StreamSpec>>,
    /// The problem.
    pub problem: fit::Problem,
}

impl JobRequest {
    /// Checks the request against the limits and the mathematics.
    pub fn validate(self, config: &Config) -> Result<ValidJob, Problem> {
        let mut mistakes = Mistakes::default();
        mistakes.keep(check_name(self.name.as_deref()));
        let rational = self.rational;
        let surface = self.surface.is_some();
        let shape = match (self.curve, self.surface) {
            (Some(curve), None) => curve.shape(rational, &mut mistakes),
            (None, Some(surface)) => surface.shape(rational, &mut mistakes),
            (None, None) => mistakes.keep(Err(invalid("", "a curve or a surface is needed"))),
            (Some(_), Some(_)) => {
                let detail = "the job has a curve, so it cannot have a surface as well";
                mistakes.keep(Err(invalid("/surface", detail)))
            }
        };
        let shape = shape.and_then(|shape| {
            let count = check_count(&shape, config.max_points);
            mistakes.keep(count).map(|()| shape)
        });
        let stop = self.stop.unwrap_or_default();
        let stop = mistakes.keep(stop.rules(config.max_iterations));
        let stream = self.stream.as_ref();
        let stream = stream.map(|stream| options::check(stream, surface));
        mistakes.keep(stream.transpose().map_err(Problem::from));
        let Some(mut shape) = shape else {
            let settings = self.method.map(|method| method.check_settings());
            mistakes.keep(settings.transpose());
            return Err(mistakes.problem());
        };
        let method = match self.method {
            None => Some((Method::Global, None)),
            Some(method) => {
                shape.places.control_points_each = method.has_control_points_each();
                shape.places.transform_each = method.has_transform_each();
                mistakes.keep(method.method(shape.grid, shape.v.is_some()))
            }
        };
        let Some((method, selected)) = method else {
            return Err(mistakes.problem());
        };
        // The points and the basis may be wrong beside what was found so far.
        let (tolerance, max_iterations) = stop.unwrap_or((DEFAULT_TOLERANCE, 0));
        let places = shape.places;
        let request = fit::Request {
            points: Arc::new(shape.points),
            grid: shape.grid,
            missing: shape.missing,
            u: shape.u,
            v: shape.v,
            weights: shape.weights,
            method,
            selected,
            start: None,
            lambda_min: None,
            tolerance,
            max_iterations,
        };
        let problem = mistakes.fit(request, |error| places.pointer(error));
        let problem = problem.filter(|_| mistakes.none());
        let Some(problem) = problem else {
            return Err(mistakes.problem());
        };
        Ok(ValidJob {
            name: self.name,
            stream: fitting_stream(self.stream, &problem)?,
            problem,
        })
    }
}

/// How the streams of a job go, if its data can be sent like that.
pub(super) fn fitting_stream(
    stream: Option<StreamSpec>,
    problem: &fit::Problem,
) -> Result<Option<Arc<StreamSpec>>, Problem> {
    let request = StreamSpec::default();
    options::check_range(&request, stream.as_ref(), problem)?;
    Ok(stream.map(Arc::new))
}

pub(super) fn check_name(name: Option<&str>) -> Result<(), Problem> {
    match name {
        Some(name) if name.chars().count() > LONGEST_NAME => {
            let detail = format!("the name is longer than {LONGEST_NAME} characters");
            Err(invalid("/name", detail))
        }
        _ => Ok(()),
    }
}
