//! The JSON of a job.

use std::sync::Arc;

use bytes::Bytes;

use super::places::Places;
use crate::api::json::read::parse;
use crate::api::problem::Problem;
use crate::fit::points::{Grid, Points};
use crate::model::job::JobRequest;
use crate::model::points::{PointGrid, PointList};

/// The job that a body asks for, and where its parts stand.
pub(crate) fn read(body: Bytes) -> Result<(JobRequest, Places), Problem> {
    let request: JobRequest = parse(&body)?;
    let places = Places::of_job(&request);
    Ok((request, places))
}

/// Points that are not a part of the JSON of a job.
#[derive(Debug)]
pub(crate) enum Data {
    /// Those of a curve.
    Curve(Points),
    /// Those of a surface, in rows.
    Grid(Points, Grid),
    /// Those of a surface, without rows.
    Scattered(Points),
}

/// The job that these fields ask for, with these points in the place of the ones that are empty there.
pub(crate) fn read_with(fields: &[u8], data: Data) -> Result<(JobRequest, Places), Problem> {
    let mut request: JobRequest = parse(fields)?;
    match (data, &mut request.curve, &mut request.surface) {
        (Data::Curve(points), Some(curve), _) => curve.points = PointList(Arc::new(points)),
        (Data::Grid(points, grid), _, Some(surface)) => {
            surface.points = Some(PointGrid {
                points: Arc::new(points),
                missing: Vec::new(),
                grid,
            });
        }
        (Data::Scattered(points), _, Some(surface)) => {
            surface.scattered = Some(PointList(Arc::new(points)));
        }
        // Without a curve or a surface that is an object nothing was read.
        _ => {}
    }
    let places = Places::of_job(&request);
    Ok((request, places))
}
