//! One replica among several: it renews the leases of its jobs, follows jobs of others that are read here, and takes
//! over jobs that wait for a replica with room.
//!
//! A job that waits is in the queue of the replica that has accepted it, and in the store. The first replica with room
//! for it claims it and starts it; so an idle replica looks for jobs that wait elsewhere.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval, sleep};
use tracing::debug;
use uuid::Uuid;

use super::Jobs;
use crate::job::Job;
use crate::job::state::{State, Status};
use crate::job::store::shared::Shared;
use crate::job::store::shared::hints::Hint;
use crate::job::store::{Record, StoreError};

/// The polling interval of the store without a hint.
const LOOK: Duration = Duration::from_secs(1);

/// The most jobs of others that are taken over at once.
const TAKEN_AT_ONCE: usize = 16;

impl Jobs {
    /// Cooperates with the other replicas from now on.
    pub(super) fn join(self: &Arc<Self>, shared: &Arc<Shared>) {
        tokio::spawn(keep_leases(Arc::downgrade(self), Arc::clone(shared)));
        tokio::spawn(look(Arc::downgrade(self), Arc::clone(shared)));
    }

    /// The job of this id, on any replica.
    pub(super) async fn find_among_replicas(
        &self,
        shared: &Shared,
        id: Uuid,
    ) -> Result<Option<Arc<Job>>, StoreError> {
        let live = self.live(id);
        // This replica knows the jobs that it runs best, as long as its lease holds.
        if let Some(job) = &live
            && !job.is_elsewhere()
            && shared.surely_runs(id)
        {
            return Ok(live);
        }
        let record = match shared.get(id).await {
            Ok(Some(record)) if live.is_none() && !record.status.state.is_final() => {
                shared.follow(id).await
            }
            record => record,
        };
        match record {
            Ok(Some(record)) => {
                let status = record.status.clone();
                let job = live.unwrap_or_else(|| self.bring_to_life(record, None, true));
                job.follow(status);
                Ok(Some(job))
            }
            Ok(None) => {
                if let Some(job) = live {
                    self.let_go(&job);
                }
                Ok(None)
            }
            // Ended jobs can be read while the database is away, if they are in memory.
            Err(error) => match live.filter(|job| job.status().state.is_final()) {
                Some(job) => Ok(Some(job)),
                None => Err(error),
            },
        }
    }

    /// Ends a job that this replica runs.
    fn end_here(&self, id: Uuid) {
        if let Some(job) = self.live(id).filter(|job| !job.is_elsewhere()) {
            job.request_cancel();
        }
    }

    /// The status of a job that this replica runs, with the level that it has reached.
    fn running_here(&self, id: Uuid) -> Option<Status> {
        let job = self.live(id).filter(|job| !job.is_elsewhere())?;
        Some(job.status()).filter(|status| status.state == State::Running)
    }

    /// The jobs that others run and that are read here.
    fn followed(&self) -> Vec<Arc<Job>> {
        let live = self.live.lock();
        let jobs = live.values().filter_map(Weak::upgrade);
        let is_followed = |job: &Arc<Job>| job.is_elsewhere() && !job.status().state.is_final();
        jobs.filter(is_followed).collect()
    }

    /// Polls the store for jobs that others run.
    pub(super) async fn refresh(
        &self,
        shared: &Shared,
        jobs: Vec<Arc<Job>>,
    ) -> Result<(), StoreError> {
        if jobs.is_empty() {
            return Ok(());
        }
        let ids: Vec<Uuid> = jobs.iter().map(|job| job.id()).collect();
        let mut records = shared.records(&ids).await?;
        for job in jobs {
            let place = records.iter().position(|it| it.outline.id == job.id());
            match place.map(|place| records.swap_remove(place)) {
                Some(record) => job.follow(record.status),
                None => self.let_go(&job),
            }
        }
        Ok(())
    }

    /// A job that is not in the store any more, or never was: its end is published.
    pub(super) fn let_go(&self, job: &Job) {
        job.follow(Status {
            state: State::Cancelled,
            ..job.status()
        });
        self.forget(&[job.id()]);
    }

    /// Publishes the status of a job that readers have found in the store, although the answer that it was stored was
    /// lost.
    pub(super) fn follow_abandoned(self: &Arc<Self>, shared: Arc<Shared>, job: &Arc<Job>) {
        job.elsewhere.store(true, Ordering::Release);
        let (jobs, job) = (Arc::downgrade(self), Arc::downgrade(job));
        tokio::spawn(async move {
            while let (Some(jobs), Some(job)) = (jobs.upgrade(), job.upgrade())
                && !job.status().state.is_final()
            {
                if let Err(error) = jobs.refresh(&shared, vec![job]).await {
                    debug!(%error, "the jobs of other replicas could not be read");
                }
                drop(jobs);
                sleep(LOOK).await;
            }
        });
    }

    /// A job has ended, or was deleted, at this replica or at another one.
    async fn has_ended(&self, shared: &Shared, id: Uuid) -> Result<(), StoreError> {
        let Some(job) = self.live(id).filter(|job| !job.status().state.is_final()) else {
            return Ok(());
        };
        if job.is_elsewhere() {
            return self.refresh(shared, vec![job]).await;
        }
        // A job that this replica has ended is reported in a moment; one that was cancelled or deleted elsewhere need
        // not wait or run any longer.
        job.request_cancel();
        Ok(())
    }

    /// Takes over jobs that wait at other replicas, or whose replica is dead, if there is room for them.
    async fn take_over(self: &Arc<Self>, shared: &Shared) -> Result<(), StoreError> {
        // A replica where jobs wait has no room.
        if self.suspended.load(Ordering::Acquire) || self.queued() > 0 {
            return Ok(());
        }
        for record in shared.waiting(TAKEN_AT_ONCE).await? {
            let share = self.share(record.outline.step_cost);
            if share.take_at_once(None, record.outline.memory).is_some() {
                self.drive_waiting(record);
            }
        }
        Ok(())
    }

    /// Queues a job that waits in the store.
    fn drive_waiting(self: &Arc<Self>, record: Record) {
        let job = self.bring_to_life(record, None, true);
        // If it was here already, it may wait in the queue.
        if job.elsewhere.swap(false, Ordering::AcqRel) {
            let slot = self.slots.occupy();
            self.start_driving(job, None, slot);
        }
    }
}

/// Renews the leases of this replica's jobs, and puts those of dead replicas back into the queue.
async fn keep_leases(jobs: Weak<Jobs>, shared: Arc<Shared>) {
    loop {
        sleep(shared.heartbeat()).await;
        let Some(jobs) = jobs.upgrade() else { return };
        match shared.renew(|id| jobs.running_here(id)).await {
            Ok(ended) => ended.into_iter().for_each(|id| jobs.end_here(id)),
            Err(error) => debug!(%error, "leases could not be renewed"),
        }
        drop(jobs);
        if let Err(error) = shared.release_unknown().await {
            debug!(%error, "jobs whose acknowledgement was lost could not be searched for");
        }
        if let Err(error) = shared.recover().await {
            debug!(%error, "jobs of dead replicas could not be searched for");
        }
    }
}

/// Polls the other replicas' changes from time to time, and at their hints.
async fn look(jobs: Weak<Jobs>, shared: Arc<Shared>) {
    let mut hints = shared.hints();
    let mut ticks = interval(LOOK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let hint = tokio::select! {
            hint = hints.recv() => hint,
            _ = ticks.tick() => None,
        };
        let Some(jobs) = jobs.upgrade() else { return };
        let done = match hint {
            Some(Hint::Queued) => jobs.take_over(&shared).await,
            Some(Hint::Cancel(id)) => {
                jobs.end_here(id);
                Ok(())
            }
            Some(Hint::Started(id)) => {
                let followed = jobs.live(id).filter(|job| job.is_elsewhere());
                jobs.refresh(&shared, followed.into_iter().collect()).await
            }
            Some(Hint::Ended(id) | Hint::Deleted(id)) => jobs.has_ended(&shared, id).await,
            None => match jobs.refresh(&shared, jobs.followed()).await {
                Ok(()) => jobs.take_over(&shared).await,
                error => error,
            },
        };
        if let Err(error) = done {
            debug!(%error, "the jobs of other replicas could not be read");
        }
    }
}
