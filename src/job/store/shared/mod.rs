//! The store of several replicas: a PostgreSQL database, which keeps each job, its points and its key in one
//! transaction.
//!
//! - [`connection`]: connections, and statements that are run again when one breaks;
//! - [`opening`]: opens the database, and migrates its schema;
//! - [`writes`]: changes of a job; [`within`]: new ones within a quota; [`reads`]: reads of one;
//!   [`chunked_value`]: long values;
//! - [`order`]: changes of one job, one after the other;
//! - [`leases`]: which replica runs a job, and recovery of the jobs of a dead one;
//! - [`hints`], [`notifications`]: notifications between replicas.
//!
//! A job that runs is claimed by a replica, with a number that grows with each claim, its epoch. Writes of a replica
//! carry the epoch of its claim; once another replica has claimed the job, they change nothing. So it does no harm when
//! two replicas believe that they run a job: both compute the same, and the database accepts the end of one.

mod chunked_value;
mod connection;
pub(crate) mod hints;
mod leases;
mod notifications;
mod opening;
mod order;
mod reads;
mod within;
mod writes;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use sqlx::postgres::PgConnectOptions;
use tokio::sync::mpsc;
use uuid::Uuid;

use super::{
    Acknowledgement, IdempotencyEntry, IdempotencyKey, Insertion, Record, Retention, Secret,
    Selection, Spared, StoreError,
    record::{self, Input},
};
use crate::job::counters::Counters;
use crate::job::quota::Quota;
use crate::job::result::LastGeometry;
use crate::job::state::Status;
use chunked_value::Table;
use connection::Connections;
use hints::Hint;
use order::Order;
use piad_fit::engine::Problem;

/// The store of several replicas, as one of them sees it.
pub(crate) struct Shared {
    options: PgConnectOptions,
    lease: Duration,
    connections: Connections,
    /// The name of this replica, new with each start.
    replica: Uuid,
    /// The jobs that this replica runs.
    claims: Mutex<HashMap<Uuid, Claim>>,
    order: Arc<Order>,
    /// The hints to send to the other replicas.
    hint_sender: mpsc::Sender<Hint>,
    counters: Counters,
}

/// Settings of a replica.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// The most connections, besides the one that listens.
    pub(crate) connections: usize,
    /// How long a replica is assumed to run a job after its last renewal.
    pub(crate) lease: Duration,
}

/// A claim of a job.
#[derive(Clone, Copy, Debug)]
struct Claim {
    epoch: i64,
    /// The lease is at least as long as if it had begun here.
    renewed: Instant,
    /// Another replica has claimed the job since.
    lost: bool,
    /// Its end is being written, or has been, and the answer is not there yet.
    ends: bool,
}

impl Shared {
    /// Returns true if this replica runs a job, and no other one can know anything else of it.
    pub(crate) fn surely_runs(&self, id: Uuid) -> bool {
        let claims = self.claims.lock();
        let holds = |it: &Claim| !it.lost && !it.ends && it.renewed.elapsed() < self.lease;
        claims.get(&id).is_some_and(holds)
    }

    /// See [`super::Store::check`].
    pub(super) fn check_reached(&self) -> Result<(), StoreError> {
        if self.connections.is_away() {
            let reason = "the last statements have had no answer".to_owned();
            return Err(StoreError::Away(reason));
        }
        Ok(())
    }

    /// Connections that are open, and those of them that are in use.
    pub(crate) fn open_connections(&self) -> (usize, usize) {
        self.connections.open()
    }

    /// See [`super::Store::insert`].
    pub(super) fn insert(
        self: &Arc<Self>,
        record: Record,
        problem: Arc<Problem>,
        key: Option<IdempotencyKey>,
        quota: Quota,
    ) -> Acknowledgement<Insertion> {
        self.change(record.outline.id, async move |store| {
            let input = blocking(move || Input::new(&problem)?.to_bytes()).await?;
            store.write_job(&record, &input, key.as_ref(), &quota).await
        })
    }

    /// See [`super::Store::start`].
    pub(super) fn start(
        self: &Arc<Self>,
        id: Uuid,
        status: Status,
        on_probation: bool,
    ) -> Acknowledgement<bool> {
        self.change(id, async move |store| {
            store.write_start(id, &status, on_probation).await
        })
    }

    /// See [`super::Store::requeue`].
    pub(super) fn requeue(self: &Arc<Self>, id: Uuid) -> Acknowledgement<()> {
        self.change(id, async move |store| store.write_requeue(id).await)
    }

    /// See [`super::Store::finish`].
    pub(super) fn finish(
        self: &Arc<Self>,
        id: Uuid,
        status: Status,
        result: Option<LastGeometry>,
    ) -> Acknowledgement<bool> {
        self.change(id, async move |store| {
            let result = blocking(move || result.as_ref().map(record::geometry).transpose());
            let result = result.await?;
            store.write_end(id, &status, result.as_deref()).await
        })
    }

    /// See [`super::Store::remove`].
    pub(super) fn remove(self: &Arc<Self>, id: Uuid) -> Acknowledgement<bool> {
        self.change(id, async move |store| store.delete(id).await)
    }

    /// See [`super::Store::retain`].
    pub(super) fn retain(
        self: &Arc<Self>,
        retention: Retention,
        spared: Spared,
    ) -> Acknowledgement<Vec<Uuid>> {
        let store = Arc::clone(self);
        Box::pin(async move { store.delete_surplus(retention, &spared).await })
    }

    /// See [`super::Store::get`].
    pub(crate) async fn get(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        Ok(self.records(&[id]).await?.pop())
    }

    /// See [`super::Store::problem`].
    pub(super) async fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        match self.value(Table::Inputs, id).await? {
            Some(bytes) => {
                blocking(move || record::problem(id, &bytes).map(Arc::new).map(Some)).await
            }
            None => Ok(None),
        }
    }

    /// See [`super::Store::result`].
    pub(super) async fn result(&self, id: Uuid) -> Result<Option<LastGeometry>, StoreError> {
        match self.value(Table::Results, id).await? {
            Some(bytes) => blocking(move || record::result(id, &bytes).map(Some)).await,
            None => Ok(None),
        }
    }

    /// See [`super::Store::list`].
    pub(super) async fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        self.order.all_done().await;
        self.read_list(selection).await
    }

    /// See [`super::Store::unfinished`].
    pub(super) async fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        self.read_unfinished().await
    }

    /// See [`super::Store::key_of`].
    pub(super) async fn key_of(&self, id: Uuid) -> Result<Option<IdempotencyKey>, StoreError> {
        self.read_key(id).await
    }

    /// See [`super::Store::idempotency_entry`].
    pub(super) async fn idempotency_entry(
        &self,
        name: &str,
    ) -> Result<Option<IdempotencyEntry>, StoreError> {
        self.read_entry(name).await
    }

    /// See [`super::Store::secret`].
    pub(super) async fn secret(&self, new: Secret) -> Result<Secret, StoreError> {
        self.keep_secret(new).await
    }

    /// A change of a job, which is queued behind earlier ones, and is done whether or not its result is awaited.
    fn change<T, F>(
        self: &Arc<Self>,
        id: Uuid,
        change: impl FnOnce(Arc<Self>) -> F,
    ) -> Acknowledgement<T>
    where
        T: Send + 'static,
        F: Future<Output = Result<T, StoreError>> + Send + 'static,
    {
        let mut place = self.order.place(id);
        let change = change(Arc::clone(self));
        let done = tokio::spawn(async move {
            place.come().await;
            change.await
        });
        Box::pin(async move { done.await.unwrap_or_else(|error| Err(broken(error))) })
    }
}

/// Runs work that may take a while off the network threads.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, StoreError> + Send + 'static,
) -> Result<T, StoreError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.unwrap_or_else(|error| Err(broken(error)))
}

fn broken(error: tokio::task::JoinError) -> StoreError {
    StoreError::Failed(error.to_string())
}
