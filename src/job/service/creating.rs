//! Creating jobs.

use std::sync::Arc;

use tracing::info;

use super::Jobs;
use super::refused::Refused;
use crate::job::Job;
use crate::job::outline::{Label, Outline};
use crate::job::peer::Peer;
use crate::job::run::SharedSystem;
use crate::job::state::Status;
use crate::job::store::{IdempotencyEntry, IdempotencyKey, Insertion, Record, StoreError};
use crate::telemetry::request::RequestTrace;
use piad_fit::engine::{Problem, System};

/// The number of attempts to insert or find a job for a key whose job is gone before it is found.
const ATTEMPTS: usize = 16;

/// The job of an accepted request.
#[derive(Debug)]
pub(crate) struct Accepted {
    pub job: Arc<Job>,
    /// True if it existed before, for the same idempotency key.
    pub replayed: bool,
}

impl Jobs {
    /// Creates a job and starts it, or returns the job that was created for the same idempotency key. When this
    /// returns, the job is stored. A collocation matrix equal to that of `similar` is taken from there.
    pub(crate) async fn create(
        self: &Arc<Self>,
        label: Label,
        problem: Problem,
        similar: Option<Arc<System>>,
        key: Option<IdempotencyKey>,
    ) -> Result<Accepted, Refused> {
        let jobs = Arc::clone(self);
        let problem = Arc::new(problem);
        let (peer, request) = (Peer::current(), RequestTrace::current());
        // In a task of its own: a client that disconnects must not leave half a job behind.
        let accepted = tokio::spawn(async move {
            for _ in 0..ATTEMPTS {
                let (label, problem) = (label.clone(), Arc::clone(&problem));
                let (similar, key) = (similar.clone(), key.clone());
                let jobs = Arc::clone(&jobs);
                let accepted = jobs.accept(label, problem, similar, key, peer, request.as_ref());
                // The job of the key may have been deleted before it was found.
                if let Some(accepted) = accepted.await? {
                    return Ok(accepted);
                }
            }
            let reason = "the jobs created with this key were deleted repeatedly";
            Err(StoreError::Unusable(reason.to_owned()).into())
        });
        accepted.await.unwrap_or_else(|error| {
            Err(StoreError::Failed(format!("the job could not be started: {error}")).into())
        })
    }

    /// `None` if the job that was made for the key has been deleted.
    async fn accept(
        self: Arc<Self>,
        label: Label,
        problem: Arc<Problem>,
        similar: Option<Arc<System>>,
        key: Option<IdempotencyKey>,
        peer: Option<Peer>,
        request: Option<&RequestTrace>,
    ) -> Result<Option<Accepted>, Refused> {
        let outline = Outline::new(label, &problem, peer);
        let slot = self.slots.take(peer)?;
        let memory = self
            .share(outline.step_cost)
            .take_at_once(peer, outline.memory);
        let status = match memory {
            Some(_) => Status::running(),
            None => Status::QUEUED,
        };
        let record = Record::new(outline, status);
        // In memory before it is in the store, so that a reader that finds it there finds this one.
        let job = self.bring_to_life(record.clone(), peer, false);
        job.trace.begin(job.outline(), request);
        let quota = self.resources.quotas.of(record.outline.tenant);
        let inserted = self
            .store
            .insert(record, Arc::clone(&problem), key.clone(), quota);
        let inserted = job.trace.store("insert", inserted);
        // The answer waits for the disk, the fit does not. A job that has to wait for memory drops its
        // points and reads them from the store again.
        let waiting = match memory {
            Some(memory) => {
                let system = SharedSystem::new(problem, similar);
                let run = job.begin(Arc::new(system), Some(memory));
                self.start_driving(Arc::clone(&job), Some(run), slot);
                None
            }
            None => Some(slot),
        };
        let inserted = inserted.await.inspect_err(|_| self.give_up(&job))?;
        match inserted {
            Insertion::New => {}
            Insertion::Known(entry) => {
                self.abandon(&job);
                return self.job_of(entry, key.as_ref()).await;
            }
            Insertion::Refused(exceeded) => {
                self.abandon(&job);
                self.resources.counters.count_exceeded(job.outline().tenant);
                return Err(exceeded.into());
            }
        }
        if let Some(slot) = waiting {
            self.start_driving(Arc::clone(&job), None, slot);
        }
        self.resources.counters.count_job(job.outline());
        info!(job = %job.id(), points = job.outline().grid.count(), "job accepted");
        Ok(Some(Accepted {
            job,
            replayed: false,
        }))
    }

    /// Drops a job that was not stored. In a database it may have been, without an answer: then another replica runs
    /// it, or this one again.
    fn give_up(self: &Arc<Self>, job: &Arc<Job>) {
        self.abandon(job);
        match self.store.shared() {
            Some(shared) => self.follow_abandoned(Arc::clone(shared), job),
            None => self.let_go(job),
        }
    }

    /// Stops a job, and forgets it.
    fn abandon(&self, job: &Job) {
        self.live.lock().remove(&job.id());
        job.abandon();
    }

    /// The job that was made for an idempotency key, if there is one.
    pub(crate) async fn find_by_key(
        &self,
        key: &IdempotencyKey,
    ) -> Result<Option<Accepted>, Refused> {
        match self.store.idempotency_entry(&key.name).await? {
            Some(entry) => self.job_of(entry, Some(key)).await,
            None => Ok(None),
        }
    }

    /// The job of an entry, which must have been created by the same request.
    async fn job_of(
        &self,
        entry: IdempotencyEntry,
        key: Option<&IdempotencyKey>,
    ) -> Result<Option<Accepted>, Refused> {
        if key.is_none_or(|key| key.digest != entry.digest) {
            return Err(Refused::KeyTaken(entry.id));
        }
        let job = self.find(entry.id).await?;
        Ok(job.map(|job| Accepted {
            job,
            replayed: true,
        }))
    }
}
