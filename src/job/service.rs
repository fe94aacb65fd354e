//! All jobs of a server: creating, finding, listing, cancelling and deleting them.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Weak};

use jiff::Timestamp;
use parking_lot::Mutex;
use thiserror::Error;
use tokio::sync::{Semaphore, SemaphorePermit};
use tracing::{error, info};
use uuid::Uuid;

use super::Job;
use super::frame::Frame;
use super::run::Ending;
use super::scheduler::{Lane, Scheduler};
use super::state::{Failure, Reason, State, Status};
use super::store::{Record, Retention, Selection, Store, StoreError};
use crate::fit::iteration::Outcome;
use crate::fit::problem::Problem;

/// The unit in which memory is handed out.
const PAGE: usize = 4096;

/// Limits of the jobs of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bytes that running jobs may take together.
    pub memory: usize,
    /// Jobs that have not ended.
    pub jobs: usize,
    /// Bytes of recent frames that each run keeps.
    pub ring_bytes: usize,
    /// What is kept of jobs that have ended.
    pub retention: Retention,
}

/// Why a job was not accepted.
#[derive(Clone, Debug, Error)]
pub enum Refused {
    /// There are as many unfinished jobs as are allowed.
    #[error("{limit} jobs are unfinished, the limit of this server")]
    Full {
        /// The limit.
        limit: usize,
    },
    /// It needs more memory than all jobs together may have.
    #[error("the fit needs {needed} bytes of memory, and all fits together may take {limit}")]
    TooLarge {
        /// Bytes needed.
        needed: usize,
        /// The limit in bytes.
        limit: usize,
    },
    /// It could not be kept.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// The jobs of a server.
pub struct Jobs {
    store: Arc<dyn Store>,
    scheduler: Arc<Scheduler>,
    limits: Limits,
    /// Memory for jobs on the heavy and on the quick lane, in pages. A quarter is kept for the
    /// quick ones, so that none of them waits for a large one.
    heavy: Semaphore,
    quick: Semaphore,
    unfinished: AtomicUsize,
    /// Jobs that somebody holds: those that run and those that are read.
    live: Mutex<HashMap<Uuid, Weak<Job>>>,
}

impl Jobs {
    /// No jobs but those in the store.
    pub fn new(store: Arc<dyn Store>, scheduler: Arc<Scheduler>, limits: Limits) -> Self {
        let pages = (limits.memory / PAGE).min(Semaphore::MAX_PERMITS);
        Self {
            store,
            scheduler,
            limits,
            heavy: Semaphore::new(pages - pages / 4),
            quick: Semaphore::new(pages / 4),
            unfinished: AtomicUsize::new(0),
            live: Mutex::default(),
        }
    }

    /// The compute pool.
    pub fn scheduler(&self) -> &Arc<Scheduler> {
        &self.scheduler
    }

    /// Accepts a job and starts it.
    pub async fn create(
        self: &Arc<Self>,
        name: Option<String>,
        problem: Problem,
    ) -> Result<Arc<Job>, Refused> {
        self.admit(&problem)?;
        let place = Place::take(self)?;
        let record = Record {
            id: Uuid::now_v7(),
            name,
            created: Timestamp::now(),
            problem: Arc::new(problem),
            status: Status::QUEUED,
            result: None,
        };
        // Alive before it is stored: whoever finds it in the store finds it alive.
        let job = self.bring_to_life(record.clone());
        self.store.insert(record).await?;
        info!(job = %job.id(), points = job.problem().grid().count(), "job accepted");
        tokio::spawn(Arc::clone(self).drive(Arc::clone(&job), place));
        Ok(job)
    }

    /// The job of this id.
    pub async fn find(&self, id: Uuid) -> Result<Option<Arc<Job>>, StoreError> {
        loop {
            if let Some(job) = self.live(id) {
                return Ok(Some(job));
            }
            match self.store.get(id).await? {
                None => return Ok(None),
                Some(record) if record.status.state.is_final() => {
                    return Ok(Some(self.bring_to_life(record)));
                }
                // It ended between the two look-ups: what the store has now is final.
                Some(_) => {}
            }
        }
    }

    /// Jobs, the newest first.
    pub async fn list(&self, selection: Selection) -> Result<Vec<Arc<Job>>, StoreError> {
        let mut jobs = Vec::new();
        for record in self.store.list(selection).await? {
            let job = match record.status.state.is_final() {
                true => Some(self.bring_to_life(record)),
                false => self.find(record.id).await?,
            };
            jobs.extend(job);
        }
        Ok(jobs)
    }

    /// Forgets a job, and ends it first if it has not ended; says whether there was one.
    pub async fn delete(&self, id: Uuid) -> Result<bool, StoreError> {
        if let Some(job) = self.live(id) {
            job.request_cancel();
            job.ended().await;
        }
        let existed = self.store.remove(id).await?;
        self.live.lock().remove(&id);
        Ok(existed)
    }

    fn live(&self, id: Uuid) -> Option<Arc<Job>> {
        self.live.lock().get(&id).and_then(Weak::upgrade)
    }

    /// The one [`Job`] of a record, which all who deal with it share.
    fn bring_to_life(&self, record: Record) -> Arc<Job> {
        let mut live = self.live.lock();
        let id = record.id;
        if let Some(job) = live.get(&id).and_then(Weak::upgrade) {
            return job;
        }
        let job = Arc::new(Job::new(
            record,
            Arc::clone(&self.scheduler),
            self.limits.ring_bytes,
        ));
        live.retain(|_, job| job.strong_count() > 0);
        live.insert(id, Arc::downgrade(&job));
        job
    }

    /// Refuses what can never run.
    fn admit(&self, problem: &Problem) -> Result<(), Refused> {
        let (_, pages) = self.budget(problem);
        let available = match Lane::of(problem.step_cost()) {
            Lane::Quick => self.limits.memory / PAGE / 4,
            Lane::Heavy => self.limits.memory / PAGE - self.limits.memory / PAGE / 4,
        };
        if pages as usize > available {
            return Err(Refused::TooLarge {
                needed: problem.memory(),
                limit: available * PAGE,
            });
        }
        Ok(())
    }

    /// Which memory a problem takes, and how many pages of it.
    fn budget(&self, problem: &Problem) -> (&Semaphore, u32) {
        let pages = problem.memory().div_ceil(PAGE);
        let memory = match Lane::of(problem.step_cost()) {
            Lane::Quick => &self.quick,
            Lane::Heavy => &self.heavy,
        };
        (memory, u32::try_from(pages).unwrap_or(u32::MAX))
    }

    /// Takes a job from `queued` to its end.
    async fn drive(self: Arc<Self>, job: Arc<Job>, place: Place) {
        let (ending, last) = tokio::select! {
            biased;
            () = job.cancel_requested() => (Ending::Stopped, None),
            memory = self.memory_for(&job) => self.run(&job, memory).await,
        };
        let (state, reason, failure) = verdict(ending);
        let status = Status {
            state,
            finished: Some(Timestamp::now()),
            reason,
            failure,
            ..job.status()
        };
        let result = last.map(|frame| Arc::clone(&frame.control_points));
        if let Some(points) = &result {
            let _ = job.result.set(Arc::clone(points));
        }
        if let Err(error) = self.store.finish(job.id(), status.clone(), result).await {
            error!(job = %job.id(), %error, "the end of a job could not be stored");
        }
        info!(job = %job.id(), %state, "job ended");
        drop(place);
        job.status.send_replace(status);
        if let Err(error) = self.store.retain(self.limits.retention).await {
            error!(%error, "old jobs could not be removed");
        }
    }

    async fn memory_for(&self, job: &Job) -> Option<SemaphorePermit<'_>> {
        let (memory, pages) = self.budget(job.problem());
        memory.acquire_many(pages).await.ok()
    }

    async fn run(
        &self,
        job: &Job,
        memory: Option<SemaphorePermit<'_>>,
    ) -> (Ending, Option<Arc<Frame>>) {
        let run = job.start_primary();
        let status = Status {
            state: State::Running,
            started: Some(Timestamp::now()),
            ..Status::QUEUED
        };
        if let Err(error) = self.store.update(job.id(), status.clone()).await {
            error!(job = %job.id(), %error, "the state of a job could not be stored");
        }
        job.status.send_replace(status);
        let end = run.complete().await;
        // What the levels were must outlive the run.
        job.status.send_if_modified(|status| {
            status.levels = run.levels();
            false
        });
        drop(memory);
        end
    }
}

/// What the end of its run means for a job.
fn verdict(ending: Ending) -> (State, Option<Reason>, Option<Failure>) {
    match ending {
        Ending::Outcome(outcome) => match outcome {
            Outcome::Converged => (State::Converged, None, None),
            Outcome::Stationary => (State::Converged, Some(Reason::Stationary), None),
            Outcome::Exhausted => (State::Exhausted, None, None),
            Outcome::Stalled(stall) => (State::Stalled, Some(Reason::Stalled(stall)), None),
            Outcome::Overflow => (State::Failed, None, Some(Failure::Overflow)),
        },
        Ending::Broken => (State::Failed, None, Some(Failure::Defect)),
        Ending::Stopped => (State::Cancelled, None, None),
    }
}

/// A place among the unfinished jobs.
struct Place(Arc<Jobs>);

impl Place {
    fn take(jobs: &Arc<Jobs>) -> Result<Self, Refused> {
        let limit = jobs.limits.jobs;
        jobs.unfinished
            .fetch_update(Ordering::AcqRel, Ordering::Acquire, |count| {
                (count < limit).then_some(count + 1)
            })
            .map_err(|_| Refused::Full { limit })?;
        Ok(Self(Arc::clone(jobs)))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.unfinished.fetch_sub(1, Ordering::AcqRel);
    }
}
