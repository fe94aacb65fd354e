//! Problems as they were asked for, as protobuf messages.
//!
//! The problem itself follows from what was asked for: it is computed again when it is read.

use std::sync::Arc;

use prost::Message;

use super::super::StoreError;
use super::error::{damaged, mistaken};
use super::points::PointsMessage;
use super::result::{Numbers, lists, numbers};
use crate::fit::problem::{Problem, Request};
use crate::model::job::JobRequest;
use crate::proto::job;
use crate::proto::messages as pb;

/// A problem as it was asked for.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Input {
    /// What a client would say to ask for it. Its name and its streams are in the header.
    #[prost(message, optional, tag = "1")]
    job: Option<pb::JobInput>,
    /// The start of an edit.
    #[prost(message, optional, tag = "2")]
    start: Option<PointsMessage>,
    #[prost(double, optional, tag = "3")]
    lambda_min: Option<f64>,
    /// The breaks of the knots of that start, of a fit that chooses its knots.
    #[prost(message, repeated, tag = "4")]
    start_breaks: Vec<Numbers>,
}

impl Input {
    /// What was asked for.
    pub(super) fn new(problem: &Problem) -> Self {
        let request = problem.request();
        Self {
            job: Some(job::message(None, request, None)),
            start: request.start.as_deref().map(PointsMessage::new),
            start_breaks: numbers(request.start_breaks.as_deref().unwrap_or_default()),
            lambda_min: request.lambda_min,
        }
    }

    /// What was asked for, to be computed again, from these bytes.
    pub(super) fn read(bytes: &[u8]) -> Result<Request, StoreError> {
        Self::decode(bytes).map_err(damaged)?.into_request()
    }

    /// What was asked for.
    pub(super) fn into_request(self) -> Result<Request, StoreError> {
        let job = self.job.ok_or_else(|| damaged("no problem"))?;
        let start = self.start.map(PointsMessage::into_points).transpose()?;
        let job = job::request(job, usize::MAX);
        let request = job.and_then(JobRequest::request).map_err(mistaken)?;
        Ok(Request {
            start: start.map(Arc::new),
            start_breaks: lists(self.start_breaks),
            lambda_min: self.lambda_min,
            ..request
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples::problem;
    use crate::proto::messages::job_input::Geometry;

    #[test]
    fn what_does_not_fit_together_is_damage() {
        let whole = Input::new(&problem());
        assert!(whole.clone().into_request().is_ok());
        let surface = |rows, columns, missing: &[u32]| {
            let (dimension, points, missing) = (1, vec![0.5; 20], missing.to_vec());
            Some(Geometry::Surface(pb::Surface {
                dimension,
                rows,
                columns,
                points,
                missing,
                ..pb::Surface::default()
            }))
        };
        let read = |geometry| {
            let mut input = whole.clone();
            input.job.as_mut().unwrap().geometry = geometry;
            input.into_request()
        };
        assert!(read(surface(10, 2, &[19])).is_ok());
        let damages = [
            surface(11, 2, &[]),
            surface(u32::MAX, u32::MAX, &[]),
            surface(10, 2, &[20]),
            Some(Geometry::Curve(pb::Curve::default())),
            None,
        ];
        for (k, damage) in damages.into_iter().enumerate() {
            assert!(read(damage).is_err(), "{k}");
        }
    }
}
