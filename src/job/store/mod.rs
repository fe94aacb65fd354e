//! Where jobs are kept: their problems, states and final control points, in one file of the embedded ACID
//! database redb, or in memory. Frames are not kept.
//!
//! - [`record`]: the tables of the file, and what stands in them;
//! - [`database`]: the open file, and what is read from it; [`opening`]: opens the file, or says what is
//!   wrong with it; [`error`]: errors and panics of the database;
//! - [`writer`]: the one thread that writes, many changes in a commit; [`change`]: a change on its way there
//!   and back; [`transaction`]: what changes do to the tables;
//! - [`crash_recovery`]: what becomes of jobs that were running in a crash; [`ended`]: which jobs that have
//!   ended to forget.

mod change;
pub(crate) mod crash_recovery;
mod database;
mod ended;
mod error;
#[cfg(any(test, fuzzing))]
pub(crate) mod fuzzing;
mod opening;
pub(super) mod record;
mod transaction;
mod writer;

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use uuid::Uuid;

use super::counters::Counters;
use super::outline::Outline;
use super::peer::Peer;
use super::result::LastGeometry;
use super::scheduler::Broken;
use super::state::{State, Status};
use crate::fit::problem::Problem;
use database::JobDatabase;
pub(crate) use opening::OpenError;
use writer::Writer;

/// The name of the file in the data directory.
const FILE: &str = "piad.redb";

/// The most jobs that [`Store::retain`] forgets in one go. Forgetting takes space on the disk before it
/// frees some: where the disk is nearly full, many jobs could not be forgotten together.
pub(crate) const FORGOTTEN_AT_ONCE: usize = 100;

/// How long an idempotency key is remembered.
pub(crate) const KEY_LIFETIME: Duration = Duration::from_secs(24 * 60 * 60);

/// A job as it is kept, without its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// What it is.
    pub outline: Outline,
    /// What has become of it.
    pub status: Status,
    /// How many crashes of the process are counted for it.
    pub crashes: u32,
    /// It was running in a crash, and runs again for a moment before the next such job.
    pub on_probation: bool,
}

impl Record {
    /// The record of a job that was just accepted.
    pub(crate) fn new(outline: Outline, status: Status) -> Self {
        Self {
            outline,
            status,
            crashes: 0,
            on_probation: false,
        }
    }
}

/// An idempotency key: the name by which a client recognises its request, with whose it is, and a digest of
/// what was asked for with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct IdempotencyKey {
    /// The name.
    pub name: String,
    /// SHA-256 of the request.
    pub digest: [u8; 32],
}

impl IdempotencyKey {
    /// A key of a peer, under the name that it has chosen. Each peer has keys of its own: no name contains
    /// the end of a line.
    pub(crate) fn new(peer: Option<Peer>, name: &str, digest: [u8; 32]) -> Self {
        let owner = peer.map_or_else(String::new, |peer| peer.to_string());
        Self {
            name: format!("{owner}\n{name}"),
            digest,
        }
    }
}

/// What is remembered of an idempotency key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct IdempotencyEntry {
    /// The job that was made.
    pub id: Uuid,
    /// The digest of the request that made it.
    pub digest: [u8; 32],
    /// When it was made.
    pub created: Timestamp,
}

impl IdempotencyEntry {
    /// Whether the key is not remembered any more.
    pub(crate) fn has_expired(&self) -> bool {
        is_older(self.created, KEY_LIFETIME)
    }
}

/// Which jobs to list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Selection {
    /// Only jobs in this state.
    pub state: Option<State>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    /// At most so many.
    pub limit: usize,
}

/// How much of the past is kept: the first jobs to end are the first to be forgotten.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Retention {
    /// The most jobs that have ended.
    pub jobs: usize,
    /// The most bytes of their data and results.
    pub bytes: u64,
    /// How long they are kept after their end.
    pub age: Duration,
}

/// The store did not do what it was asked for.
#[derive(Clone, Debug, Error)]
pub enum StoreError {
    /// There is no space for what was to be kept. It may succeed later.
    #[error("the store is full: {0}")]
    Full(String),
    /// The job was deleted in the meantime.
    #[error("the job {0} was deleted")]
    Gone(Uuid),
    /// Anything else.
    #[error("the store failed: {0}")]
    Failed(String),
    /// The store worked, but the computation that needed its records panicked.
    #[error(transparent)]
    Broken(#[from] Broken),
}

/// Completes when a change is durable, with what has come of it.
pub(crate) type Acknowledgement<T> = BoxFuture<'static, Result<T, StoreError>>;

/// Keeps jobs.
///
/// It promises:
///
/// - **Order.** Changes take effect in the order in which the methods are called, whether or not anybody
///   waits for their acknowledgements.
/// - **Atomicity.** A change happens as a whole or not at all. One that has failed can be asked for again.
/// - **Durability.** A change that was acknowledged survives whatever happens to the process, and in a store
///   on a disk also a loss of power. A crash may lose changes that were not acknowledged yet, the latest
///   ones first: if a change is there, all changes before it are there that have not
///   failed. A store in memory ends with the
///   process.
/// - **Reads** see everything that was acknowledged before they were called; [`list`](Self::list) also sees
///   changes that were called before it and are not acknowledged yet. What a read has given stays valid when
///   the job is deleted.
/// - **A job that is gone stays gone.** Changes of a job that is not there succeed, and do nothing.
pub(crate) struct Store {
    database: Arc<JobDatabase>,
    writer: Writer,
}

impl Store {
    /// Opens the store in a directory, which is made if need be. Jobs that were running in a crash
    /// go back to the queue, or fail if that has happened too often.
    pub(crate) fn open(directory: &Path, counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::open(directory, FILE)?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(|error| OpenError::of_records(directory.join(FILE), error))?;
        Ok(Self { database, writer })
    }

    /// Makes a store in memory, which ends with the process.
    pub(crate) fn in_memory(counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::in_memory()?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(OpenError::Recovery)?;
        Ok(Self { database, writer })
    }

    /// Keeps a new job, unless there is an entry for the same key: then gives that entry.
    pub(crate) fn insert(
        &self,
        record: Record,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
    ) -> Acknowledgement<Option<IdempotencyEntry>> {
        let points = problem.grid().count();
        self.writer.write(points, move |transaction| {
            transaction.insert(&record, &problem, key.as_ref())
        })
    }

    /// Keeps that a job runs now, and whether it is on probation.
    pub(crate) fn start(
        &self,
        id: Uuid,
        status: Status,
        on_probation: bool,
    ) -> Acknowledgement<()> {
        self.writer.write(0, move |transaction| {
            transaction.update(id, |record| {
                record.status = status.clone();
                record.on_probation = on_probation;
            })
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

    /// Keeps the final state and control points of a job.
    pub(crate) fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    ) -> Acknowledgement<()> {
        let points = result.as_ref().map_or(0, |it| it.control_points.len());
        self.writer.write(points, move |transaction| {
            transaction.finish(id, &status, result.as_ref())
        })
    }

    /// Forgets a job and its key; says whether there was one.
    pub(crate) fn remove(&self, id: Uuid) -> Acknowledgement<bool> {
        self.writer
            .write(0, move |transaction| transaction.remove(id))
    }

    /// Forgets jobs that have ended until the rest is within `retention`, at most [`FORGOTTEN_AT_ONCE`],
    /// and keys that have expired. Jobs in `spared` stay, beyond the retention. Gives the ids of those that
    /// were forgotten.
    pub(crate) fn retain(
        &self,
        retention: Retention,
        spared: HashSet<Uuid>,
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
        // An empty change is acknowledged after the changes before it.
        self.writer.write(0, |_| Ok(())).await?;
        self.read(move |database| database.list(selection)).await
    }

    /// Jobs that have not ended, the oldest first.
    pub(crate) async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        self.read(JobDatabase::unfinished).await
    }

    /// What is remembered of an idempotency key.
    pub(crate) async fn idempotency_entry(
        &self,
        key: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        let key = key.to_owned();
        self.read(move |database| database.idempotency_entry(&key))
            .await
    }

    /// Reads off the threads that serve the network.
    async fn read<T: Send + 'static>(
        &self,
        read: impl FnOnce(&JobDatabase) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, StoreError> {
        let database = Arc::clone(&self.database);
        let read = tokio::task::spawn_blocking(move || database.read(read));
        read.await
            .unwrap_or_else(|error| Err(StoreError::Failed(error.to_string())))
    }
}

/// Whether it was longer ago than this. A time in the future is not: a clock that was ahead must not make
/// anything be forgotten.
fn is_older(at: Timestamp, age: Duration) -> bool {
    let passed = Timestamp::now().duration_since(at);
    Duration::try_from(passed).is_ok_and(|passed| passed > age)
}

#[cfg(test)]
mod tests;
