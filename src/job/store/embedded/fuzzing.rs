//! Records of the store, as the fuzz targets read and write them: from bytes that may be anything.

use prost::Message;

use super::super::{IdempotencyEntry, IdempotencyKey, Record, StoreError};
use super::error::damaged;
use super::header::Header;
use super::idempotency::EntryMessage;
use super::input::Input;
use super::result;
use crate::fit::problem::Problem;
use crate::job::result::LastGeometry;

/// A problem as it is kept.
pub(crate) fn kept(problem: &Problem) -> Vec<u8> {
    Input::new(problem).encode_to_vec()
}

/// The problem that is kept in these bytes.
pub(crate) fn problem(bytes: &[u8]) -> Result<Problem, StoreError> {
    Problem::new(Input::read(bytes)?).map_err(damaged)
}

/// A job without its points as it is kept.
pub(crate) fn kept_record(record: &Record) -> Vec<u8> {
    Header::new(record, 0, None).encode_to_vec()
}

/// The job that is kept in these bytes.
pub(crate) fn record(bytes: &[u8]) -> Result<Record, StoreError> {
    Header::read(bytes)?.into_record()
}

/// The last level of a job as it is kept.
pub(crate) fn kept_result(result: &LastGeometry) -> Vec<u8> {
    result::kept(result)
}

/// The last level that is kept in these bytes.
pub(crate) fn result(bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    result::read(bytes)
}

/// The entry of an idempotency key as it is kept.
pub(crate) fn kept_entry(entry: &IdempotencyEntry) -> Vec<u8> {
    let key = IdempotencyKey {
        name: String::new(),
        digest: entry.digest,
    };
    EntryMessage::new(&key, entry.id, entry.created).encode_to_vec()
}

/// The entry that is kept in these bytes.
pub(crate) fn entry(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    EntryMessage::read(bytes)
}
