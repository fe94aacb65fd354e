//! The open database: reading jobs, and opening it again after an error.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use parking_lot::{Mutex, RwLock, RwLockReadGuard};
use redb::{Database, ReadableDatabase, ReadableTable, TableDefinition};
use tracing::{error, info};
use uuid::Uuid;

use super::clock::Clock;
use super::error::{catch_panic, not_open};
use super::file::{Bytes, StoreFile};
use super::open_error::OpenError;
use super::opening;
use super::tables::{
    self, COMMIT_FACT, FACTS, HEADERS, Header, INPUTS, KEYS, RESULTS, SECRETS, TICKETS, Values,
};
use crate::job::result::LastGeometry;
use crate::job::store::record;
use crate::job::store::{IdempotencyEntry, IdempotencyKey, Record, Secret, Selection, StoreError};
use piad_fit::engine::Problem;

/// The database of a store. It is closed by an I/O error or a panic that has made it unusable; the thread that
/// writes opens it again.
pub(super) struct JobDatabase {
    /// `None` if it cannot be opened again.
    bytes: Option<Bytes>,
    /// `None` if it is in memory.
    file: Option<Arc<StoreFile>>,
    /// `None` after a failure until it could be opened again.
    redb: RwLock<Option<Database>>,
    /// Why new jobs would be lost.
    misplaced: Mutex<Option<String>>,
    pub(super) clock: Clock,
}

impl JobDatabase {
    /// Opens the database in a file of a directory, or creates it, and checks its version.
    pub(super) fn open(directory: &Path, name: &str) -> Result<Self, OpenError> {
        let path = directory.join(name);
        let (file, redb) = opening::open_or_make(directory, &path)?;
        Ok(Self::new(
            Some(Arc::clone(&file) as Bytes),
            Some(file),
            redb,
        ))
    }

    /// A database whose file stays as it is.
    pub(super) fn on_overlay(redb: Database) -> Self {
        Self::new(None, None, redb)
    }

    /// Opens the database in these bytes, or creates it.
    pub(super) fn in_bytes(bytes: Bytes) -> Result<Self, OpenError> {
        let redb = opening::in_bytes(&bytes)?;
        Ok(Self::new(Some(bytes), None, redb))
    }

    fn new(bytes: Option<Bytes>, file: Option<Arc<StoreFile>>, redb: Database) -> Self {
        Self {
            bytes,
            file,
            redb: RwLock::new(Some(redb)),
            misplaced: Mutex::new(None),
            clock: Clock::new(),
        }
    }

    /// Returns true if it is on a disk, which can be full.
    pub(super) fn is_on_disk(&self) -> bool {
        self.file.is_some()
    }

    /// Reads. If the database panics, as it does where pages are damaged, only this read fails.
    pub(super) fn read<T>(
        &self,
        read: impl FnOnce(&Self) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        catch_panic(|| read(self)).unwrap_or_else(|panic| {
            if !catch_panic(|| self.idempotency_entry("").is_ok()).unwrap_or(false) {
                self.close();
            }
            Err(panic)
        })
    }

    /// The database of redb, to begin a transaction.
    pub(super) fn redb(&self) -> RwLockReadGuard<'_, Option<Database>> {
        self.redb.read()
    }

    /// Returns true if it accepts changes: it is open, and has had no fatal error.
    pub(super) fn is_open(&self) -> bool {
        let redb = self.redb();
        let begin = || match &*redb {
            Some(redb) => redb.begin_write().is_ok_and(|it| it.abort().is_ok()),
            None => false,
        };
        catch_panic(begin).unwrap_or(false)
    }

    fn close(&self) {
        if self.bytes.is_some() {
            let closed = self.redb.write().take();
            // A panic while it is closed changes nothing: what was committed is in the file.
            let _ = catch_panic(|| drop(closed));
        }
    }

    /// Opens the database again after an error, with what was committed before it: redb accepts no more changes after
    /// an I/O error.
    pub(super) fn reopen(&self) -> Result<(), StoreError> {
        let Some(bytes) = &self.bytes else {
            return Ok(());
        };
        let mut redb = self.redb.write();
        let closed = redb.take();
        let _ = catch_panic(|| drop(closed));
        *redb = Some(opening::open_again(bytes)?);
        Ok(())
    }

    /// The number of the last commit.
    pub(super) fn last_commit(&self) -> Result<u64, StoreError> {
        let redb = self.redb();
        let redb = redb.as_ref().ok_or_else(not_open)?;
        let facts = redb.begin_read()?.open_table(FACTS)?;
        Ok(facts.get(COMMIT_FACT)?.map_or(0, |number| number.value()))
    }

    /// Checks that the file is where it was opened; logs changes of that.
    pub(super) fn look_for_file(&self) {
        let Some(file) = &self.file else { return };
        let is = file.misplaced();
        let mut was = self.misplaced.lock();
        match (&is, was.is_some()) {
            (Some(reason), false) => error!("{reason}: no more jobs are accepted"),
            (None, true) => info!(path = ?file.path(), "the file of jobs is back"),
            _ => {}
        }
        *was = is;
    }

    /// Why no more jobs are accepted: they would be in a file that cannot be found again.
    pub(super) fn check_place(&self) -> Result<(), StoreError> {
        let reason = self.misplaced.lock().clone();
        reason.map_or(Ok(()), |reason| Err(StoreError::Unusable(reason)))
    }

    /// The ids of all jobs.
    pub(super) fn ids(&self) -> Result<BTreeSet<Uuid>, StoreError> {
        let headers = self.table(HEADERS.table)?;
        let ids = headers.iter()?;
        ids.map(|entry| Ok(Uuid::from_u128(entry?.0.value())))
            .collect()
    }

    /// The bytes of a value.
    pub(super) fn bytes(&self, values: &Values, id: Uuid) -> Result<Option<Vec<u8>>, StoreError> {
        self.get(values, id, |bytes| Ok(bytes.to_vec()))
    }

    fn header(&self, id: Uuid) -> Result<Option<Header>, StoreError> {
        self.get(&HEADERS, id, |bytes| tables::header(id, bytes))
    }

    /// A job without its points.
    pub(super) fn record(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        Ok(self.header(id)?.map(|header| header.record))
    }

    /// The problem of a job.
    pub(super) fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        self.get(&INPUTS, id, |bytes| {
            record::problem(id, bytes).map(Arc::new)
        })
    }

    /// The geometry of the last level of a job.
    pub(super) fn result(&self, id: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        self.get(&RESULTS, id, |bytes| record::result(id, bytes))
    }

    /// Jobs, the newest first.
    pub(super) fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        let end = selection.before.unwrap_or(Uuid::max()).as_u128();
        let headers = self.table(HEADERS.table)?;
        let records = headers.range(..end)?.rev().map(tables::of_entry);
        let wanted = |record: &Record| {
            selection.state.is_none_or(|it| it == record.status.state)
                && selection
                    .tenant
                    .is_none_or(|it| it == record.outline.tenant)
        };
        let records = records.filter(|record| record.as_ref().map_or(true, wanted));
        records.take(selection.limit).collect()
    }

    /// Jobs that have not ended, the oldest first.
    pub(super) fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        let headers = self.table(HEADERS.table)?;
        let records = headers.iter()?.map(tables::of_entry);
        let unfinished = |record: &Record| !record.status.state.is_final();
        let records = records.filter(|record| record.as_ref().map_or(true, unfinished));
        records.collect()
    }

    /// The idempotency key of the request that made a job, unless it has expired.
    pub(super) fn key_of(&self, id: Uuid) -> Result<Option<IdempotencyKey>, StoreError> {
        let Some(name) = self.header(id)?.and_then(|header| header.key) else {
            return Ok(None);
        };
        let entry = self.idempotency_entry(&name)?;
        // A key that had expired may belong to another job now.
        let entry = entry.filter(|entry| entry.id == id);
        Ok(entry.map(|entry| IdempotencyKey {
            name,
            digest: entry.digest,
        }))
    }

    /// The stored secret; if there is none, this one, which is then stored.
    pub(super) fn secret(&self, new: Secret) -> Result<Secret, StoreError> {
        let redb = self.redb();
        let redb = redb.as_ref().ok_or_else(not_open)?;
        let transaction = redb.begin_write()?;
        {
            let mut secrets = transaction.open_table(SECRETS)?;
            let kept = secrets.get(TICKETS)?.map(|it| it.value().try_into());
            if let Some(Ok(kept)) = kept {
                return Ok(kept);
            }
            secrets.insert(TICKETS, new.as_slice())?;
        }
        transaction.commit()?;
        Ok(new)
    }

    /// The entry of an idempotency key, unless it has expired.
    pub(super) fn idempotency_entry(
        &self,
        key: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        let keys = self.table(KEYS)?;
        let bytes = keys.get(key)?;
        let entry = bytes.map(|bytes| tables::key_in(bytes.value()));
        let now = self.clock.measured();
        Ok(entry.transpose()?.filter(|entry| !entry.has_expired(now)))
    }

    /// A snapshot of a table. Its pages are not reused as long as it lives. What `ReadOnlyTable` itself returns may
    /// outlive it and does not keep them: what the trait returns may not.
    fn table<K: redb::Key + 'static>(
        &self,
        table: TableDefinition<K, &'static [u8]>,
    ) -> Result<impl ReadableTable<K, &'static [u8]> + use<K>, StoreError> {
        let redb = self.redb();
        let redb = redb.as_ref().ok_or_else(not_open)?;
        Ok(redb.begin_read()?.open_table(table)?)
    }

    fn get<T>(
        &self,
        values: &Values,
        id: Uuid,
        decode: impl FnOnce(&[u8]) -> Result<T, StoreError>,
    ) -> Result<Option<T>, StoreError> {
        let table = self.table(values.table)?;
        let Some(value) = table.get(id.as_u128())? else {
            return Ok(None);
        };
        decode(values.opened(id, value.value())?).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use redb::Table;
    use redb::backends::InMemoryBackend;

    use super::*;
    use crate::job::store::embedded::envelope::{Kind, envelope};

    type Results<'a> = Table<'a, u128, &'static [u8]>;

    #[test]
    fn jobs_can_be_deleted_while_they_are_decoded() {
        let database = JobDatabase::in_bytes(Arc::new(InMemoryBackend::new())).unwrap();
        let write = |change: &dyn Fn(&mut Results<'_>)| {
            let redb = database.redb();
            let transaction = redb.as_ref().unwrap().begin_write().unwrap();
            change(&mut transaction.open_table(RESULTS.table).unwrap());
            transaction.commit().unwrap();
        };
        for length in [200, 3800, 100_000] {
            let (id, bytes) = (Uuid::from_u128(length), vec![7; length as usize]);
            let insert = |table: &mut Results<'_>, id| {
                let outside = envelope(Kind::Result, Uuid::from_u128(id), &bytes);
                let value = [outside.as_slice(), &bytes].concat();
                table.insert(id, value.as_slice()).unwrap();
            };
            write(&|table| insert(table, length));
            let read = database.get(&RESULTS, id, |read| {
                write(&|table| drop(table.remove(length).unwrap()));
                // Later commits reuse the pages of the removed value, unless they are read.
                for other in 1..6 {
                    write(&|table| insert(table, length + other));
                }
                Ok(read.to_vec())
            });
            assert_eq!(read.unwrap(), Some(bytes));
            assert_eq!(database.get(&RESULTS, id, |_| Ok(())).unwrap(), None);
        }
    }
}
