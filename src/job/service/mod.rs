//! All jobs of a server: creating, finding, listing, cancelling and deleting them.
//!
//! - [`creating`]: accepts jobs; [`refused`]: reasons to refuse them; [`batch`]: the slot of many fits in one request;
//! - `lifecycle`: drives a job from the queue to its end;
//! - `replicas`: cooperation with other replicas.

pub(crate) mod batch;
pub(crate) mod creating;
pub(crate) mod ephemeral;
mod lifecycle;
pub(crate) mod refused;
mod replicas;
pub(crate) mod sessions;

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Weak};
use std::time::Duration;

use parking_lot::Mutex;
use tokio::sync::Notify;
use tokio::time::{sleep, timeout};
use tracing::{error, info};
use uuid::Uuid;

use super::Job;
use super::memory::Share;
use super::peer::Peer;
use super::probation::{LargeBody, Probation};
use super::recent::Recent;
use super::replay::Replays;
use super::resources::Resources;
use super::scheduler::{QUICK, WorkLane};
use super::slots::{PerPeer, Slots};
use super::store::{FORGOTTEN_AT_ONCE, Record, Retention, Selection, Spared, Store, StoreError};
use piad_fit::engine::Admission;
use sessions::Sessions;

/// The longest time between two searches for expired jobs.
const MOST_AGE_CHECK: Duration = Duration::from_secs(60);

/// How long to wait after a job has ended before old ones are removed: others may end with it.
const RETENTION_PAUSE: Duration = Duration::from_millis(50);

/// The interval at which jobs that were in use are checked again.
const SPARED_CHECK: Duration = Duration::from_secs(1);

/// The most multiplications of an iteration; they take a second or two.
const MOST_OF_A_STEP: usize = 2_000_000_000;

/// The most multiplications before the first iteration. They have the long lane and take some seconds.
const MOST_OF_A_START: usize = 20_000_000_000;

/// The number of attempts to find a job that is in the store and not in memory, or may be deleted meanwhile.
const LOOKS: usize = 16;

/// How long a deletion waits for the end of a job that other replicas may know of.
const MOST_WAITING: Duration = Duration::from_secs(5);

/// Limits of the jobs of a server.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JobLimits {
    /// Bytes of jobs that have just ended and stay in memory.
    pub recent: usize,
    /// Jobs that have not ended.
    pub jobs: usize,
    /// Jobs of a single peer that have not ended.
    pub jobs_of_a_peer: PerPeer,
    /// The retention of ended jobs.
    pub retention: Retention,
}

/// The jobs of a server.
pub(crate) struct Jobs {
    store: Arc<Store>,
    resources: Arc<Resources>,
    /// The runs that recompute.
    replays: Arc<Replays>,
    limits: JobLimits,
    /// For the one job that is on probation after a crash.
    probation: Probation,
    /// For jobs that have not ended.
    slots: Arc<Slots>,
    /// The process is about to end: running jobs go back to the queue.
    suspended: AtomicBool,
    recent: Recent,
    /// Notified when a job has ended.
    ended: Arc<Notify>,
    /// The number of deletions of jobs.
    deletions: AtomicUsize,
    /// Jobs in memory: those that run and those that are read.
    live: Mutex<HashMap<Uuid, Weak<Job>>>,
    /// Open drags.
    sessions: Sessions,
}

impl Jobs {
    /// The jobs of a store.
    pub(crate) fn new(store: Arc<Store>, resources: Arc<Resources>, limits: JobLimits) -> Self {
        let cache = Arc::clone(&resources.memory.cache);
        Self {
            store,
            resources,
            replays: Arc::default(),
            limits,
            probation: Probation::default(),
            slots: Slots::new(limits.jobs, limits.jobs_of_a_peer),
            suspended: AtomicBool::new(false),
            recent: Recent::new(limits.recent, cache),
            ended: Arc::default(),
            deletions: AtomicUsize::new(0),
            live: Mutex::default(),
            sessions: Sessions::default(),
        }
    }

    /// The shared resources of jobs.
    pub(crate) fn resources(&self) -> &Arc<Resources> {
        &self.resources
    }

    /// The limits of a fit: no more memory than the share that it would run in, and no steps so long that others, and
    /// clients that cancel it, would wait for seconds.
    pub(crate) fn admission(&self) -> Admission {
        let memory = &self.resources.memory;
        Admission {
            quick: memory.quick.bytes(),
            heavy: memory.heavy.bytes(),
            small_step: QUICK,
            step: MOST_OF_A_STEP,
            start: MOST_OF_A_START,
        }
    }

    /// Waits until no job is on probation, before a large body is read.
    pub(crate) async fn read_large_body(&self) -> LargeBody {
        self.probation.read_large_body().await
    }

    /// The number of jobs that wait for their turn.
    pub(crate) fn queued(&self) -> usize {
        let running = self.resources.counters.running();
        self.slots.taken().saturating_sub(running)
    }

    /// The error of the store, if new jobs cannot be stored.
    pub(crate) fn check_store(&self) -> Result<(), StoreError> {
        self.store.check()
    }

    /// Connections with the database of the store that are open, and those that are in use.
    pub(crate) fn store_connections(&self) -> Option<(usize, usize)> {
        self.store.shared().map(|shared| shared.open_connections())
    }

    /// Queues the jobs that had not ended when the process did, and removes old jobs from now on. With other
    /// replicas, takes part in their work.
    pub(crate) async fn resume(self: &Arc<Self>) -> Result<(), StoreError> {
        match self.store.shared() {
            Some(shared) => self.join(shared),
            None => self.resume_unfinished().await?,
        }
        tokio::spawn(Self::retain_periodically(Arc::downgrade(self)));
        Ok(())
    }

    async fn resume_unfinished(self: &Arc<Self>) -> Result<(), StoreError> {
        let mut unfinished = self.store.unfinished().await?;
        // The quickest first, as they end soonest.
        unfinished.sort_by_key(|record| (record.crashes, record.outline.step_cost));
        if !unfinished.is_empty() {
            info!(count = unfinished.len(), "unfinished jobs continue");
        }
        for record in unfinished {
            let job = self.bring_to_life(record, None, false);
            let slot = self.slots.occupy();
            self.start_driving(job, None, slot);
        }
        Ok(())
    }

    /// Removes expired jobs after others have ended, after some time, and when they are released.
    async fn retain_periodically(jobs: Weak<Self>) {
        while let Some(strong) = jobs.upgrade() {
            let spared = strong.retain().await;
            let age = strong.limits.retention.age;
            let ended = Arc::clone(&strong.ended);
            drop(strong);
            let released = async {
                // A commit takes longer than a check of the jobs in memory.
                while !spared.is_empty() {
                    sleep(SPARED_CHECK).await;
                    let Some(strong) = jobs.upgrade() else { return };
                    if !spared.is_subset(&strong.held()) {
                        return;
                    }
                }
                std::future::pending().await
            };
            tokio::select! {
                () = ended.notified() => {}
                () = sleep((age / 4).clamp(RETENTION_PAUSE, MOST_AGE_CHECK)) => {}
                () = released => {}
            }
            // Many jobs may end at about the same time.
            sleep(RETENTION_PAUSE).await;
        }
    }

    /// Puts running jobs back into the queue for the next start of the server.
    pub(crate) async fn suspend(&self) {
        self.suspended.store(true, Ordering::Release);
        let live: Vec<_> = self
            .live
            .lock()
            .values()
            .filter_map(Weak::upgrade)
            .collect();
        for job in live {
            job.suspend();
        }
        // Jobs stop after their current step, which takes a few seconds at most.
        while self.slots.taken() > 0 {
            sleep(Duration::from_millis(1)).await;
        }
    }

    /// The job of this id.
    pub(crate) async fn find(&self, id: Uuid) -> Result<Option<Arc<Job>>, StoreError> {
        if let Some(shared) = self.store.shared() {
            return self.find_among_replicas(shared, id).await;
        }
        for _ in 0..LOOKS {
            if let Some(job) = self.live(id) {
                return Ok(Some(job));
            }
            let deletions = self.deletions.load(Ordering::Acquire);
            match self.store.get(id).await? {
                None => return Ok(None),
                Some(record) if record.status.state.is_final() => {
                    let job = self.bring_to_life(record, None, false);
                    if self.deletions.load(Ordering::Acquire) == deletions {
                        return Ok(Some(job));
                    }
                    // It may have been deleted before it was loaded.
                    self.live.lock().remove(&id);
                }
                // It ended between the two look-ups; the next look-up in the store finds it ended.
                Some(_) => {}
            }
        }
        // It was refused, and is about to be removed from the store.
        Ok(None)
    }

    /// Jobs, the newest first.
    pub(crate) async fn list(&self, selection: Selection) -> Result<Vec<Arc<Job>>, StoreError> {
        let mut jobs = Vec::new();
        for record in self.store.list(selection).await? {
            // In a store of one process, an unfinished job is in memory, or has just ended.
            let is_complete = record.status.state.is_final() || self.store.shared().is_some();
            let live = self.live(record.outline.id);
            // The answer to the end of one that runs here may be on its way.
            if let Some(job) = &live {
                job.follow(record.status.clone());
            }
            let job = match is_complete {
                true => Some(live.unwrap_or_else(|| self.job(record, None, true))),
                false => self.find(record.outline.id).await?,
            };
            jobs.extend(job);
        }
        Ok(jobs)
    }

    /// Deletes a job, and cancels it first if it has not ended; returns whether there was one.
    pub(crate) async fn delete(&self, id: Uuid) -> Result<bool, StoreError> {
        let job = match self.store.shared() {
            Some(shared) => self.find_among_replicas(shared, id).await?,
            None => self.live(id),
        };
        if let Some(job) = job {
            job.request_cancel();
            // Another replica may end its job only after it was removed, and not without the database.
            if self.store.shared().is_some() {
                let _ = timeout(MOST_WAITING, job.ended()).await;
            } else {
                job.ended().await;
            }
        }
        let existed = self.store.remove(id).await?;
        self.forget(&[id]);
        Ok(existed)
    }

    /// Drops jobs that are no longer in the store. Holders of them can still use them.
    fn forget(&self, ids: &[Uuid]) {
        self.deletions.fetch_add(1, Ordering::AcqRel);
        for id in ids {
            self.recent.forget(*id);
            self.live.lock().remove(id);
        }
    }

    fn live(&self, id: Uuid) -> Option<Arc<Job>> {
        self.live.lock().get(&id).and_then(Weak::upgrade)
    }

    /// The [`Job`] of a record, which is computed for this peer, or by another replica. There is only one in
    /// memory, which all share.
    fn bring_to_life(&self, record: Record, peer: Option<Peer>, elsewhere: bool) -> Arc<Job> {
        let mut live = self.live.lock();
        let id = record.outline.id;
        if let Some(job) = live.get(&id).and_then(Weak::upgrade) {
            return job;
        }
        let job = self.job(record, peer, elsewhere);
        if live.len() == live.capacity() {
            live.retain(|_, job| job.strong_count() > 0);
        }
        live.insert(id, Arc::downgrade(&job));
        job
    }

    /// The shared resources, for each job.
    fn shared(&self) -> (Arc<Resources>, Arc<Replays>) {
        (Arc::clone(&self.resources), Arc::clone(&self.replays))
    }

    fn job(&self, record: Record, peer: Option<Peer>, elsewhere: bool) -> Arc<Job> {
        let store = Some(Arc::clone(&self.store));
        let job = Job::new(record, store, peer, self.shared());
        job.elsewhere.store(elsewhere, Ordering::Release);
        Arc::new(job)
    }

    /// The share of the memory that a fit with steps of this cost is run in.
    fn share(&self, step_cost: usize) -> &Share {
        let memory = &self.resources.memory;
        match WorkLane::of(step_cost) {
            WorkLane::Quick => &memory.quick,
            _ => &memory.heavy,
        }
    }

    /// Jobs that are read, that run, or whose request is not answered yet.
    fn held(&self) -> HashSet<Uuid> {
        self.recent.held(&self.live)
    }

    /// Removes jobs that are beyond the retention and not in use; returns those that are in use.
    async fn retain(&self) -> HashSet<Uuid> {
        loop {
            // Jobs that end from here on may be in use.
            let since = match self.store.now().await {
                Ok(since) => since,
                Err(error) => {
                    error!(%error, "expired jobs could not be searched for");
                    return self.held();
                }
            };
            let held = self.held();
            let spared = Spared {
                held: held.clone(),
                since,
            };
            let retained = self.store.retain(self.limits.retention, spared);
            match retained.await {
                Ok(forgotten) => {
                    self.forget(&forgotten);
                    if forgotten.len() < FORGOTTEN_AT_ONCE {
                        return held;
                    }
                }
                Err(error) => {
                    error!(%error, "old jobs could not be removed");
                    return held;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
