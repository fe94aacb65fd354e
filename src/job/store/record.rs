//! Stored records of a job: MessagePack, with the names of their fields; problems are messages of the contract.
//!
//! In JSON the errors of a fit could not be infinite. Arrays of numbers are stored as bytes.

use std::fmt::Display;
use std::sync::Arc;

use bytes::BufMut;
use prost::Message;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{IdempotencyEntry, StoreError};
use crate::job::outline::Outline;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use crate::model::job::JobRequest;
use crate::proto::job;
use crate::proto::messages as pb;
use piad_fit::data::Points;
use piad_fit::engine::{Bases, Lane, Problem, Request, trimmed};

/// The parts of a problem that are not in a request.
#[derive(Serialize, Deserialize)]
struct Start {
    /// The control points with which an edit starts.
    control_points: Option<Arc<Points>>,
    /// The breaks of their knots, of a fit that chooses its knots.
    breaks: Vec<Lane>,
    lambda_min: Option<f64>,
    /// The points that an edit of a robust fit leaves out.
    #[serde(default)]
    outliers: Option<Arc<[usize]>>,
}

/// The last level of a job.
#[derive(Serialize, Deserialize)]
struct Geometry {
    control_points: Arc<Points>,
    /// The breaks of the knots that a fit has chosen, for each direction.
    breaks: Vec<Lane>,
    parameters: Vec<Lane>,
}

/// The bytes of a record.
pub(super) fn write<T: Serialize>(record: &T) -> Result<Vec<u8>, StoreError> {
    let bytes = rmp_serde::to_vec_named(record);
    bytes.map_err(|error| StoreError::Failed(error.to_string()))
}

/// The record of these bytes, or an error that names it.
pub(super) fn read<'a, T: Deserialize<'a>>(
    what: impl Display,
    bytes: &'a [u8],
) -> Result<T, StoreError> {
    rmp_serde::from_slice(bytes).map_err(|error| StoreError::damaged(what, error))
}

/// The outline of this job.
pub(super) fn outline(id: Uuid, bytes: &[u8]) -> Result<Outline, StoreError> {
    let what = format!("the outline of job {id}");
    let outline: Outline = read(&what, bytes)?;
    check(&outline, what)?;
    Ok(outline)
}

/// Checks that an outline is that of a job.
pub(super) fn check(outline: &Outline, what: impl Display) -> Result<(), StoreError> {
    match outline.grid.rows.checked_mul(outline.grid.columns) {
        Some(1..) => Ok(()),
        _ => Err(StoreError::damaged(
            what,
            "there are no points, or more than can be",
        )),
    }
}

/// The status of this job.
pub(super) fn status(id: Uuid, bytes: &[u8]) -> Result<Status, StoreError> {
    read(format!("the status of job {id}"), bytes)
}

/// The entry of an idempotency key.
pub(super) fn entry(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    read("the entry of an idempotency key", bytes)
}

/// A stored problem: the length of its start, the start, and the message that would request the rest.
pub(super) struct Input {
    start: Vec<u8>,
    message: pb::JobInput,
}

impl Input {
    /// The stored form of a problem.
    pub(super) fn new(problem: &Problem) -> Result<Self, StoreError> {
        let request = problem.request();
        let start = write(&Start {
            control_points: request.start.clone(),
            breaks: lanes(request.start_breaks.as_deref().unwrap_or_default()),
            lambda_min: request.lambda_min,
            outliers: request.outliers.clone(),
        })?;
        let message = job::message(None, request, None);
        Ok(Self { start, message })
    }

    /// The number of bytes.
    pub(super) fn len(&self) -> usize {
        size_of::<u64>() + self.start.len() + self.message.encoded_len()
    }

    /// Writes them, where there is room for all.
    pub(super) fn write(&self, place: &mut impl BufMut) -> Result<(), StoreError> {
        place.put_u64_le(self.start.len() as u64);
        place.put_slice(&self.start);
        let encoded = self.message.encode(place);
        encoded.map_err(|error| StoreError::Failed(error.to_string()))
    }

    /// All of them.
    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let mut bytes = Vec::with_capacity(self.len());
        self.write(&mut bytes)?;
        Ok(bytes)
    }
}

/// The problem of this job: what follows from the request is computed again.
pub(super) fn problem(id: Uuid, bytes: &[u8]) -> Result<Problem, StoreError> {
    let what = format!("the problem of job {id}");
    let (start, message) =
        parts(bytes).ok_or_else(|| StoreError::damaged(&what, "its end is missing"))?;
    let start: Start = read(&what, start)?;
    let message =
        pb::JobInput::decode(message).map_err(|error| StoreError::damaged(&what, error))?;
    let request = job::request(message, usize::MAX).and_then(JobRequest::request);
    let request = Request {
        start: start.control_points,
        start_breaks: lists(start.breaks),
        lambda_min: start.lambda_min,
        outliers: start.outliers,
        ..request.map_err(|errors| StoreError::damaged(&what, errors))?
    };
    let problem = Problem::new(request).and_then(trimmed);
    problem.map_err(|error| StoreError::damaged(what, error))
}

/// The start of a problem, and its message.
fn parts(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u64::from_le_bytes(*length) as usize)
}

/// The bytes of the last level of a job.
pub(super) fn geometry(result: &LastGeometry) -> Result<Vec<u8>, StoreError> {
    let bases = result.bases.as_deref();
    write(&Geometry {
        control_points: Arc::clone(&result.control_points),
        breaks: lanes(bases.map_or(&[], |it| &it.breaks)),
        parameters: lanes(bases.map_or(&[], |it| &it.parameters)),
    })
}

/// The last level of this job.
pub(super) fn result(id: Uuid, bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    let Geometry {
        control_points,
        breaks,
        parameters,
    } = read(format!("the result of job {id}"), bytes)?;
    let parameters = lists(parameters).unwrap_or_default();
    let bases = lists(breaks).map(|breaks| Bases { breaks, parameters });
    Ok(LastGeometry {
        control_points,
        bases: bases.map(Arc::new),
    })
}

fn lanes(lists: &[Arc<Vec<f64>>]) -> Vec<Lane> {
    lists.iter().map(|it| Lane::from(it.as_slice())).collect()
}

/// The lists of these numbers, if there are some.
fn lists(lanes: Vec<Lane>) -> Option<Vec<Arc<Vec<f64>>>> {
    let lists = lanes.iter().map(|it| Arc::new(it.to_vec())).collect();
    (!lanes.is_empty()).then_some(lists)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples;
    use crate::proto::messages::job_input::Geometry as Shape;

    #[test]
    fn points_have_coordinates_all_of_them_as_many() {
        let id = Uuid::nil();
        let read = |lanes: &[&[f64]]| {
            let geometry = LastGeometry::from(Arc::new(Points::from_lanes(lanes.iter().copied())));
            result(id, &super::geometry(&geometry).unwrap()).map(|it| it.control_points.len())
        };
        assert_eq!(read(&[&[1.0, 2.0], &[3.0, 4.0]]).unwrap(), 2);
        assert!(read(&[]).is_err() && read(&[&[], &[]]).is_err());
        assert!(read(&[&[1.0, 2.0], &[3.0]]).is_err());
    }

    #[test]
    fn what_does_not_fit_together_is_damage() {
        let kept = Input::new(&samples::problem()).unwrap();
        let kept = kept.to_bytes().unwrap();
        let (_, message) = parts(&kept).unwrap();
        let start = &kept[..kept.len() - message.len()];
        let message = pb::JobInput::decode(message).unwrap();
        let surface = |rows, columns, missing: &[u32]| {
            let (dimension, points, missing) = (1, vec![0.5; 20], missing.to_vec());
            Some(Shape::Surface(pb::Surface {
                dimension,
                rows,
                columns,
                points,
                missing,
                ..pb::Surface::default()
            }))
        };
        let read = |geometry| {
            let input = pb::JobInput {
                geometry,
                ..message.clone()
            };
            problem(Uuid::nil(), &[start, &input.encode_to_vec()].concat())
        };
        assert!(read(message.geometry.clone()).is_ok());
        let damages = [
            surface(11, 2, &[]),
            surface(u32::MAX, u32::MAX, &[]),
            surface(10, 2, &[20]),
            Some(Shape::Curve(pb::Curve::default())),
            None,
        ];
        for (k, damage) in damages.into_iter().enumerate() {
            assert!(read(damage).is_err(), "{k}");
        }
    }
}
