//! Where jobs are kept: their problems, states and final control points. Frames are not.

pub mod blame;
pub mod embedded;

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use futures_util::future::BoxFuture;
use jiff::Timestamp;
use thiserror::Error;
use uuid::Uuid;

use super::outline::Outline;
use super::scheduler::Broken;
use super::state::{State, Status};
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// The most jobs that are forgotten together: where there is little room, many would not go.
pub const FORGOTTEN_AT_ONCE: usize = 100;

/// How long the key of a request is remembered.
pub const KEY_LIFETIME: Duration = Duration::from_secs(24 * 60 * 60);

/// A job as it is kept, without its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What it is.
    pub outline: Outline,
    /// What has become of it.
    pub status: Status,
    /// How many crashes of the process it may be to blame for.
    pub crashes: u32,
    /// It runs under watch, as it may be to blame for a crash.
    pub watched: bool,
}

/// A key by which a client recognises its request, and a digest of what was asked for with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// The key.
    pub name: String,
    /// SHA-256 of the request.
    pub digest: [u8; 32],
}

/// The job that was made for a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Made {
    /// The job.
    pub id: Uuid,
    /// The digest of the request.
    pub digest: [u8; 32],
    /// When it was made.
    pub at: Timestamp,
}

impl Made {
    /// Whether the key is not remembered any more.
    pub fn is_forgotten(&self) -> bool {
        is_older(self.at, KEY_LIFETIME)
    }
}

/// Which jobs to list.
#[derive(Clone, Copy, Debug)]
pub struct Selection {
    /// Only jobs in this state.
    pub state: Option<State>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    /// At most so many.
    pub limit: usize,
}

/// How much of the past is kept: the first jobs to end are the first to be forgotten.
#[derive(Clone, Copy, Debug)]
pub struct Retention {
    /// Jobs that have ended.
    pub jobs: usize,
    /// Bytes of their data and results.
    pub bytes: u64,
    /// How long after their end.
    pub age: Duration,
}

/// The store did not do what it was asked for.
#[derive(Clone, Debug, Error)]
pub enum StoreError {
    /// There is no room.
    #[error("the store is full: {0}")]
    Full(String),
    /// The job was deleted in the meantime.
    #[error("the job {0} was deleted")]
    Gone(Uuid),
    /// Anything else.
    #[error("the store failed: {0}")]
    Failed(String),
    /// Not the store, but what was to be made of its records.
    #[error(transparent)]
    Broken(#[from] Broken),
}

/// The acknowledgement of a write.
pub type Kept<T> = BoxFuture<'static, Result<T, StoreError>>;

/// Keeps jobs.
///
/// Writes take effect in the order in which they are called; what a write's future has returned
/// from is kept, whatever happens to the process.
#[async_trait]
pub trait Store: Send + Sync {
    /// Keeps a new job, unless there is one for the same key: then gives that one.
    fn insert(&self, record: Record, problem: Arc<Problem>, key: Option<Key>)
    -> Kept<Option<Made>>;

    /// Keeps that a queued job runs now, perhaps under watch. A job that is gone stays gone.
    fn start(&self, id: Uuid, status: Status, watched: bool) -> Kept<()>;

    /// Keeps that a job is not under watch any more.
    fn clear(&self, id: Uuid) -> Kept<()>;

    /// Puts a job back into the queue. Who does so is alive: there was no crash.
    fn requeue(&self, id: Uuid) -> Kept<()>;

    /// Keeps the final state and control points of a job. A job that is gone stays gone.
    fn finish(&self, id: Uuid, status: Status, result: Option<Arc<Points>>) -> Kept<()>;

    /// Forgets a job; says whether there was one.
    fn remove(&self, id: Uuid) -> Kept<bool>;

    /// Forgets jobs that have ended until the rest is within `retention`, at most
    /// [`FORGOTTEN_AT_ONCE`], and old keys.
    fn retain(&self, retention: Retention) -> Kept<Vec<Uuid>>;

    /// The job of this id.
    async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError>;

    /// The problem of the job of this id.
    async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError>;

    /// The free control points of the last level of a job that has ended.
    async fn result(&self, id: Uuid) -> Result<Option<Arc<Points>>, StoreError>;

    /// Jobs, the newest first.
    async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError>;

    /// Jobs that have not ended, the oldest first.
    async fn unfinished(&self) -> Result<Vec<Record>, StoreError>;

    /// The job that was made for a key.
    async fn made(&self, key: &str) -> Result<Option<Made>, StoreError>;
}

/// Whether it was longer ago than this. What lies in the future is young: a clock that was ahead must
/// not make anything be forgotten.
fn is_older(at: Timestamp, age: Duration) -> bool {
    let passed = Timestamp::now().duration_since(at);
    Duration::try_from(passed).is_ok_and(|passed| passed > age)
}

/// Which of the jobs that have ended to forget, and how many there are: the bookkeeping that
/// stores share. Jobs are ordered by the time at which they ended.
#[derive(Debug, Default)]
pub struct Ended {
    jobs: std::collections::BTreeMap<(Timestamp, Uuid), u64>,
    bytes: u64,
}

impl Ended {
    /// A job has ended and takes so many bytes.
    pub fn add(&mut self, at: Timestamp, id: Uuid, bytes: u64) {
        let before = self.jobs.insert((at, id), bytes).unwrap_or(0);
        self.bytes = self.bytes + bytes - before;
    }

    /// A job is gone; gives the bytes that it took.
    pub fn remove(&mut self, at: Timestamp, id: Uuid) -> u64 {
        let bytes = self.jobs.remove(&(at, id)).unwrap_or(0);
        self.bytes -= bytes;
        bytes
    }

    /// The jobs to be forgotten.
    pub fn surplus(&self, retention: Retention) -> Vec<Uuid> {
        let (mut jobs, mut bytes) = (self.jobs.len(), self.bytes);
        let surplus = self.jobs.iter().take_while(|&(&(at, _), size)| {
            let old = is_older(at, retention.age);
            let forget = old || jobs > retention.jobs || bytes > retention.bytes;
            jobs -= 1;
            bytes -= size;
            forget
        });
        surplus
            .map(|(&(_, id), _)| id)
            .take(FORGOTTEN_AT_ONCE)
            .collect()
    }
}

#[cfg(test)]
mod tests;
