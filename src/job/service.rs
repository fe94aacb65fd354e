//! All jobs of a server: creating, finding, listing, cancelling and deleting them.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Weak};
use std::time::Duration;

use jiff::Timestamp;
use parking_lot::Mutex;
use thiserror::Error;
use tokio::sync::Notify;
use tokio::time::{sleep, timeout};
use tracing::{error, info, warn};
use uuid::Uuid;

use super::Job;
use super::frame::Frame;
use super::memory::Share;
use super::outline::{Label, Outline};
use super::peer::Peer;
use super::places::{Occupied, Place, Places};
use super::recent::Recent;
use super::resources::Resources;
use super::run::{Ending, Run};
use super::scheduler::Lane;
use super::state::{Failure, Reason, State, Status};
use super::store::{
    FORGOTTEN_AT_ONCE, IdempotencyEntry, IdempotencyKey, Record, Retention, Selection, Store,
    StoreError,
};
use super::suspects::{Suspects, WATCH, Watch};
use crate::fit::iteration::Outcome;
use crate::fit::problem::Problem;
use crate::fit::system::System;

/// Multiplications of an iteration: they take a second or two.
const MOST_OF_A_STEP: usize = 2_000_000_000;

/// Multiplications before the first iteration, which have a lane of their own: they take some seconds.
const MOST_OF_A_START: usize = 20_000_000_000;

/// How long to wait before a result that could not be stored is stored again.
const STORE_AGAIN: Duration = Duration::from_secs(2);

/// How often, at least, jobs are looked for that have become too old.
const MOST_AGE_CHECK: Duration = Duration::from_secs(60);

/// How long the past may be beyond its limits.
const RETENTION_PAUSE: Duration = Duration::from_millis(50);

/// Limits of the jobs of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bytes of jobs that have just ended and are still at hand.
    pub recent: usize,
    /// Jobs that have not ended.
    pub jobs: usize,
    /// Those of them that one peer has made.
    pub jobs_of_a_peer: usize,
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
    /// The client has as many unfinished jobs as one may have.
    #[error("{limit} jobs from your address are unfinished, the limit of this server for each")]
    PeerFull {
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
    /// A piece of it that cannot be interrupted would take too long.
    #[error(
        "{what} takes about {needed:.0e} multiplications, and this server computes at most {limit:.0e} \
         in one piece: choose a lower degree or fewer points"
    )]
    TooMuchWork {
        /// The piece.
        what: &'static str,
        /// Multiplications of the piece.
        needed: f64,
        /// The most that are done.
        limit: f64,
    },
    /// The key belongs to another request.
    #[error("the key was used for another request, which made job {0}")]
    KeyTaken(Uuid),
    /// It could not be kept.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// A job that was asked for.
#[derive(Debug)]
pub enum Accepted {
    /// It is new.
    New(Arc<Job>),
    /// It was made before, for the same key.
    Known(Arc<Job>),
}

/// The jobs of a server.
pub struct Jobs {
    store: Arc<dyn Store>,
    resources: Arc<Resources>,
    limits: Limits,
    /// Jobs that were running in a crash, which run again a few at a time.
    suspects: Suspects,
    /// For jobs that have not ended.
    places: Arc<Places>,
    /// The process is about to end: jobs go back to the queue.
    suspended: AtomicBool,
    recent: Recent,
    /// A job has ended.
    ended: Arc<Notify>,
    /// How many jobs were deleted.
    deletions: AtomicUsize,
    /// Jobs that somebody holds: those that run and those that are read.
    live: Mutex<HashMap<Uuid, Weak<Job>>>,
}

impl Jobs {
    /// No jobs but those in the store.
    pub fn new(store: Arc<dyn Store>, resources: Arc<Resources>, limits: Limits) -> Self {
        let cache = Arc::clone(&resources.memory.cache);
        Self {
            store,
            resources,
            limits,
            suspects: Suspects::default(),
            places: Places::new(limits.jobs, limits.jobs_of_a_peer),
            suspended: AtomicBool::new(false),
            recent: Recent::new(limits.recent, cache),
            ended: Arc::default(),
            deletions: AtomicUsize::new(0),
            live: Mutex::default(),
        }
    }

    /// What the jobs share.
    pub fn resources(&self) -> &Resources {
        &self.resources
    }

    /// How many jobs wait for their turn.
    pub fn queued(&self) -> usize {
        let running = self.resources.counters.running();
        self.places.taken().saturating_sub(running)
    }

    /// Queues the jobs that had not ended when the process did, and keeps the past within limits
    /// from now on.
    pub async fn resume(self: &Arc<Self>) -> Result<(), StoreError> {
        let mut unfinished = self.store.unfinished().await?;
        // The quickest first: they come to their ends soon.
        unfinished.sort_by_key(|record| (record.crashes, record.outline.step_cost));
        let crashes = unfinished.iter().map(|record| record.crashes);
        self.suspects.gather(crashes);
        if !unfinished.is_empty() {
            info!(count = unfinished.len(), "jobs go on where they were left");
        }
        for record in unfinished {
            let job = self.bring_to_life(record);
            let place = self.places.occupy();
            tokio::spawn(Arc::clone(self).drive(job, None, place));
        }
        let jobs = Arc::downgrade(self);
        let age_check = (self.limits.retention.age / 4).clamp(RETENTION_PAUSE, MOST_AGE_CHECK);
        tokio::spawn(async move {
            while let Some(jobs) = jobs.upgrade() {
                jobs.retain().await;
                let ended = Arc::clone(&jobs.ended);
                drop(jobs);
                let _ = timeout(age_check, ended.notified()).await;
                // Many jobs may end at about the same time.
                sleep(RETENTION_PAUSE).await;
            }
        });
        Ok(())
    }

    /// Puts running jobs back into the queue, for the next start of the server.
    pub async fn suspend(&self) {
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
        // Stopping takes a step, of at most a few seconds.
        while self.places.taken() > 0 {
            sleep(Duration::from_millis(1)).await;
        }
    }

    /// Accepts a job and starts it; or gives the job that was made for the same key. When it
    /// returns, the job is kept. If its collocation matrix is that of the system `similar`, that one is used.
    pub async fn create(
        self: &Arc<Self>,
        label: Label,
        problem: Problem,
        similar: Option<Arc<System>>,
        key: Option<IdempotencyKey>,
    ) -> Result<Accepted, Refused> {
        let jobs = Arc::clone(self);
        let problem = Arc::new(problem);
        let peer = Peer::current();
        // A client that goes away in the meantime must not leave half a job behind.
        let accepted = tokio::spawn(async move {
            loop {
                let (label, problem) = (label.clone(), Arc::clone(&problem));
                let (similar, key) = (similar.clone(), key.clone());
                let accepted = Arc::clone(&jobs).accept(label, problem, similar, key, peer);
                // The job of the key may be deleted when it is looked for.
                if let Some(accepted) = accepted.await? {
                    return Ok(accepted);
                }
            }
        });
        accepted.await.unwrap_or_else(|error| {
            Err(StoreError::Failed(format!("the job could not be started: {error}")).into())
        })
    }

    /// `None` if there was a job for the key, which is gone.
    async fn accept(
        self: Arc<Self>,
        label: Label,
        problem: Arc<Problem>,
        similar: Option<Arc<System>>,
        key: Option<IdempotencyKey>,
        peer: Option<Peer>,
    ) -> Result<Option<Accepted>, Refused> {
        let outline = Outline::new(label, &problem);
        self.admit(&outline)?;
        check_work(&problem)?;
        let place = self.places.take(peer)?;
        let memory = self.share(&outline).take_at_once(outline.memory);
        let record = Record {
            outline,
            status: match memory {
                Some(_) => Status::running(),
                None => Status::QUEUED,
            },
            crashes: 0,
            watched: false,
        };
        // Alive before it is stored: whoever finds it in the store finds it alive.
        let job = self.bring_to_life(record.clone());
        let inserted = self.store.insert(record, Arc::clone(&problem), key.clone());
        // The fit does not wait for the disk; the answer does. A job that has to wait for memory
        // does so without its points, which it gets back from the store.
        let waiting = match memory {
            Some(memory) => {
                let start = Start {
                    watch: None,
                    run: job.begin(problem, similar, memory),
                };
                tokio::spawn(Arc::clone(&self).drive(Arc::clone(&job), Some(start), place));
                None
            }
            None => Some(place),
        };
        let existing = inserted.await.inspect_err(|_| job.request_cancel())?;
        if let Some(entry) = existing {
            job.request_cancel();
            return self.job_of(entry, key.as_ref()).await;
        }
        if let Some(place) = waiting {
            tokio::spawn(Arc::clone(&self).drive(Arc::clone(&job), None, place));
        }
        self.resources.counters.accepted.inc();
        info!(job = %job.id(), points = job.outline().grid.count(), "job accepted");
        Ok(Some(Accepted::New(job)))
    }

    /// The job that was made for a key, if there is one.
    pub async fn find_by_key(&self, key: &IdempotencyKey) -> Result<Option<Accepted>, Refused> {
        match self.store.idempotency_entry(&key.name).await? {
            None => Ok(None),
            Some(entry) => self.job_of(entry, Some(key)).await,
        }
    }

    /// The job of the entry of a key, which must have been made by the same request.
    async fn job_of(
        &self,
        entry: IdempotencyEntry,
        key: Option<&IdempotencyKey>,
    ) -> Result<Option<Accepted>, Refused> {
        if key.is_none_or(|key| key.digest != entry.digest) {
            return Err(Refused::KeyTaken(entry.id));
        }
        let job = self.find(entry.id).await?;
        Ok(job.map(Accepted::Known))
    }

    /// The job of this id.
    pub async fn find(&self, id: Uuid) -> Result<Option<Arc<Job>>, StoreError> {
        loop {
            if let Some(job) = self.live(id) {
                return Ok(Some(job));
            }
            let deletions = self.deletions.load(Ordering::Acquire);
            match self.store.get(id).await? {
                None => return Ok(None),
                Some(record) if record.status.state.is_final() => {
                    let job = self.bring_to_life(record);
                    if self.deletions.load(Ordering::Acquire) == deletions {
                        return Ok(Some(job));
                    }
                    // It may have been deleted before it came to life.
                    self.live.lock().remove(&id);
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
                true => Some(
                    self.live(record.outline.id)
                        .unwrap_or_else(|| self.job(record)),
                ),
                false => self.find(record.outline.id).await?,
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
        self.forget(&[id]);
        Ok(existed)
    }

    /// Jobs are not in the store any more. Whoever holds them goes on with them; nobody finds them.
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

    /// The one [`Job`] of a record, which all who deal with it share.
    fn bring_to_life(&self, record: Record) -> Arc<Job> {
        let mut live = self.live.lock();
        let id = record.outline.id;
        if let Some(job) = live.get(&id).and_then(Weak::upgrade) {
            return job;
        }
        let job = self.job(record);
        if live.len() == live.capacity() {
            live.retain(|_, job| job.strong_count() > 0);
        }
        live.insert(id, Arc::downgrade(&job));
        job
    }

    fn job(&self, record: Record) -> Arc<Job> {
        let (store, resources) = (Arc::clone(&self.store), Arc::clone(&self.resources));
        Arc::new(Job::new(record, store, resources))
    }

    /// Refuses what can never run.
    fn admit(&self, outline: &Outline) -> Result<(), Refused> {
        let share = self.share(outline);
        if !share.holds(outline.memory) {
            return Err(Refused::TooLarge {
                needed: outline.memory,
                limit: share.bytes(),
            });
        }
        Ok(())
    }

    /// The memory that a job takes some of.
    fn share(&self, outline: &Outline) -> &Share {
        let memory = &self.resources.memory;
        match Lane::of(outline.step_cost) {
            Lane::Quick => &memory.quick,
            _ => &memory.heavy,
        }
    }

    /// Takes a job to its end: at once with the memory and the problem that it has got, else when
    /// it is its turn.
    async fn drive(self: Arc<Self>, job: Arc<Job>, start: Option<Start>, place: Place) {
        let ended = async {
            let turn = match start {
                Some(start) => Some(start),
                None => self.turn(&job).await?,
            };
            match turn {
                Some(start) => {
                    let _running = self.resources.counters.run_job();
                    Ok(self.run(&job, start).await)
                }
                None => Ok((Ending::Stopped, None)),
            }
        };
        let (ending, last) = ended.await.unwrap_or_else(|error: StoreError| {
            error!(job = %job.id(), %error, "a job could not be run");
            (Ending::Broken, None)
        });
        if self.suspended.load(Ordering::Acquire) && ending == Ending::Stopped {
            let queued = self.store.requeue(job.id()).await;
            if let Err(error) = queued {
                warn!(job = %job.id(), %error, "a job could not be put back into the queue");
            }
            return drop(place);
        }
        let (state, reason, failure) = verdict(ending);
        let status = Status {
            state,
            finished: Some(Timestamp::now()),
            reason,
            failure,
            ..job.status()
        };
        let result = last.map(|frame| Arc::clone(&frame.control_points));
        let mut kept = self
            .store
            .finish(job.id(), status.clone(), result.clone())
            .await;
        info!(job = %job.id(), %state, "job ended");
        self.resources.counters.count_end(state);
        drop(place);
        let _ = job.result.set(result.clone());
        // From here on clients know of the end: a crash does not undo it any more.
        job.status.send_replace(status.clone());
        // Until the disk takes it the job lives in memory; after a crash it would run again.
        while let Err(error) = kept {
            error!(job = %job.id(), %error, "the end of a job could not be stored, yet");
            self.retain().await;
            sleep(STORE_AGAIN).await;
            kept = self
                .store
                .finish(job.id(), status.clone(), result.clone())
                .await;
        }
        self.ended.notify_one();
    }

    /// Waits until it is the turn of a queued job; `None` if it is cancelled before.
    async fn turn(&self, job: &Job) -> Result<Option<Start>, StoreError> {
        let permits = async {
            let outline = job.outline();
            let memory = self.share(outline).take(outline.memory).await?;
            Some((memory, self.suspects.turn(job.crashes).await))
        };
        let permits = tokio::select! {
            biased;
            () = job.cancel_requested() => None,
            permits = permits => permits,
        };
        let Some((memory, watch)) = permits else {
            return Ok(None);
        };
        let status = Status::running();
        // Whether a job was running in a crash must be known after it.
        let started = self.store.start(job.id(), status.clone(), watch.is_some());
        started.await?;
        let problem = job.problem().await?;
        let run = job.begin(problem, None, memory);
        job.status.send_replace(status);
        Ok(Some(Start { watch, run }))
    }

    async fn run(&self, job: &Arc<Job>, start: Start) -> (Ending, Option<Arc<Frame>>) {
        let run = &start.run;
        if self.suspended.load(Ordering::Acquire) {
            run.stop();
        }
        let end = match start.watch {
            None => run.complete().await,
            Some(watch) => self.complete_under_watch(job, run, watch).await,
        };
        // What the levels were must outlive the run.
        job.status.send_if_modified(|status| {
            status.levels = run.levels();
            false
        });
        self.recent.keep(job, run);
        end
    }

    /// What brings the process down does so soon, or it is not to be told from the others.
    async fn complete_under_watch(
        &self,
        job: &Job,
        run: &Arc<Run>,
        watch: Watch,
    ) -> (Ending, Option<Arc<Frame>>) {
        if let Ok(end) = timeout(WATCH, run.complete()).await {
            return end;
        }
        if let Err(error) = self.store.end_watch(job.id()).await {
            warn!(job = %job.id(), %error, "a job could not be cleared of suspicion");
        }
        drop(watch);
        run.complete().await
    }

    async fn retain(&self) {
        loop {
            match self.store.retain(self.limits.retention).await {
                Ok(forgotten) => {
                    self.forget(&forgotten);
                    if forgotten.len() < FORGOTTEN_AT_ONCE {
                        return;
                    }
                }
                Err(error) => return error!(%error, "old jobs could not be removed"),
            }
        }
    }
}

/// Refuses what would keep others, and those who cancel it, waiting for seconds.
fn check_work(problem: &Problem) -> Result<(), Refused> {
    let pieces = [
        ("an iteration", problem.step_cost(), MOST_OF_A_STEP),
        ("preparing the fit", problem.start_cost(), MOST_OF_A_START),
    ];
    match pieces.into_iter().find(|(_, needed, limit)| needed > limit) {
        None => Ok(()),
        Some((what, needed, limit)) => Err(Refused::TooMuchWork {
            what,
            needed: needed as f64,
            limit: limit as f64,
        }),
    }
}

/// A job that may run.
struct Start {
    run: Arc<Run>,
    /// It was running in a crash.
    watch: Option<Watch>,
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
        // Only runs for readers are revoked.
        Ending::Stopped | Ending::Revoked => (State::Cancelled, None, None),
    }
}

impl From<Occupied> for Refused {
    fn from(occupied: Occupied) -> Self {
        match occupied {
            Occupied::All(limit) => Self::Full { limit },
            Occupied::ByPeer(limit) => Self::PeerFull { limit },
        }
    }
}
