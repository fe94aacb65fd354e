//! The life of a fit: an id, a state, readers, and an end.
//!
//! - [`outline`]: a job without its points;
//! - [`state`]: the state machine of a job, and its progress;
//! - [`frame`]: the geometry of one level, shared by all readers;
//! - [`encoding_cache`], [`content`]: its encoded forms, each made once, and their bytes; [`deltas`]: its difference
//!   from a reader's state;
//! - [`run`]: an iteration that advances on demand, with its recent frames;
//! - [`cursor`]: a reader of a job, frame by frame, at its own pace; [`reader_budget`]: limits of the time that readers
//!   wait for each other; [`peer`]: the client machine of a reader;
//! - [`checkpoints`]: levels from which an iteration can continue;
//! - [`memory`]: the division of the memory; [`replay`]: runs for readers that have missed frames;
//!   [`resources`]: shared by all jobs;
//! - [`scheduler`]: the compute pool: fair slices, small work never behind large work; [`errand`]: work that pauses;
//! - [`direct`]: fits without readers, of which only the last level is needed;
//! - [`memory_pool`]: a part of the memory; [`fair_queue`]: queues in which peers take turns;
//! - [`slots`]: limits of the number of jobs and connections, in all and for each peer;
//! - [`service`]: creating, finding, listing, cancelling and deleting jobs;
//! - [`peer`]: the client that work is done for; [`tenant`]: the owner of jobs; [`quota`]: limits of their number;
//! - [`store`]: the store of jobs; [`probation`]: jobs that were running in a crash; [`recent`]: ended jobs that are
//!   still in memory;
//! - [`counters`]: the metrics of the server; [`trace`]: the spans of a job.
//!
//! An iterate is a pure function of the problem and its level. So frames are never stored: those that are no longer in
//! memory are recomputed by a new run.

mod checkpoints;
pub(crate) mod content;
pub(crate) mod counters;
pub(crate) mod cursor;
pub(crate) mod deltas;
pub(crate) mod direct;
pub(crate) mod encoding_cache;
pub(crate) mod errand;
mod fair_queue;
pub(crate) mod frame;
pub(crate) mod memory;
pub(crate) mod memory_pool;
pub(crate) mod outliers;
pub(crate) mod outline;
pub(crate) mod peer;
pub(crate) mod probation;
mod progress;
pub(crate) mod quota;
pub(crate) mod reader_budget;
pub(crate) mod recent;
pub(crate) mod replay;
pub(crate) mod resources;
pub(crate) mod result;
pub(crate) mod run;
#[cfg(test)]
mod samples;
pub(crate) mod scheduler;
pub(crate) mod service;
pub(crate) mod slots;
pub(crate) mod state;
pub(crate) mod store;
pub(crate) mod tenant;
pub(crate) mod trace;
pub(crate) mod trim;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, Weak};
use std::time::Duration;

use parking_lot::Mutex;
use tokio::sync::watch;
use tokio::time::sleep;
use uuid::Uuid;

use content::Content;
use encoding_cache::EncodingCache;
use frame::Frame;
use memory::Permit;
use outline::Outline;
use peer::Peer;
use piad_fit::engine::{Level, Problem};
use replay::Replays;
use resources::Resources;
use result::LastGeometry;
use run::attached::Attached;
use run::{Run, SharedSystem};
use state::{State, Status};
use store::{Record, Store, StoreError};
use trace::JobTrace;

/// Streams hold the points of jobs of at most this many bytes.
const HELD: usize = 256 * 1024;

/// The system of a job, if a stream holds it until it ends.
pub(crate) type Held = Option<Arc<SharedSystem>>;

/// A job: a problem and its status. Its points are in memory only while it runs or is read.
pub(crate) struct Job {
    outline: Outline,
    /// The number of crashes of the process counted for it.
    crashes: u32,
    /// The peer of the job; `None` after a restart.
    peer: Option<Peer>,
    status: watch::Sender<Status>,
    /// The store that keeps it. An ephemeral edit is gone once it is not read any more.
    store: Option<Arc<Store>>,
    system: Mutex<Weak<SharedSystem>>,
    result: OnceLock<Option<LastGeometry>>,
    wish: watch::Sender<Wish>,
    /// Another replica runs it, or may.
    elsewhere: AtomicBool,
    /// The run whose end is the end of the job; gone once the job has ended.
    primary: Mutex<Weak<Run>>,
    /// Runs that readers can share, including the primary one.
    runs: Mutex<Vec<Weak<Run>>>,
    resources: Arc<Resources>,
    /// The runs that recompute, of all jobs.
    replays: Arc<Replays>,
    descriptions: EncodingCache,
    trace: Arc<JobTrace>,
}

/// What is wanted of a job. Each is more than the one before, and stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Wish {
    /// That it comes to its end.
    Run,
    /// That it stops, to run again after the next start of the server.
    Suspend,
    /// That it ends as soon as its current step is done.
    Cancel,
    /// That it stops, and its end is not published.
    Abandon,
}

impl Job {
    /// A stored job, computed for this peer.
    fn new(
        record: Record,
        store: Option<Arc<Store>>,
        peer: Option<Peer>,
        (resources, replays): (Arc<Resources>, Arc<Replays>),
    ) -> Self {
        Self {
            outline: record.outline,
            crashes: record.crashes,
            peer,
            status: watch::Sender::new(record.status),
            store,
            system: Mutex::default(),
            result: OnceLock::new(),
            wish: watch::Sender::new(Wish::Run),
            elsewhere: AtomicBool::new(false),
            primary: Mutex::new(Weak::new()),
            runs: Mutex::new(Vec::new()),
            resources,
            replays,
            descriptions: EncodingCache::default(),
            trace: Arc::default(),
        }
    }

    /// The job without its points.
    pub(crate) fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The id; ids grow with time.
    pub(crate) fn id(&self) -> Uuid {
        self.outline.id
    }

    /// Returns true if it is in the store. An ephemeral edit exists only in its stream.
    pub(crate) fn is_kept(&self) -> bool {
        self.store.is_some()
    }

    /// The store, as long as the job is there.
    fn store(&self) -> Result<&Store, StoreError> {
        self.store.as_deref().ok_or(StoreError::Gone(self.id()))
    }

    /// The fitting problem, read from the store if it is not in memory.
    pub(crate) async fn problem(&self) -> Result<Arc<Problem>, StoreError> {
        Ok(Arc::clone(self.system().await?.problem()))
    }

    /// The system of the problem, shared by its users; read from the store if it is not in memory.
    pub(crate) async fn system(&self) -> Result<Arc<SharedSystem>, StoreError> {
        if let Some(system) = self.system.lock().upgrade() {
            return Ok(system);
        }
        // No lock is held across this await: a reader that is not polled would keep it.
        let problem = self.store()?.problem(self.id()).await?;
        let problem = problem.ok_or(StoreError::Gone(self.id()))?;
        let mut shared = self.system.lock();
        if let Some(system) = shared.upgrade() {
            return Ok(system);
        }
        let system = Arc::new(SharedSystem::new(problem, None));
        *shared = Arc::downgrade(&system);
        Ok(system)
    }

    /// The system of a small job that has begun, held by its streams, so that they reach their end even if the job is
    /// deleted meanwhile.
    pub(crate) async fn held(&self) -> Result<Held, StoreError> {
        let is_small = self.outline.memory <= HELD;
        let waits = self.status.borrow().state == State::Queued;
        if is_small && !waits {
            return Ok(Some(self.system().await?));
        }
        Ok(None)
    }

    /// The status, with the level that a running job has reached by now.
    pub(crate) fn status(&self) -> Status {
        let mut status = self.status.borrow().clone();
        if status.state == State::Running
            && let Some(run) = self.primary.lock().upgrade()
        {
            status.levels = run.levels().or(status.levels);
        }
        status
    }

    /// Returns true if the job has ended at this level.
    pub(crate) fn has_ended_at(&self, iteration: usize) -> bool {
        let status = self.status.borrow();
        let last = status.levels.map(|levels| levels.last.iteration);
        status.state.is_final() && last == Some(iteration)
    }

    /// Recomputes the last frame, once the job has ended at this level; `None` if it has no geometry.
    pub(crate) async fn last_frame(&self, level: Level) -> Result<Option<Arc<Frame>>, StoreError> {
        let Some(result) = self.result().await? else {
            return Ok(None);
        };
        let problem = self.problem().await?;
        Ok(Some(result.frame(level, problem)))
    }

    /// The geometry of the last level, once the job has ended.
    async fn result(&self) -> Result<Option<LastGeometry>, StoreError> {
        if !self.status.borrow().state.is_final() {
            return Ok(None);
        }
        if let Some(result) = self.result.get() {
            return Ok(result.clone());
        }
        let store = self.store()?;
        let result = store.result(self.id()).await?;
        if result.is_none() && store.get(self.id()).await?.is_none() {
            return Err(StoreError::Gone(self.id()));
        }
        // Another reader may have been quicker.
        let _ = self.result.set(result);
        Ok(self.result.get().cloned().flatten())
    }

    /// Waits until the job has ended.
    pub(crate) async fn ended(&self) -> Status {
        let mut watcher = self.status.subscribe();
        match watcher.wait_for(|status| status.state.is_final()).await {
            Ok(status) => status.clone(),
            // The sender lives in `self`: this cannot happen.
            Err(_) => self.status(),
        }
    }

    /// Returns true if another replica runs the job, or may.
    fn is_elsewhere(&self) -> bool {
        self.elsewhere.load(Ordering::Acquire)
    }

    /// Returns true if the run of this replica was stopped and does not decide how the job continues or has ended.
    pub(crate) fn continues_without_its_run(&self) -> bool {
        self.is_elsewhere() || self.status().state.is_final()
    }

    /// Takes over the status that another replica has stored.
    fn follow(&self, theirs: Status) {
        let reached = |status: &Status| status.levels.map(|levels| levels.last.iteration);
        self.status.send_if_modified(|mine| {
            let is_news = match theirs.state {
                State::Queued => false,
                State::Running => mine.state == State::Queued || reached(&theirs) > reached(mine),
                _ => true,
            };
            let is_news = is_news && !mine.state.is_final();
            if is_news {
                *mine = theirs;
            }
            is_news
        });
    }

    /// Asks the job to end as soon as its current step is done.
    pub(crate) fn request_cancel(&self) {
        if self.is_elsewhere()
            && let Some(shared) = self.store.as_deref().and_then(Store::shared)
        {
            let (shared, id) = (Arc::clone(shared), self.id());
            tokio::spawn(async move { retry_until_available(|| shared.cancel(id)).await });
        }
        self.stop(Wish::Cancel);
    }

    /// Stops a job that was not stored, or may not have been; its end is not published.
    fn abandon(&self) {
        self.trace.abandon(&self.status());
        self.stop(Wish::Abandon);
    }

    /// Returns true if its end is not published.
    fn is_abandoned(&self) -> bool {
        *self.wish.borrow() == Wish::Abandon
    }

    /// Stops the job; it runs again after the next start of the server.
    fn suspend(&self) {
        self.stop(Wish::Suspend);
    }

    fn stop(&self, wish: Wish) {
        self.wish.send_modify(|before| *before = wish.max(*before));
        if let Some(run) = self.primary.lock().upgrade() {
            run.stop();
        }
    }

    /// Waits until the job is to stop.
    async fn stop_requested(&self) {
        let mut watcher = self.wish.subscribe();
        // The sender lives in `self`: there is no error.
        let _ = watcher.wait_for(|wish| *wish > Wish::Run).await;
    }

    /// The data of the `job` event in this form, made once by `encode`.
    pub(crate) async fn description<
        F: Future<Output = Result<Content, StoreError>> + Send + 'static,
    >(
        &self,
        form: &'static str,
        encode: impl FnOnce() -> F,
    ) -> Result<Content, StoreError> {
        let cache = &self.resources.memory.cache;
        self.descriptions.get(&form.into(), cache, encode).await
    }

    /// The resources shared by the runs of all jobs.
    pub(crate) fn resources(&self) -> &Arc<Resources> {
        &self.resources
    }

    /// Its spans.
    pub(crate) fn trace(&self) -> &Arc<JobTrace> {
        &self.trace
    }

    /// Starts the primary run. Readers can attach to it as soon as this returns.
    fn begin(&self, system: Arc<SharedSystem>, permit: Option<Permit>) -> Arc<Run> {
        *self.system.lock() = Arc::downgrade(&system);
        let (resources, trace) = (Arc::clone(&self.resources), Arc::clone(&self.trace));
        let run = Run::new(system, resources, permit, self.peer, trace);
        *self.primary.lock() = Arc::downgrade(&run);
        self.runs.lock().push(Arc::downgrade(&run));
        // The job may have been stopped before there was a run.
        if *self.wish.borrow() > Wish::Run {
            run.stop();
        }
        run
    }

    /// Attaches to a run that can deliver frame `next`: one that has not passed it, or else a new one,
    /// which has to wait for memory.
    async fn attach(
        self: &Arc<Self>,
        next: usize,
        peer: Option<Peer>,
    ) -> Result<Attached, StoreError> {
        if let Some(attached) = self.attach_to_live(next, peer) {
            return Ok(attached);
        }
        // In a task of its own: a reader that is not polled would keep the memory from others.
        let attached = tokio::spawn(Arc::clone(self).attach_to_new(next, peer));
        let broken = |_| Err(StoreError::Failed("a reader could not begin".to_owned()));
        attached.await.unwrap_or_else(broken)
    }

    async fn attach_to_new(
        self: Arc<Self>,
        next: usize,
        peer: Option<Peer>,
    ) -> Result<Attached, StoreError> {
        let resources = &self.resources;
        let share = &resources.memory.replays;
        let permit = self.replays.turn(share, peer, self.outline.memory).await;
        // Another reader may have started a run in the meantime.
        if let Some(attached) = self.attach_to_live(next, peer) {
            return Ok(attached);
        }
        let (system, resources) = (self.system().await?, Arc::clone(resources));
        // The spans of the job are about its first computation only.
        let run = Run::new(system, resources, permit, peer, Arc::default());
        let attached = Attached::to_new(Arc::clone(&run), next, peer);
        self.replays.add(Arc::downgrade(&run));
        self.runs.lock().push(Arc::downgrade(&run));
        Ok(attached)
    }

    fn attach_to_live(&self, next: usize, peer: Option<Peer>) -> Option<Attached> {
        let mut runs = self.runs.lock();
        runs.retain(|run| run.strong_count() > 0);
        let mut live: Vec<Arc<Run>> = runs.iter().filter_map(Weak::upgrade).collect();
        // The run that has come furthest needs the fewest steps.
        live.sort_by_key(|run| std::cmp::Reverse(run.levels().map(|levels| levels.last.iteration)));
        let system = self.system.lock().upgrade();
        let is_quickest = |run: &&Arc<Run>| {
            let reached = run.levels().map(|levels| levels.last.iteration);
            let shared = reached.zip(system.as_ref());
            !shared.is_some_and(|(from, shared)| shared.checkpoints.shorten(from, next))
        };
        let mut quickest = live.iter().filter(is_quickest);
        let goes_on = self.continues_without_its_run();
        quickest.find_map(|run| run.attach(next, peer, goes_on))
    }
}

/// The pause before the store is asked again after a failure.
const STORE_AGAIN: Duration = Duration::from_secs(2);

/// Retries the store while it has no space, or its database cannot be reached.
async fn retry_until_available<T, F>(ask: impl Fn() -> F) -> Result<T, StoreError>
where
    F: Future<Output = Result<T, StoreError>>,
{
    loop {
        match ask().await {
            Err(error) if error.may_pass() => sleep(STORE_AGAIN).await,
            answer => return answer,
        }
    }
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut fields = f.debug_struct("Job");
        fields.field("outline", &self.outline);
        fields
            .field("status", &self.status())
            .finish_non_exhaustive()
    }
}
