//! The JSON of a job.

use bytes::Bytes;
use serde_json::Value;

use super::places::Places;
use super::points::{self, Data};
use crate::api::json::read::parse;
use crate::api::problem::Problem;
use crate::model::job::JobRequest;
use crate::model::points::{PointGrid, PointList};
use crate::model::scattered::SurfaceParameters;
use piad_fit::parameters::Scattered;

/// Shorter bodies are read by serde alone, which takes negligible time.
const SERDE_BODY_BYTES: usize = 2 * 1024;

/// The number of bytes of points that one thread reads at a time.
const PART: usize = 1 << 20;

/// The job of a body, with at most this many points, and the locations of its parts.
pub(crate) fn read(body: Bytes, most_points: usize) -> Result<(JobRequest, Places), Problem> {
    let quick = (body.len() >= SERDE_BODY_BYTES)
        .then(|| read_quickly(&body, PART, most_points))
        .flatten();
    match quick {
        Some(request) => Ok(placed(request)),
        None => read_by_serde(&body, most_points).map(placed),
    }
}

/// The request that [`read_by_serde`] reads; `None` for an unusual body.
pub(crate) fn read_quickly(body: &[u8], part: usize, most_points: usize) -> Option<JobRequest> {
    let (fields, data) = points::take_out(body, part, most_points)?;
    let mut request: JobRequest = parse(&fields, most_points).ok()?;
    let is_one = request.curve.is_some() != request.surface.is_some();
    (is_one && request.take(data)).then_some(request)
}

/// The request of any body, or its errors.
pub(crate) fn read_by_serde(body: &[u8], most_points: usize) -> Result<JobRequest, Problem> {
    parse(body, most_points)
}

/// Validates fields of a job that will get other fields and points.
pub(crate) fn check_defaults(fields: &[u8], most_points: usize) -> Result<(), Problem> {
    let mut value: Value = serde_json::from_slice(fields).unwrap_or_default();
    let curve = value.get_mut("curve").and_then(Value::as_object_mut);
    if let Some(curve) = curve {
        curve
            .entry("points")
            .or_insert_with(|| Vec::<u8>::new().into());
    }
    match value {
        Value::Object(_) => parse::<JobRequest>(value.to_string().as_bytes(), most_points),
        _ => parse(fields, most_points),
    }
    .map(drop)
}

fn placed(request: JobRequest) -> (JobRequest, Places) {
    let places = Places::of_job(&request);
    (request, places)
}

/// The job of these fields, with these points in place of the empty ones.
pub(crate) fn read_with(
    fields: &[u8],
    data: Data,
    most_points: usize,
) -> Result<(JobRequest, Places), Problem> {
    let mut request: JobRequest = parse(fields, most_points)?;
    // Without a curve or a surface that is an object nothing was read.
    request.take(data);
    Ok(placed(request))
}

impl JobRequest {
    /// Replaces empty points; returns true if there was a place for them.
    fn take(&mut self, data: Data) -> bool {
        let (curve, surface) = (self.curve.as_mut(), self.surface.as_mut());
        match data {
            Data::Curve(points) => {
                let place = curve.map(|curve| &mut curve.points);
                put(place.filter(|it| it.0.is_empty()), PointList(points.into()))
            }
            Data::Grid(points, grid, missing) => {
                let place = surface.and_then(|surface| surface.points.as_mut());
                let points = PointGrid {
                    points: points.into(),
                    missing,
                    grid,
                };
                put(place.filter(|it| it.points.is_empty()), points)
            }
            Data::Mesh(points, mesh) => {
                if let Some(surface) = surface {
                    let mesh = SurfaceParameters::Scattered(Scattered::Mesh(mesh));
                    surface.parameters.get_or_insert(mesh);
                }
                self.take(Data::Scattered(points))
            }
            Data::Scattered(points) => {
                let place = surface.and_then(|surface| surface.scattered.as_mut());
                put(place.filter(|it| it.0.is_empty()), PointList(points.into()))
            }
        }
    }
}

fn put<T>(place: Option<&mut T>, value: T) -> bool {
    place.map(|place| *place = value).is_some()
}
