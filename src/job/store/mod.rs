//! Where jobs are kept: their problems, states and final control points. Frames are not kept.
//!
//! - [`embedded`]: in a file or in the memory of one process; [`shared`]: in PostgreSQL, for any number of
//!   replicas;
//! - `kept`: what is kept of a job, and what is asked for; [`record`]: its bytes; `error`: what can go wrong;
//! - [`crash_recovery`]: what becomes of jobs that were running in a crash;
//! - [`copy`]: from one store to another.

pub(crate) mod copy;
pub(crate) mod crash_recovery;
pub(crate) mod embedded;
mod error;
#[cfg(any(test, fuzzing))]
pub(crate) mod fuzzing;
mod kept;
mod record;
pub(crate) mod shared;

use std::path::Path;
use std::sync::Arc;

use jiff::Timestamp;
use uuid::Uuid;

use super::counters::Counters;
use super::quota::Quota;
use super::result::LastGeometry;
use super::state::Status;
use embedded::Embedded;
use piad_fit::engine::Problem;
use shared::{Settings, Shared};

pub(crate) use embedded::open_error::OpenError;
pub(crate) use error::Acknowledgement;
pub(crate) use error::StoreError;
pub(crate) use kept::{
    FORGOTTEN_AT_ONCE, IdempotencyEntry, IdempotencyKey, Insertion, KEY_LIFETIME, LOOK_LIFETIME,
    Record, Retention, Secret, Selection, Spared,
};

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

#[cfg(test)]
mod tests;
