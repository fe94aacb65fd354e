//! The tables of the file.

use redb::{AccessGuard, StorageError, TableDefinition};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::job::store::{Record, StoreError, record};

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
pub(in crate::job::store) struct Header {
    pub(in crate::job::store) record: Record,
    /// Bytes of the problem and of the result.
    pub(in crate::job::store) bytes: u64,
    /// The name of the idempotency key of the request that made the job.
    pub(in crate::job::store) key: Option<String>,
}

/// The header of this job.
pub(in crate::job::store) fn header(id: Uuid, bytes: &[u8]) -> Result<Header, StoreError> {
    let what = format!("the header of job {id}");
    let header: Header = record::read(&what, bytes)?;
    record::check(&header.record.outline, what)?;
    Ok(header)
}

/// The record of an entry of the table of headers.
pub(super) fn of_entry(
    entry: Result<(AccessGuard<'_, u128>, AccessGuard<'_, &'static [u8]>), StorageError>,
) -> Result<Record, StoreError> {
    let (id, bytes) = entry?;
    Ok(header(Uuid::from_u128(id.value()), bytes.value())?.record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples;

    fn queued() -> (Uuid, Vec<u8>) {
        let record = samples::queued();
        let (bytes, key) = (7, Some("key".to_owned()));
        let id = record.outline.id;
        (id, record::write(&Header { record, bytes, key }).unwrap())
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
}
