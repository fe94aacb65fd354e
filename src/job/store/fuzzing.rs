//! Records of the store for the fuzz targets, which read and write arbitrary bytes.

use uuid::Uuid;

use super::embedded::tables::{self, Header};
use super::record::{self, Input};
use super::{IdempotencyEntry, Record, StoreError};
use crate::job::result::LastGeometry;
use piad_fit::engine::Problem;

/// A problem as it is kept.
pub(crate) fn kept(problem: &Problem) -> Vec<u8> {
    let input = Input::new(problem);
    input.and_then(|it| it.to_bytes()).unwrap_or_default()
}

/// The problem that is kept in these bytes.
pub(crate) fn problem(bytes: &[u8]) -> Result<Problem, StoreError> {
    record::problem(Uuid::nil(), bytes)
}

/// A job without its points as it is kept.
pub(crate) fn kept_record(record: &Record) -> Vec<u8> {
    let header = Header {
        record: record.clone(),
        bytes: 0,
        key: None,
    };
    record::write(&header).unwrap_or_default()
}

/// The job that is kept in these bytes.
pub(crate) fn record(bytes: &[u8]) -> Result<Record, StoreError> {
    Ok(tables::header(Uuid::nil(), bytes)?.record)
}

/// The last level of a job as it is kept.
pub(crate) fn kept_result(result: &LastGeometry) -> Vec<u8> {
    record::geometry(result).unwrap_or_default()
}

/// The last level that is kept in these bytes.
pub(crate) fn result(bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    record::result(Uuid::nil(), bytes)
}

/// The entry of an idempotency key as it is kept.
pub(crate) fn kept_entry(entry: &IdempotencyEntry) -> Vec<u8> {
    record::write(entry).unwrap_or_default()
}

/// The entry that is kept in these bytes.
pub(crate) fn entry(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    record::entry(bytes)
}
