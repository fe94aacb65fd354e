//! The JSON of a job, and its way to a fitting problem.

use bytes::Bytes;
use schemars::JsonSchema;

use super::method::MethodRequest;
use super::places::Places;
use super::schema;
use super::shape::{CurveRequest, SurfaceRequest};
use super::stop::StopRequest;
use crate::api::json::read::{ListLimits, object, parse};
use crate::api::problem::Problem;
use crate::config::Config;
use crate::fit::method::Method;
use crate::model::job::{JobSpec, LONGEST_NAME, ValidJob};
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::shape::ShapeSpec;
use crate::model::stop::StopSpec;
use crate::model::stream::StreamSpec;
use crate::model::weights::Rational;

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
    pub(in crate::api) rational: Option<Rational>,
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

/// The job that a body asks for, if it can be computed.
pub fn read(body: Bytes, config: &Config) -> Result<ValidJob, Problem> {
    let limits = config.limits();
    let points = limits.points;
    let request: JobRequest = parse(&body, ListLimits { points })?;
    drop(body);
    let (spec, places) = request.spec();
    let valid = spec.validate(limits);
    valid.map_err(|mistakes| Problem::of_mistakes(mistakes, &places))
}

impl JobRequest {
    /// What it asks for, and where its parts stand.
    fn spec(self) -> (JobSpec, Places) {
        let surface = self.surface.is_some();
        let (shape, mut places) = match (self.curve, self.surface) {
            (Some(curve), None) => given(curve.spec()),
            (None, Some(surface)) => surface.spec(),
            (None, None) => {
                let mistake = Mistake::at(SpecPart::Whole, "a curve or a surface is needed");
                (Err(mistake.into()), Places::default())
            }
            (Some(_), Some(_)) => {
                let detail = "the job has a curve, so it cannot have a surface as well";
                let mistake = Mistake::at_text("/surface", detail);
                (Err(mistake.into()), Places::default())
            }
        };
        places.method_each = self.method.as_ref().is_some_and(MethodRequest::is_each);
        let method = match (self.method, &shape) {
            (None, _) => Ok(Method::Global.into()),
            (Some(method), Ok(shape)) => method.spec(shape.grid, shape.v.is_some()),
            // Without points nothing but its settings can be wrong with it.
            (Some(method), Err(_)) => method.check_settings().map(|()| Method::Global.into()),
        };
        let spec = JobSpec {
            name: self.name,
            surface,
            shape,
            rational: Ok(self.rational),
            method,
            stop: self.stop.map(StopSpec::from).unwrap_or_default(),
            stream: Ok(self.stream),
        };
        (spec, places)
    }
}

fn given((shape, places): (ShapeSpec, Places)) -> (OrMistakes<ShapeSpec>, Places) {
    (Ok(shape), places)
}
