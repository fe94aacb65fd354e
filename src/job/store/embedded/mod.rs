//! A store in one file, of the embedded ACID database redb.
//!
//! - [`tables`]: the tables of the file, and the version of their content;
//! - [`database`]: the open file, and what is read from it;
//! - [`opening`]: opens the file, or says what is wrong with it;
//! - [`writer`]: the one thread that writes, many changes in a commit; [`change`]: what it is asked for;
//!   [`transaction`]: what that does to the tables; [`recovery`]: the first transaction after a start;
//! - [`error`]: errors and panics of the database;
//! - [`header`], [`status`], [`warning`], [`idempotency`]; [`input`], [`points`]; [`fields`]: records and
//!   problems as protobuf messages.
//!
//! Reads see what was committed. Lists wait for the changes before them.

mod change;
mod database;
mod error;
mod fields;
#[cfg(any(test, fuzzing))]
pub(crate) mod fuzzing;
mod header;
mod idempotency;
mod input;
mod opening;
mod points;
mod recovery;
mod result;
mod status;
mod tables;
mod transaction;
mod warning;
mod writer;

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use async_trait::async_trait;
use tokio::sync::oneshot;
use uuid::Uuid;

use super::{
    Acknowledgement, IdempotencyEntry, IdempotencyKey, Record, Retention, Selection, Store,
    StoreError,
};
use crate::fit::problem::Problem;
use crate::job::counters::Counters;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use change::{Change, Outcome};
use database::JobDatabase;
pub use opening::OpenError;
use writer::{WriteRequest, Writer};

/// The name of the file in the data directory.
const FILE: &str = "piad.redb";

/// Jobs in a file, on a disk or in memory.
pub struct EmbeddedStore {
    database: Arc<JobDatabase>,
    writer: Writer,
}

impl EmbeddedStore {
    /// Opens the store in a directory, which is made if need be. Jobs that were running in a crash
    /// go back to the queue, or fail if that has happened too often.
    pub fn open(directory: &Path, counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::open(directory, FILE)?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(|error| OpenError::of_records(directory.join(FILE), error))?;
        Ok(Self { database, writer })
    }

    /// Makes a store in memory, which ends with the process.
    pub fn in_memory(counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::in_memory()?);
        let writer = Writer::start(Arc::clone(&database), counters);
        let writer = writer.map_err(OpenError::Recovery)?;
        Ok(Self { database, writer })
    }

    /// A change, which takes its place in the order of changes now.
    fn write<T: Send + 'static>(
        &self,
        change: Change,
        understand: impl FnOnce(Outcome) -> T + Send + 'static,
    ) -> Acknowledgement<T> {
        let (reply, receiver) = oneshot::channel();
        let sent = self.writer.send(WriteRequest { change, reply });
        Box::pin(async move {
            sent?;
            let outcome = receiver.await.unwrap_or_else(|_| Err(writer::ended()));
            outcome.map(understand)
        })
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

#[async_trait]
impl Store for EmbeddedStore {
    fn insert(
        &self,
        record: Record,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
    ) -> Acknowledgement<Option<IdempotencyEntry>> {
        let change = Change::Insert {
            record: Box::new(record),
            problem,
            key,
        };
        self.write(change, |outcome| match outcome {
            Outcome::Existing(entry) => Some(entry),
            _ => None,
        })
    }

    fn start(&self, id: Uuid, status: Status, on_probation: bool) -> Acknowledgement<()> {
        let change = Change::Start {
            id,
            status,
            on_probation,
        };
        self.write(change, drop)
    }

    fn requeue(&self, id: Uuid) -> Acknowledgement<()> {
        self.write(Change::Requeue { id }, drop)
    }

    fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    ) -> Acknowledgement<()> {
        self.write(Change::Finish { id, status, result }, drop)
    }

    fn remove(&self, id: Uuid) -> Acknowledgement<bool> {
        self.write(Change::Remove { id }, |outcome| {
            matches!(outcome, Outcome::Removed(true))
        })
    }

    fn retain(&self, retention: Retention, spared: HashSet<Uuid>) -> Acknowledgement<Vec<Uuid>> {
        let change = Change::Retain { retention, spared };
        self.write(change, |outcome| match outcome {
            Outcome::Forgotten(jobs) => jobs,
            _ => Vec::new(),
        })
    }

    async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        self.read(move |database| database.record(id)).await
    }

    async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        self.read(move |database| database.problem(id)).await
    }

    async fn result(&self, id: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        self.read(move |database| database.result(id)).await
    }

    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        self.write(Change::Nothing, drop).await?;
        self.read(move |database| database.list(selection)).await
    }

    async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        self.read(JobDatabase::unfinished).await
    }

    async fn idempotency_entry(&self, key: &str) -> Result<Option<IdempotencyEntry>, StoreError> {
        let key = key.to_owned();
        self.read(move |database| database.idempotency_entry(&key))
            .await
    }
}
