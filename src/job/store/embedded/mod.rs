//! A store in one file, of the embedded ACID database redb.
//!
//! - [`tables`]: what stands in the file, and the version of that;
//! - [`database`]: the open file, and what is read from it;
//! - [`writer`]: the one thread that writes, many writes in a commit;
//! - [`opening`]: the file is found whole, or refused with a reason; [`memory_file`]: a file in memory;
//! - [`error`], [`quiet`]: errors and panics of the database;
//! - [`room`]: what is kept back for when the disk is full;
//! - [`header`], [`warning`], [`input`]: records and problems as protobuf messages, so that fields can be added.
//!
//! Reads see what was committed. Lists wait for the writes before them.

mod database;
mod error;
mod header;
mod input;
mod memory_file;
mod opening;
mod quiet;
mod room;
mod tables;
mod warning;
mod writer;

use std::path::Path;
use std::sync::Arc;

use async_trait::async_trait;
use tokio::sync::oneshot;
use uuid::Uuid;

use super::{Kept, Key, Made, Record, Retention, Selection, Store, StoreError};
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::job::counters::Counters;
use crate::job::state::Status;
use database::JobDatabase;
pub use opening::OpenError;
use room::Room;
use writer::{Change, Outcome, Write, Writer};

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
        let room = Some(Room::new(directory));
        let writer = Writer::start(Arc::clone(&database), room, counters);
        let writer = writer.map_err(|error| OpenError::of_records(directory.join(FILE), error))?;
        Ok(Self { database, writer })
    }

    /// Makes a store in memory, which ends with the process.
    pub fn in_memory(counters: Counters) -> Result<Self, OpenError> {
        let database = Arc::new(JobDatabase::in_memory()?);
        let writer = Writer::start(Arc::clone(&database), None, counters);
        let writer = writer.map_err(OpenError::Recovery)?;
        Ok(Self { database, writer })
    }

    /// A write that takes its place in the order of writes now.
    fn write<T: Send + 'static>(
        &self,
        change: Change,
        understand: impl FnOnce(Outcome) -> T + Send + 'static,
    ) -> Kept<T> {
        let (reply, receiver) = oneshot::channel();
        let sent = self.writer.send(Write { change, reply });
        Box::pin(async move {
            sent?;
            let outcome = receiver.await.unwrap_or_else(|_| Err(writer::gone()));
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
        key: Option<Key>,
    ) -> Kept<Option<Made>> {
        let change = Change::Insert {
            record: Box::new(record),
            problem,
            key,
        };
        self.write(change, |outcome| match outcome {
            Outcome::Made(made) => Some(made),
            _ => None,
        })
    }

    fn start(&self, id: Uuid, status: Status, watched: bool) -> Kept<()> {
        let change = Change::Start {
            id,
            status,
            watched,
        };
        self.write(change, drop)
    }

    fn clear(&self, id: Uuid) -> Kept<()> {
        self.write(Change::Clear { id }, drop)
    }

    fn requeue(&self, id: Uuid) -> Kept<()> {
        self.write(Change::Requeue { id }, drop)
    }

    fn finish(&self, id: Uuid, status: Status, result: Option<Arc<Points>>) -> Kept<()> {
        self.write(Change::Finish { id, status, result }, drop)
    }

    fn remove(&self, id: Uuid) -> Kept<bool> {
        self.write(Change::Remove { id }, |outcome| {
            matches!(outcome, Outcome::Removed(true))
        })
    }

    fn retain(&self, retention: Retention) -> Kept<Vec<Uuid>> {
        self.write(Change::Retain(retention), |outcome| match outcome {
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

    async fn result(&self, id: Uuid) -> Result<Option<Arc<Points>>, StoreError> {
        self.read(move |database| database.result(id)).await
    }

    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        self.write(Change::Nothing, drop).await?;
        self.read(move |database| database.list(selection)).await
    }

    async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        self.read(JobDatabase::unfinished).await
    }

    async fn made(&self, key: &str) -> Result<Option<Made>, StoreError> {
        let key = key.to_owned();
        self.read(move |database| database.made(&key)).await
    }
}
