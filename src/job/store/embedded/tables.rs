//! The tables of the file.

use redb::{AccessGuard, StorageError, TableDefinition};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::envelope::{self, Kind};
use crate::job::quota::Amount;
use crate::job::store::{IdempotencyEntry, Record, StoreError, record};

/// The version of what is described here. Files of other versions are refused.
pub(super) const VERSION: u64 = 3;

/// Facts about the file itself.
pub(super) const FACTS: TableDefinition<&str, u64> = TableDefinition::new("facts");
pub(super) const VERSION_FACT: &str = "version";
/// The number of the last commit: it tells if one that has failed was done nonetheless.
pub(super) const COMMIT_FACT: &str = "commit";

/// Values by the id of their job, each in its envelope.
pub(super) struct Values {
    pub(super) table: TableDefinition<'static, u128, &'static [u8]>,
    pub(super) kind: Kind,
    /// What one is called in errors.
    pub(super) name: &'static str,
}

/// Jobs without their points: lists read only these.
pub(super) const HEADERS: Values = Values {
    table: TableDefinition::new("headers"),
    kind: Kind::Header,
    name: "header",
};
/// Problems as they were asked for.
pub(super) const INPUTS: Values = Values {
    table: TableDefinition::new("inputs"),
    kind: Kind::Input,
    name: "problem",
};
/// The free control points of the last level.
pub(super) const RESULTS: Values = Values {
    table: TableDefinition::new("results"),
    kind: Kind::Result,
    name: "result",
};
/// Which job was made for a key.
pub(super) const KEYS: TableDefinition<&str, &[u8]> = TableDefinition::new("keys");
/// Secrets of the server. Files of before have no such table, and files that are repaired lose it: then a server makes
/// new ones.
pub(super) const SECRETS: TableDefinition<&str, &[u8]> = TableDefinition::new("secrets");
pub(super) const TICKETS: &str = "tickets";
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

impl Header {
    /// What the job takes of the quota of its tenant.
    pub(super) fn amount(&self) -> Amount {
        let of_job = Amount {
            bytes: self.bytes,
            ..Amount::default()
        };
        match self.record.status.state.is_final() {
            true => of_job,
            false => of_job + self.record.outline.amount(),
        }
    }
}

/// The header of this job.
pub(in crate::job::store) fn header(id: Uuid, bytes: &[u8]) -> Result<Header, StoreError> {
    let what = format!("the header of job {id}");
    let header: Header = record::read(&what, bytes)?;
    record::check(&header.record.outline, what)?;
    Ok(header)
}

impl Values {
    /// The value of a job in its envelope.
    pub(super) fn opened<'a>(&self, id: Uuid, bytes: &'a [u8]) -> Result<&'a [u8], StoreError> {
        envelope::opened(
            self.kind,
            id,
            format_args!("the {} of job {id}", self.name),
            bytes,
        )
    }
}

/// The header of this job in its envelope.
pub(super) fn header_in(id: Uuid, bytes: &[u8]) -> Result<Header, StoreError> {
    header(id, HEADERS.opened(id, bytes)?)
}

/// The entry of an idempotency key in its envelope.
pub(super) fn key_in(bytes: &[u8]) -> Result<IdempotencyEntry, StoreError> {
    let announced = bytes.first_chunk().and_then(envelope::announced);
    let id = announced.map(|(_, id, _)| id).unwrap_or_default();
    let what = "the entry of an idempotency key";
    record::entry(envelope::opened(Kind::Key, id, what, bytes)?)
}

/// The record of an entry of the table of headers.
pub(super) fn of_entry(
    entry: Result<(AccessGuard<'_, u128>, AccessGuard<'_, &'static [u8]>), StorageError>,
) -> Result<Record, StoreError> {
    let (id, bytes) = entry?;
    Ok(header_in(Uuid::from_u128(id.value()), bytes.value())?.record)
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
