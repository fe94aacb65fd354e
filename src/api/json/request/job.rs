//! The JSON of a job, and its way to a fitting problem.

use bytes::Bytes;
use schemars::JsonSchema;
use serde::Deserialize;

use super::method::MethodRequest;
use super::places::Places;
use super::schema;
use super::shape::{CurveRequest, SurfaceRequest};
use super::stop::StopRequest;
use crate::api::json::points::{PointGrid, PointList, ScatteredPoints};
use crate::api::json::read::parse;
use crate::api::problem::Problem;
use crate::fit::method::Method;
use crate::fit::points::{Grid, Points};
use crate::model::either::object;
use crate::model::job::{JobSpec, LONGEST_NAME};
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::shape::ShapeSpec;
use crate::model::stop::StopSpec;
use crate::model::stream::StreamSpec;
use crate::model::weights::Rational;

/// A fit of a curve or of a surface: one of `curve` and `surface` is given. Fields that are not known are
/// refused.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
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

object!(JobRequest, "an object");

/// The job that a body asks for, and where its parts stand.
pub fn read(body: Bytes) -> Result<(JobSpec, Places), Problem> {
    Ok(parse::<JobRequest>(&body)?.spec())
}

/// Points that are not a part of the JSON of a job.
#[derive(Debug)]
pub enum Data {
    /// Those of a curve.
    Curve(Points),
    /// Those of a surface, in rows.
    Grid(Points, Grid),
    /// Those of a surface, without rows.
    Scattered(Points),
}

/// The job that these fields ask for, with these points in the place of the ones that are empty there.
pub fn read_with(fields: &[u8], data: Data) -> Result<(JobSpec, Places), Problem> {
    let mut request: JobRequest = parse(fields)?;
    match (data, &mut request.curve, &mut request.surface) {
        (Data::Curve(points), Some(curve), _) => curve.points = PointList(points),
        (Data::Grid(points, grid), _, Some(surface)) => {
            surface.points = Some(PointGrid {
                points,
                missing: Vec::new(),
                rows: grid.rows,
                columns: grid.columns,
            });
        }
        (Data::Scattered(points), _, Some(surface)) => {
            surface.scattered = Some(ScatteredPoints(points));
        }
        // Without a curve or a surface that is an object nothing was read.
        _ => {}
    }
    Ok(request.spec())
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
        let form = self.method.as_ref().map(MethodRequest::form);
        places.method = form.unwrap_or_default();
        let method = match (self.method, &shape) {
            (None, _) => Ok(Method::Global.into()),
            (Some(method), Ok(shape)) => method.spec(shape.grid, shape.v.is_some()),
            // Without points nothing is said of it.
            (Some(_), Err(_)) => Ok(Method::Global.into()),
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
