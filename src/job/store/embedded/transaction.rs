//! A write transaction: what each change does to the tables.

use jiff::Timestamp;
use prost::Message;
use redb::{ReadableTable, Table, WriteTransaction};
use uuid::Uuid;

use super::super::ended::Ended;
use super::super::{IdempotencyEntry, IdempotencyKey, Record, StoreError};
use super::change::{Change, Outcome};
use super::header::Header;
use super::idempotency::EntryMessage;
use super::input::Input;
use super::result;
use super::tables::{HEADERS, INPUTS, KEYS, RESULTS, SLACK};
use crate::fit::problem::Problem;
use crate::job::result::LastGeometry;
use crate::job::state::Status;

/// So many pages of the file stay free for changes that add nothing: a deletion takes a few dozen before it
/// frees some, which can be used two commits later. Without them no job could be deleted to make room where
/// the file cannot grow (`durable::jobs_can_be_deleted`).
const SLACK_PAGES: u64 = 128;

/// A write transaction with its tables.
pub(super) struct Transaction<'a> {
    pub(super) headers: Table<'a, u128, &'static [u8]>,
    inputs: Table<'a, u128, &'static [u8]>,
    results: Table<'a, u128, &'static [u8]>,
    keys: Table<'a, &'static str, &'static [u8]>,
    slack: Table<'a, u64, &'static [u8]>,
    /// To be done to [`Ended`] once the transaction is committed.
    pub(super) ended: Vec<EndedChange>,
}

/// A change of [`Ended`].
pub(super) enum EndedChange {
    Add { at: Timestamp, id: Uuid, bytes: u64 },
    Remove { at: Timestamp, id: Uuid },
}

impl<'a> Transaction<'a> {
    pub(super) fn open(transaction: &'a WriteTransaction) -> Result<Self, StoreError> {
        Ok(Self {
            headers: transaction.open_table(HEADERS)?,
            inputs: transaction.open_table(INPUTS)?,
            results: transaction.open_table(RESULTS)?,
            keys: transaction.open_table(KEYS)?,
            slack: transaction.open_table(SLACK)?,
            ended: Vec::new(),
        })
    }

    /// Does a change. `ended` are the jobs that had ended before the transaction.
    pub(super) fn apply(&mut self, change: &Change, ended: &Ended) -> Result<Outcome, StoreError> {
        Ok(match change {
            Change::Insert {
                record,
                problem,
                key,
            } => {
                let existing = self.insert(record, problem, key.as_ref())?;
                existing.map_or(Outcome::Done, Outcome::Existing)
            }
            Change::Start {
                id,
                status,
                on_probation,
            } => self.update(*id, |header| {
                header.set_status(status);
                header.on_probation = *on_probation;
            })?,
            Change::Requeue { id } => self.update(*id, |header| {
                header.set_status(&Status::QUEUED);
                (header.crashes, header.on_probation) = (0, false);
            })?,
            Change::Finish { id, status, result } => {
                self.finish(*id, status, result.as_ref())?;
                Outcome::Done
            }
            Change::Remove { id } => Outcome::Removed(self.remove(*id)?),
            Change::Retain { retention, spared } => {
                Outcome::Forgotten(self.retain(ended.surplus(*retention, spared))?)
            }
            Change::Nothing => Outcome::Done,
        })
    }

    /// Has the file grow now if it is nearly full: writes and removes a few pages, which later changes
    /// find free.
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

    fn insert(
        &mut self,
        record: &Record,
        problem: &Problem,
        key: Option<&IdempotencyKey>,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        let id = record.outline.id;
        if let Some(key) = key {
            if let Some(entry) = self.entry(&key.name)?
                && !entry.has_expired()
            {
                return Ok(Some(entry));
            }
            let entry = EntryMessage::new(key, id, record.outline.created).encode_to_vec();
            self.keys.insert(key.name.as_str(), entry.as_slice())?;
        }
        let input = Input::new(problem).encode_to_vec();
        let header = Header::new(record, input.len() as u64, key.map(|key| key.name.clone()));
        self.inputs.insert(id.as_u128(), input.as_slice())?;
        self.put(id, &header)?;
        Ok(None)
    }

    /// The entry of a key, which may have expired.
    fn entry(&self, key: &str) -> Result<Option<IdempotencyEntry>, StoreError> {
        let bytes = self.keys.get(key)?;
        bytes
            .map(|bytes| EntryMessage::read(bytes.value()))
            .transpose()
    }

    /// Writes a header.
    pub(super) fn put(&mut self, id: Uuid, header: &Header) -> Result<(), StoreError> {
        let bytes = header.encode_to_vec();
        self.headers.insert(id.as_u128(), bytes.as_slice())?;
        Ok(())
    }

    fn header(&self, id: Uuid) -> Result<Option<Header>, StoreError> {
        let bytes = self.headers.get(id.as_u128())?;
        let header = bytes.map(|bytes| Header::read(bytes.value()));
        header.transpose()
    }

    /// Changes a header. A job that is gone stays gone.
    fn update(
        &mut self,
        id: Uuid,
        change: impl FnOnce(&mut Header),
    ) -> Result<Outcome, StoreError> {
        if let Some(mut header) = self.header(id)? {
            change(&mut header);
            self.put(id, &header)?;
        }
        Ok(Outcome::Done)
    }

    fn finish(
        &mut self,
        id: Uuid,
        status: &Status,
        result: Option<&LastGeometry>,
    ) -> Result<(), StoreError> {
        let Some(mut header) = self.header(id)? else {
            return Ok(());
        };
        header.set_status(status);
        if let Some(result) = result {
            let bytes = result::kept(result);
            header.bytes += bytes.len() as u64;
            self.results.insert(id.as_u128(), bytes.as_slice())?;
        }
        self.put(id, &header)?;
        if let Some(at) = status.finished {
            let bytes = header.bytes;
            self.ended.push(EndedChange::Add { at, id, bytes });
        }
        Ok(())
    }

    /// Forgets a job; says whether there was one.
    fn remove(&mut self, id: Uuid) -> Result<bool, StoreError> {
        let Some(header) = self.header(id)? else {
            return Ok(false);
        };
        self.headers.remove(id.as_u128())?;
        self.inputs.remove(id.as_u128())?;
        self.results.remove(id.as_u128())?;
        // A key that had expired may belong to another job now.
        if let Some(key) = &header.key
            && self.entry(key)?.is_some_and(|entry| entry.id == id)
        {
            self.keys.remove(key.as_str())?;
        }
        if let Some(at) = header.into_record()?.status.finished {
            self.ended.push(EndedChange::Remove { at, id });
        }
        Ok(true)
    }

    /// Forgets keys that have expired, and these jobs.
    fn retain(&mut self, surplus: Vec<Uuid>) -> Result<Vec<Uuid>, StoreError> {
        self.forget_keys()?;
        for &id in &surplus {
            self.remove(id)?;
        }
        Ok(surplus)
    }

    fn forget_keys(&mut self) -> Result<(), StoreError> {
        let mut expired = Vec::new();
        for item in self.keys.iter()? {
            let (key, bytes) = item?;
            if EntryMessage::read(bytes.value())?.has_expired() {
                expired.push(key.value().to_owned());
            }
        }
        for key in expired {
            self.keys.remove(key.as_str())?;
        }
        Ok(())
    }
}
