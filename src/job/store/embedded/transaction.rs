//! A write transaction: the effects of each change on the tables.

use jiff::Timestamp;
use redb::{Key, ReadableTable, Table, WriteTransaction};
use uuid::Uuid;

use super::ended::Ended;
use super::envelope::{self, Kind, envelope};
use super::tables::{self, COMMIT_FACT, FACTS, HEADERS, Header, INPUTS, KEYS, RESULTS, SLACK};
use super::usage::Usage;
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use crate::job::store::record::{self, Input};
use crate::job::store::{
    IdempotencyEntry, IdempotencyKey, Insertion, Record, Retention, Spared, StoreError,
};
use piad_fit::engine::Problem;

/// The number of pages of the file that stay free for changes that add nothing: a deletion takes a few dozen before it
/// frees some, which can be used two commits later. Without them no job could be deleted to make space where the file
/// cannot grow (`durable::jobs_can_be_deleted`).
const SLACK_PAGES: u64 = 128;

/// A write transaction with its tables.
pub(super) struct Transaction<'a> {
    pub(super) headers: Table<'a, u128, &'static [u8]>,
    inputs: Table<'a, u128, &'static [u8]>,
    results: Table<'a, u128, &'static [u8]>,
    keys: Table<'a, &'static str, &'static [u8]>,
    slack: Table<'a, u64, &'static [u8]>,
    facts: Table<'a, &'static str, u64>,
    /// The jobs that had ended before the transaction.
    ended: &'a Ended,
    /// When it began, by the monotonic clock.
    now: Timestamp,
    /// The usage of tenants, with the changes of the transaction.
    pub(super) usage: Usage,
    /// To be applied to [`Ended`] once the transaction is committed.
    pub(super) changes: Vec<EndedChange>,
}

/// A change of [`Ended`].
pub(super) enum EndedChange {
    Add { at: Timestamp, id: Uuid, bytes: u64 },
    Remove { at: Timestamp, id: Uuid },
}

impl<'a> Transaction<'a> {
    pub(super) fn open(
        transaction: &'a WriteTransaction,
        ended: &'a Ended,
        usage: Usage,
        now: Timestamp,
    ) -> Result<Self, StoreError> {
        Ok(Self {
            headers: transaction.open_table(HEADERS.table)?,
            inputs: transaction.open_table(INPUTS.table)?,
            results: transaction.open_table(RESULTS.table)?,
            keys: transaction.open_table(KEYS)?,
            slack: transaction.open_table(SLACK)?,
            facts: transaction.open_table(FACTS)?,
            ended,
            now,
            usage,
            changes: Vec::new(),
        })
    }

    /// Lets the file grow now if it is nearly full: writes and removes a few pages, which later changes find free.
    pub(super) fn leave_slack(&mut self) -> Result<(), StoreError> {
        const PAGE: [u8; 3800] = [0; 3800];
        for page in 0..SLACK_PAGES {
            self.slack.insert(page, PAGE.as_slice())?;
        }
        for page in 0..SLACK_PAGES {
            self.slack.remove(page)?;
        }
        Ok(())
    }

    /// Writes the number of the commit, by which it is found again.
    pub(super) fn number(&mut self, number: u64) -> Result<(), StoreError> {
        self.facts.insert(COMMIT_FACT, number)?;
        Ok(())
    }

    /// Writes a new job, unless there is an entry for the same key, or it is beyond the quota of its tenant.
    pub(super) fn insert(
        &mut self,
        record: &Record,
        problem: &Problem,
        key: Option<&IdempotencyKey>,
        quota: &Quota,
    ) -> Result<Insertion, StoreError> {
        let (id, tenant) = (record.outline.id, record.outline.tenant);
        if let Some(key) = key
            && let Some(entry) = self.entry(&key.name)?
            && !entry.has_expired(self.now)
        {
            return Ok(Insertion::Known(entry));
        }
        let input = Input::new(problem)?;
        let header = Header {
            record: record.clone(),
            bytes: input.len() as u64,
            key: key.map(|key| key.name.clone()),
        };
        if let Err(exceeded) = quota.admit(tenant, self.usage.of(tenant), header.amount()) {
            return Ok(Insertion::Refused(exceeded));
        }
        if let Some(key) = key {
            let entry = record::write(&IdempotencyEntry {
                id,
                digest: key.digest,
                created: record.outline.created,
            })?;
            keep(&mut self.keys, key.name.as_str(), (Kind::Key, id), &entry)?;
        }
        let write = |mut place: &mut [u8]| input.write(&mut place);
        let kind = (Kind::Input, id);
        keep_written(&mut self.inputs, id.as_u128(), kind, input.len(), write)?;
        self.usage.add(&header);
        self.put(id, &header)?;
        Ok(Insertion::New)
    }

    /// Changes the record of a job. A job that is gone stays gone.
    pub(super) fn update(
        &mut self,
        id: Uuid,
        change: impl FnOnce(&mut Record),
    ) -> Result<(), StoreError> {
        match self.header(id)? {
            Some(mut header) => {
                change(&mut header.record);
                self.put(id, &header)
            }
            None => Ok(()),
        }
    }

    /// Writes the end of a job.
    pub(super) fn finish(
        &mut self,
        id: Uuid,
        status: &Status,
        result: Option<&LastGeometry>,
    ) -> Result<(), StoreError> {
        let Some(mut header) = self.header(id)? else {
            return Ok(());
        };
        self.usage.remove(&header);
        header.record.status = status.clone();
        if let Some(result) = result {
            let bytes = record::geometry(result)?;
            header.bytes += bytes.len() as u64;
            keep(&mut self.results, id.as_u128(), (Kind::Result, id), &bytes)?;
        }
        self.usage.add(&header);
        self.put(id, &header)
    }

    /// Removes a job; returns true if there was one.
    pub(super) fn remove(&mut self, id: Uuid) -> Result<bool, StoreError> {
        let Some(header) = self.header(id)? else {
            return Ok(false);
        };
        self.usage.remove(&header);
        self.headers.remove(id.as_u128())?;
        self.inputs.remove(id.as_u128())?;
        self.results.remove(id.as_u128())?;
        // A key that had expired may belong to another job now.
        if let Some(key) = &header.key
            && self.entry(key)?.is_some_and(|entry| entry.id == id)
        {
            self.keys.remove(key.as_str())?;
        }
        if let Some(at) = header.record.status.finished {
            self.changes.push(EndedChange::Remove { at, id });
        }
        Ok(true)
    }

    /// Removes keys that have expired, and jobs that are beyond the retention; returns the ids of these.
    pub(super) fn retain(
        &mut self,
        retention: Retention,
        spared: &Spared,
    ) -> Result<Vec<Uuid>, StoreError> {
        self.forget_keys()?;
        let surplus = self.ended.surplus(retention, spared, self.now);
        for &id in &surplus {
            self.remove(id)?;
        }
        Ok(surplus)
    }

    fn forget_keys(&mut self) -> Result<(), StoreError> {
        let mut expired = Vec::new();
        for item in self.keys.iter()? {
            let (key, bytes) = item?;
            if tables::key_in(bytes.value())?.has_expired(self.now) {
                expired.push(key.value().to_owned());
            }
        }
        for key in expired {
            self.keys.remove(key.as_str())?;
        }
        Ok(())
    }

    /// The entry of a key, which may have expired.
    fn entry(&self, key: &str) -> Result<Option<IdempotencyEntry>, StoreError> {
        let bytes = self.keys.get(key)?;
        bytes.map(|bytes| tables::key_in(bytes.value())).transpose()
    }

    /// Writes a header.
    pub(super) fn put(&mut self, id: Uuid, header: &Header) -> Result<(), StoreError> {
        let bytes = record::write(header)?;
        keep(&mut self.headers, id.as_u128(), (Kind::Header, id), &bytes)?;
        if let Some(at) = header.record.status.finished {
            let bytes = header.bytes;
            self.changes.push(EndedChange::Add { at, id, bytes });
        }
        Ok(())
    }

    fn header(&self, id: Uuid) -> Result<Option<Header>, StoreError> {
        let bytes = self.headers.get(id.as_u128())?;
        let header = bytes.map(|bytes| tables::header_in(id, bytes.value()));
        header.transpose()
    }
}

/// Writes a value in its envelope.
fn keep<'k, K: Key + 'static>(
    table: &mut Table<'_, K, &'static [u8]>,
    key: K::SelfType<'k>,
    (kind, id): (Kind, Uuid),
    value: &[u8],
) -> Result<(), StoreError> {
    let copy = |place: &mut [u8]| {
        place.copy_from_slice(value);
        Ok(())
    };
    keep_written(table, key, (kind, id), value.len(), copy)
}

/// Has a value of some length written in its envelope.
fn keep_written<'k, K: Key + 'static>(
    table: &mut Table<'_, K, &'static [u8]>,
    key: K::SelfType<'k>,
    (kind, id): (Kind, Uuid),
    length: usize,
    write: impl FnOnce(&mut [u8]) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let mut place = table.insert_reserve(key, envelope::BYTES + length)?;
    let (outside, inside) = place.as_mut().split_at_mut(envelope::BYTES);
    write(inside)?;
    outside.copy_from_slice(&envelope(kind, id, inside));
    Ok(())
}
