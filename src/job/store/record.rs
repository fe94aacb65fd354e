//! The tables of the file, and what stands in them: records in MessagePack, with the names of their fields,
//! and problems as messages of the contract.
//!
//! In JSON the errors of a fit could not be infinite. Arrays of numbers are kept as their bytes.

use std::fmt::Display;
use std::sync::Arc;

use prost::Message;
use redb::{AccessGuard, StorageError, TableDefinition};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::error::damaged;
use super::{IdempotencyEntry, Record, StoreError};
use crate::fit::aligned::Lane;
use crate::fit::bases::Bases;
use crate::fit::points::Points;
use crate::fit::problem::{Problem, Request};
use crate::job::result::LastGeometry;
use crate::model::job::JobRequest;
use crate::proto::job;
use crate::proto::messages as pb;

/// The version of what is described here. Files of other versions are refused.
pub(super) const VERSION: u64 = 1;

/// Facts about the file itself.
pub(super) const FACTS: TableDefinition<&str, u64> = TableDefinition::new("facts");
pub(super) const VERSION_FACT: &str = "version";

/// Jobs without their points, by id: lists read only these.
pub(super) const HEADERS: TableDefinition<u128, &[u8]> = TableDefinition::new("headers");
/// Problems as they were asked for, by the id of the job.
pub(super) const INPUTS: TableDefinition<u128, &[u8]> = TableDefinition::new("inputs");
/// The free control points of the last level, by the id of the job.
pub(super) const RESULTS: TableDefinition<u128, &[u8]> = TableDefinition::new("results");
/// Which job was made for a key.
pub(super) const KEYS: TableDefinition<&str, &[u8]> = TableDefinition::new("keys");
/// Nothing: pages are taken and given back here, so that there are some.
pub(super) const SLACK: TableDefinition<u64, &[u8]> = TableDefinition::new("slack");

/// A job without its points.
#[derive(Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) record: Record,
    /// Bytes of the problem and of the result.
    pub(super) bytes: u64,
    /// The name of the idempotency key of the request that made the job.
    pub(super) key: Option<String>,
}

/// What a problem has besides what a client can ask for.
#[derive(Serialize, Deserialize)]
struct Start {
    /// The control points with which an edit starts.
    control_points: Option<Arc<Points>>,
    /// The breaks of their knots, of a fit that chooses its knots.
    breaks: Vec<Lane>,
    lambda_min: Option<f64>,
}

/// The last level of a job.
#[derive(Serialize, Deserialize)]
struct Geometry {
    control_points: Arc<Points>,
    /// The breaks of the knots that a fit has chosen, for each direction.
    breaks: Vec<Lane>,
    parameters: Option<Lane>,
}

/// The bytes of a record.
pub(super) fn write<T: Serialize>(record: &T) -> Result<Vec<u8>, StoreError> {
    let bytes = rmp_serde::to_vec_named(record);
    bytes.map_err(|error| StoreError::Failed(error.to_string()))
}

/// The record of these bytes, or an error that says which one cannot be read.
fn read<'a, T: Deserialize<'a>>(what: impl Display, bytes: &'a [u8]) -> Result<T, StoreError> {
    rmp_serde::from_slice(bytes).map_err(|error| damaged(what, error))
}

/// The header of this job.
pub(super) fn header(id: Uuid, bytes: &[u8]) -> Result<Header, StoreError> {
    let what = format!("the header of job {id}");
    let header: Header = read(&what, bytes)?;
    let grid = header.record.outline.grid;
    match grid.rows.checked_mul(grid.columns) {
        Some(1..) => Ok(header),
        _ => Err(damaged(what, "there are no points, or more than can be")),
    }
}

/// The record of an entry of the table of headers.
pub(super) fn of_entry(
    entry: Result<(AccessGuard<'_, u128>, AccessGuard<'_, &'static [u8]>), StorageError>,
) -> Result<Record, StoreError> {
    let (id, bytes) = entry?;
    Ok(header(Uuid::from_u128(id.value()), bytes.value())?.record)
}

/// The entry of an idempotency key.
pub(super) fn entry(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    read("the entry of an idempotency key", bytes)
}

/// The bytes of a problem: the length of its start, the start, and the message that would ask for the rest.
pub(super) fn input(problem: &Problem) -> Result<Vec<u8>, StoreError> {
    let request = problem.request();
    let start = write(&Start {
        control_points: request.start.clone(),
        breaks: lanes(request.start_breaks.as_deref().unwrap_or_default()),
        lambda_min: request.lambda_min,
    })?;
    let message = job::message(None, request, None);
    let mut bytes = Vec::with_capacity(8 + start.len() + message.encoded_len());
    bytes.extend((start.len() as u64).to_le_bytes());
    bytes.extend(start);
    let encoded = message.encode(&mut bytes);
    encoded.map_err(|error| StoreError::Failed(error.to_string()))?;
    Ok(bytes)
}

/// The problem of this job: what follows from what was asked for is computed again.
pub(super) fn problem(id: Uuid, bytes: &[u8]) -> Result<Problem, StoreError> {
    let what = format!("the problem of job {id}");
    let (start, message) = parts(bytes).ok_or_else(|| damaged(&what, "its end is missing"))?;
    let start: Start = read(&what, start)?;
    let message = pb::JobInput::decode(message).map_err(|error| damaged(&what, error))?;
    let request = job::request(message, usize::MAX).and_then(JobRequest::request);
    let request = Request {
        start: start.control_points,
        start_breaks: lists(start.breaks),
        lambda_min: start.lambda_min,
        ..request.map_err(|mistakes| damaged(&what, mistakes))?
    };
    Problem::new(request).map_err(|error| damaged(what, error))
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
        parameters: bases.and_then(|it| Some(Lane::from(it.parameters.as_ref()?.as_slice()))),
    })
}

/// The last level of this job.
pub(super) fn result(id: Uuid, bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    let Geometry {
        control_points,
        breaks,
        parameters,
    } = read(format!("the result of job {id}"), bytes)?;
    let parameters = parameters.map(|it| Arc::new(it.to_vec()));
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

/// The method of an outline as a message of the contract, without the lists of its settings.
pub(in crate::job) mod method {
    use prost::Message;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use crate::fit::method::Method;
    use crate::proto::{messages as pb, method};

    pub(in crate::job) fn serialize<S: Serializer>(it: &Method, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_bytes(&method::message(it, true, None).encode_to_vec())
    }

    pub(in crate::job) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Method, D::Error> {
        let message = pb::Method::decode(<&[u8]>::deserialize(d)?).map_err(D::Error::custom)?;
        // As for a surface, which has all that a curve has.
        method::outline(Some(message), true).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples;
    use crate::proto::messages::job_input::Geometry as Shape;

    fn queued() -> (Uuid, Vec<u8>) {
        let record = samples::queued();
        let (bytes, key) = (7, Some("key".to_owned()));
        let id = record.outline.id;
        (id, write(&Header { record, bytes, key }).unwrap())
    }

    #[test]
    fn a_record_that_cannot_be_read_is_named() {
        let (id, bytes) = queued();
        assert!(header(id, &bytes).is_ok());
        let shorter = (0..bytes.len()).map(|length| bytes[..length].to_vec());
        let place = bytes.windows(6).position(|it| it == b"Queued").unwrap();
        let mut unknown = bytes.clone();
        unknown[place..][..6].copy_from_slice(b"Behind");
        for damaged in shorter.chain([unknown]) {
            let error = header(id, &damaged).map(|it| it.record).unwrap_err();
            let text = error.to_string();
            assert!(text.contains(&format!("job {id} cannot be read")), "{text}");
        }
    }

    #[test]
    fn flipped_bits_are_damage_or_another_record() {
        let (id, bytes) = queued();
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            if let Ok(header) = header(id, &flipped) {
                assert!(header.record.outline.grid.count() > 0);
            }
        }
    }

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
        let kept = input(&samples::problem()).unwrap();
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
