//! Records of the store for the fuzz targets, which read and write arbitrary bytes.

use uuid::Uuid;

use super::embedded::tables::{self, Header};
use super::record::{self, Input};
use super::{IdempotencyEntry, Record, StoreError};
use crate::job::result::LastGeometry;
use piad_fit::engine::Problem;

/// The stored form of a problem.
pub(crate) fn kept(problem: &Problem) -> Vec<u8> {
    let input = Input::new(problem);
    input.and_then(|it| it.to_bytes()).unwrap_or_default()
}

/// The problem stored in these bytes.
pub(crate) fn problem(bytes: &[u8]) -> Result<Problem, StoreError> {
    record::problem(Uuid::nil(), bytes)
}

/// The stored form of a job without its points.
pub(crate) fn kept_record(record: &Record) -> Vec<u8> {
    let header = Header {
        record: record.clone(),
        bytes: 0,
        key: None,
    };
    record::write(&header).unwrap_or_default()
}

/// The job stored in these bytes.
pub(crate) fn record(bytes: &[u8]) -> Result<Record, StoreError> {
    Ok(tables::header(Uuid::nil(), bytes)?.record)
}

/// The stored form of the last level of a job.
pub(crate) fn kept_result(result: &LastGeometry) -> Vec<u8> {
    record::geometry(result).unwrap_or_default()
}

/// The last level stored in these bytes.
pub(crate) fn result(bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    record::result(Uuid::nil(), bytes)
}

/// The stored form of the entry of an idempotency key.
pub(crate) fn kept_entry(entry: &IdempotencyEntry) -> Vec<u8> {
    record::write(entry).unwrap_or_default()
}

/// The entry stored in these bytes.
pub(crate) fn entry(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    record::entry(bytes)
}
