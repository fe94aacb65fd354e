//! The store of one process: one file of the embedded ACID database redb, or in memory.
//!
//! - [`tables`]: the tables of the file, and their contents; [`envelope`]: the checksum of each value;
//! - [`file`]: the open file; [`database`]: the open database, and reads; [`opening`]: opens it, or reports errors;
//!   [`error`]: errors and panics of the database; [`clock`]: its time;
//! - [`writer`]: the one thread that writes, many changes in a commit; [`change`]: a change on its way there and back;
//!   [`committer`]: commits, and the treatment of failed ones; [`transaction`]: effects of changes on the tables;
//!   [`ended`]: the order of removal of jobs; [`usage`]: the usage of tenants; [`recovery`]: after a crash;
//! - [`salvage`]: the readable contents of a damaged file, with an [`overlay`] above it.

mod change;
mod clock;
mod committer;
mod database;
mod ended;
mod envelope;
mod error;
#[cfg(test)]
mod failures;
mod file;
pub(super) mod open_error;
mod opening;
mod overlay;
mod recovery;
pub(crate) mod salvage;
pub(super) mod tables;
mod transaction;
mod usage;
mod writer;

use std::path::Path;
use std::sync::Arc;

use jiff::Timestamp;
use redb::backends::InMemoryBackend;
use uuid::Uuid;

use super::{
    Acknowledgement, IdempotencyEntry, IdempotencyKey, Insertion, OpenError, Record, Retention,
    Secret, Selection, Spared, StoreError,
};
use crate::job::counters::Counters;
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use database::JobDatabase;
use file::Bytes;
use piad_fit::engine::Problem;
use writer::Writer;

/// The name of the file in the data directory.
const FILE: &str = "piad.redb";

/// The number of attempts of an interrupted read.
const READS: usize = 3;

/// The store of one process. All its changes take effect in the order in which the methods are called.
pub(crate) struct Embedded {
    database: Arc<JobDatabase>,
    writer: Writer,
}

impl Embedded {
    /// Opens the store in a directory, which is created if needed. Jobs that were running in a crash go back to the
    /// queue, or fail if that has happened too often.
    pub(crate) fn open(directory: &Path, counters: Counters) -> Result<Self, OpenError> {
        Self::open_file(directory, FILE, counters)
    }

    fn open_file(directory: &Path, name: &str, counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::open(directory, name)?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(|error| OpenError::of_records(directory.join(name), error))?;
        Ok(Self { database, writer })
    }

    /// Creates a store in memory, which ends with the process.
    pub(crate) fn in_memory(counters: Counters) -> Result<Self, OpenError> {
        Self::in_bytes(Arc::new(InMemoryBackend::new()), counters)
    }

    fn in_bytes(bytes: Bytes, counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::in_bytes(bytes)?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(OpenError::Recovery)?;
        Ok(Self { database, writer })
    }

    /// See [`super::Store::insert`].
    pub(crate) fn insert(
        &self,
        record: Record,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
        quota: Quota,
    ) -> Acknowledgement<Insertion> {
        let (id, points) = (record.outline.id, problem.grid().count());
        self.writer.insert(id, points, move |transaction| {
            transaction.insert(&record, &problem, key.as_ref(), &quota)
        })
    }

    /// Stores that a job runs now, and whether it is on probation.
    pub(crate) fn start(
        &self,
        id: Uuid,
        status: Status,
        on_probation: bool,
    ) -> Acknowledgement<bool> {
        self.writer.write(0, move |transaction| {
            transaction.update(id, |record| {
                record.status = status.clone();
                record.on_probation = on_probation;
            })?;
            Ok(true)
        })
    }

    /// Puts a job back into the queue at an orderly end of the process, and clears its count of crashes.
    pub(crate) fn requeue(&self, id: Uuid) -> Acknowledgement<()> {
        self.writer.write(0, move |transaction| {
            transaction.update(id, |record| {
                record.status = Status::QUEUED;
                (record.crashes, record.on_probation) = (0, false);
            })
        })
    }

    /// Stores the final state and control points of a job.
    pub(crate) fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    ) -> Acknowledgement<bool> {
        let points = result.as_ref().map_or(0, |it| it.control_points.len());
        self.writer.write(points, move |transaction| {
            transaction.finish(id, &status, result.as_ref())?;
            Ok(true)
        })
    }

    /// Removes a job and its key; returns true if there was one.
    pub(crate) fn remove(&self, id: Uuid) -> Acknowledgement<bool> {
        self.writer
            .write(0, move |transaction| transaction.remove(id))
    }

    /// Removes jobs that have ended until the rest is within `retention`, at most [`FORGOTTEN_AT_ONCE`], and keys that
    /// have expired. Jobs in use stay, beyond the retention. Returns the ids of those removed.
    pub(crate) fn retain(
        &self,
        retention: Retention,
        spared: Spared,
    ) -> Acknowledgement<Vec<Uuid>> {
        self.writer
            .write(0, move |transaction| transaction.retain(retention, &spared))
    }

    /// The job of this id.
    pub(crate) async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        self.read(move |database| database.record(id)).await
    }

    /// The problem of the job of this id.
    pub(crate) async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        self.read(move |database| database.problem(id)).await
    }

    /// The geometry of the last level of a job that has ended.
    pub(crate) async fn result(&self, id: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        self.read(move |database| database.result(id)).await
    }

    /// Jobs, the newest first.
    pub(crate) async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        self.writer.barrier().await?;
        self.read(move |database| database.list(selection)).await
    }

    /// Jobs that have not ended, the oldest first.
    pub(crate) async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        self.read(JobDatabase::unfinished).await
    }

    /// See [`super::Store::key_of`].
    pub(super) async fn key_of(&self, id: Uuid) -> Result<Option<IdempotencyKey>, StoreError> {
        self.read(move |database| database.key_of(id)).await
    }

    /// The entry of an idempotency key.
    pub(crate) async fn idempotency_entry(
        &self,
        key: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        let key = key.to_owned();
        self.read(move |database| database.idempotency_entry(&key))
            .await
    }

    /// See [`super::Store::now`].
    pub(super) fn now(&self) -> Timestamp {
        self.database.clock.now()
    }

    /// See [`super::Store::stamp`].
    pub(super) fn stamp(&self) -> Timestamp {
        self.database.clock.stamp()
    }

    /// See [`super::Store::check`].
    pub(super) fn check_place(&self) -> Result<(), StoreError> {
        self.database.check_place()
    }

    /// See [`super::Store::secret`].
    pub(super) async fn secret(&self, new: Secret) -> Result<Secret, StoreError> {
        self.read(move |database| database.secret(new)).await
    }

    /// Reads off the network threads. Reads that were interrupted by an error elsewhere are repeated, from the reopened
    /// database.
    async fn read<T: Send + 'static>(
        &self,
        read: impl Fn(&JobDatabase) -> Result<T, StoreError> + Clone + Send + 'static,
    ) -> Result<T, StoreError> {
        for _ in 0..READS {
            match self.read_once(read.clone()).await {
                Err(StoreError::Unusable(_)) => self.writer.barrier().await?,
                done => return done,
            }
        }
        self.read_once(read).await
    }

    async fn read_once<T: Send + 'static>(
        &self,
        read: impl FnOnce(&JobDatabase) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, StoreError> {
        let database = Arc::clone(&self.database);
        let read = tokio::task::spawn_blocking(move || database.read(read));
        read.await
            .unwrap_or_else(|error| Err(StoreError::Failed(error.to_string())))
    }
}
