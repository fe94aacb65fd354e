//! Where jobs are kept: their problems, states and final control points. Frames are not kept.
//!
//! - [`embedded`]: in a file or in the memory of one process; [`shared`]: in PostgreSQL, for any number of
//!   replicas;
//! - [`record`]: the bytes of a job;
//! - [`crash_recovery`]: what becomes of jobs that were running in a crash;
//! - [`copy`]: from one store to another.

pub(crate) mod copy;
pub(crate) mod crash_recovery;
pub(crate) mod embedded;
#[cfg(any(test, fuzzing))]
pub(crate) mod fuzzing;
pub(super) mod record;
pub(crate) mod shared;

use std::collections::HashSet;
use std::fmt::Display;
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
use super::quota::{Exceeded, Quota};
use super::result::LastGeometry;
use super::scheduler::Broken;
use super::state::{State, Status};
use super::tenant::Tenant;
use crate::fit::problem::Problem;
use embedded::Embedded;
pub(crate) use embedded::opening::OpenError;
use shared::{Settings, Shared};

/// The most jobs that [`Store::retain`] forgets in one go. Forgetting takes space on the disk before it
/// frees some: where the disk is nearly full, many jobs could not be forgotten together.
pub(crate) const FORGOTTEN_AT_ONCE: usize = 100;

/// The bytes of a secret.
pub(crate) type Secret = [u8; 32];

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
    /// Returns true if the key is not remembered any more at this time.
    pub(crate) fn has_expired(&self, now: Timestamp) -> bool {
        is_older(self.created, KEY_LIFETIME, now)
    }
}

/// What has become of a job that was to be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Insertion {
    /// It is kept.
    New,
    /// There is an entry for the same key.
    Known(IdempotencyEntry),
    /// Its tenant would have too much.
    Refused(Exceeded),
}

/// Which jobs to list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Selection {
    /// Only jobs of this tenant.
    pub tenant: Option<Tenant>,
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

/// A look at who holds jobs is not older than this when jobs are forgotten by it.
pub(crate) const LOOK_LIFETIME: Duration = Duration::from_secs(10 * 60);

/// The jobs that stay although they are beyond the retention.
#[derive(Clone, Debug)]
pub(crate) struct Spared {
    /// Those that somebody holds.
    pub held: HashSet<Uuid>,
    /// When that was looked up, by [`Store::now`]. Jobs that have ended since then may be held, too; not those of
    /// a clock that was far ahead.
    pub since: Timestamp,
}

impl Spared {
    /// Whether a job stays that ended at this time.
    fn spares(&self, at: Timestamp, id: Uuid) -> bool {
        let after = Duration::try_from(at.duration_since(self.since));
        let is_new = after.is_ok_and(|after| !after.is_zero() && after <= LOOK_LIFETIME);
        is_new || self.held.contains(&id)
    }
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
    /// The database cannot be reached. It may succeed later.
    #[error("the database cannot be reached: {0}")]
    Away(String),
    /// The file cannot be used now. It may succeed later.
    #[error("the store cannot be used now: {0}")]
    Unusable(String),
    /// Anything else.
    #[error("the store failed: {0}")]
    Failed(String),
    /// The store worked, but the computation that needed its records panicked.
    #[error(transparent)]
    Broken(#[from] Broken),
}

impl StoreError {
    /// Returns true if the same may succeed later.
    pub(crate) fn may_pass(&self) -> bool {
        matches!(self, Self::Full(_) | Self::Away(_) | Self::Unusable(_))
    }

    /// What was read makes no sense.
    fn damaged(what: impl Display, reason: impl Display) -> Self {
        Self::Failed(format!("{what} cannot be read: {reason}"))
    }
}

/// Completes when a change is durable, with what has come of it.
pub(crate) type Acknowledgement<T> = BoxFuture<'static, Result<T, StoreError>>;

/// Keeps jobs.
///
/// It promises:
///
/// - **Order.** Changes of a job take effect in the order in which the methods are called, whether or not
///   anybody waits for their acknowledgements.
/// - **Atomicity.** A change happens as a whole or not at all. One that has failed can be asked for again. In a
///   store of one process, a job whose insertion has failed is not there.
/// - **Durability.** A change that was acknowledged survives whatever happens to the process, and in a store
///   on a disk also a loss of power. A crash may lose changes that were not acknowledged yet, of each job
///   the latest ones first. A store in memory ends with the process.
/// - **Reads** see everything that was acknowledged before they were called; [`list`](Self::list) also sees
///   changes that were called before it and are not acknowledged yet. What a read has given stays valid when
///   the job is deleted.
/// - **A job that is gone stays gone.** Changes of a job that is not there succeed, and do nothing.
pub(crate) enum Store {
    /// Of one process.
    Embedded(Embedded),
    /// Of several replicas.
    Shared(Arc<Shared>),
}

/// Where a store is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum StorePlace<'a> {
    /// In the memory of this process.
    Memory,
    /// In a file of this directory.
    Directory(&'a Path),
    /// In the database of this URL.
    Database(&'a str, Settings),
}

impl Store {
    /// Opens the store at this place, or makes it.
    pub(crate) async fn open(place: StorePlace<'_>, counters: Counters) -> Result<Self, OpenError> {
        match place {
            StorePlace::Memory => Embedded::in_memory(counters).map(Self::Embedded),
            StorePlace::Directory(path) => Embedded::open(path, counters).map(Self::Embedded),
            StorePlace::Database(url, settings) => Shared::open(url, settings, counters)
                .await
                .map(Self::Shared),
        }
    }

    /// The store of several replicas, if this is one.
    pub(crate) fn shared(&self) -> Option<&Arc<Shared>> {
        match self {
            Self::Embedded(_) => None,
            Self::Shared(it) => Some(it),
        }
    }

    /// The time by which it is decided when jobs have ended. What ends later has a later time.
    pub(crate) async fn now(&self) -> Result<Timestamp, StoreError> {
        match self {
            Self::Embedded(it) => Ok(it.now()),
            Self::Shared(it) => it.now().await,
        }
    }

    /// The time of a job that ends now, for those who ask for it. A database keeps its own time beside it, by
    /// which jobs are forgotten.
    pub(crate) fn stamp(&self) -> Timestamp {
        match self {
            Self::Embedded(it) => it.stamp(),
            Self::Shared(_) => Timestamp::now(),
        }
    }

    /// What is wrong with the store, if new jobs cannot be kept.
    pub(crate) fn check(&self) -> Result<(), StoreError> {
        match self {
            Self::Embedded(it) => it.check_place(),
            Self::Shared(it) => it.check_reached(),
        }
    }

    /// Keeps a new job, unless there is an entry for the same key, or its tenant would have more than its
    /// quota then. No two insertions together exceed a quota.
    pub(crate) fn insert(
        &self,
        record: Record,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
        quota: Quota,
    ) -> Acknowledgement<Insertion> {
        match self {
            Self::Embedded(it) => it.insert(record, problem, key, quota),
            Self::Shared(it) => it.insert(record, problem, key, quota),
        }
    }

    /// Keeps that a job runs now, and whether it is on probation. False if another replica runs it.
    pub(crate) fn start(
        &self,
        id: Uuid,
        status: Status,
        on_probation: bool,
    ) -> Acknowledgement<bool> {
        match self {
            Self::Embedded(it) => it.start(id, status, on_probation),
            Self::Shared(it) => it.start(id, status, on_probation),
        }
    }

    /// Puts a job back into the queue at an orderly end of the process, and clears its count of crashes.
    pub(crate) fn requeue(&self, id: Uuid) -> Acknowledgement<()> {
        match self {
            Self::Embedded(it) => it.requeue(id),
            Self::Shared(it) => it.requeue(id),
        }
    }

    /// Keeps the final state and control points of a job. False if another replica runs it, or has ended it.
    pub(crate) fn finish(
        &self,
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    ) -> Acknowledgement<bool> {
        match self {
            Self::Embedded(it) => it.finish(id, status, result),
            Self::Shared(it) => it.finish(id, status, result),
        }
    }

    /// Forgets a job and its key; says whether there was one.
    pub(crate) fn remove(&self, id: Uuid) -> Acknowledgement<bool> {
        match self {
            Self::Embedded(it) => it.remove(id),
            Self::Shared(it) => it.remove(id),
        }
    }

    /// Forgets jobs that have ended until the rest is within `retention`, at most [`FORGOTTEN_AT_ONCE`],
    /// and keys that have expired. Spared jobs stay, beyond the retention. Gives the ids of those that
    /// were forgotten.
    pub(crate) fn retain(
        &self,
        retention: Retention,
        spared: Spared,
    ) -> Acknowledgement<Vec<Uuid>> {
        match self {
            Self::Embedded(it) => it.retain(retention, spared),
            Self::Shared(it) => it.retain(retention, spared),
        }
    }

    /// The job of this id.
    pub(crate) async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        match self {
            Self::Embedded(it) => it.get(id).await,
            Self::Shared(it) => it.get(id).await,
        }
    }

    /// The problem of the job of this id.
    pub(crate) async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        match self {
            Self::Embedded(it) => it.problem(id).await,
            Self::Shared(it) => it.problem(id).await,
        }
    }

    /// The geometry of the last level of a job that has ended.
    pub(crate) async fn result(&self, id: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        match self {
            Self::Embedded(it) => it.result(id).await,
            Self::Shared(it) => it.result(id).await,
        }
    }

    /// Jobs, the newest first.
    pub(crate) async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        match self {
            Self::Embedded(it) => it.list(selection).await,
            Self::Shared(it) => it.list(selection).await,
        }
    }

    /// Jobs that have not ended, the oldest first.
    pub(crate) async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        match self {
            Self::Embedded(it) => it.unfinished().await,
            Self::Shared(it) => it.unfinished().await,
        }
    }

    /// The idempotency key of the request that made a job, if it is still remembered.
    pub(crate) async fn key_of(&self, id: Uuid) -> Result<Option<IdempotencyKey>, StoreError> {
        match self {
            Self::Embedded(it) => it.key_of(id).await,
            Self::Shared(it) => it.key_of(id).await,
        }
    }

    /// The secret of all servers with this store: the one that it keeps, or this one, which it then keeps.
    pub(crate) async fn secret(&self, new: Secret) -> Result<Secret, StoreError> {
        match self {
            Self::Embedded(it) => it.secret(new).await,
            Self::Shared(it) => it.secret(new).await,
        }
    }

    /// What is remembered of an idempotency key.
    pub(crate) async fn idempotency_entry(
        &self,
        key: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        match self {
            Self::Embedded(it) => it.idempotency_entry(key).await,
            Self::Shared(it) => it.idempotency_entry(key).await,
        }
    }
}

/// Returns true if it was longer ago than this. A time in the future is not: a clock that was ahead must not
/// make anything be forgotten.
fn is_older(at: Timestamp, age: Duration, now: Timestamp) -> bool {
    let passed = now.duration_since(at);
    Duration::try_from(passed).is_ok_and(|passed| passed > age)
}

#[cfg(test)]
mod tests;
