//! A fit as a thing that lives: with an id, a state, readers, and an end.
//!
//! - [`state`]: the state machine of a job;
//! - [`frame`]: the geometry of one level, shared by everyone who reads it;
//! - [`run`]: an iteration that advances as far as somebody wants it to, with its recent frames;
//! - [`cursor`]: a reader of a job, frame by frame, at its own pace;
//! - [`scheduler`]: the compute pool: fair slices, small work never behind large work;
//! - [`service`]: creating, finding, listing, cancelling and deleting jobs;
//! - [`store`]: where jobs are kept.
//!
//! An iterate is a pure function of the problem and its level. So frames are never stored: what is
//! no longer at hand is computed again, by a run that starts over.

pub mod cursor;
pub mod frame;
pub mod run;
pub mod scheduler;
pub mod service;
pub mod state;
pub mod store;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, Weak};

use bytes::Bytes;
use jiff::Timestamp;
use parking_lot::Mutex;
use tokio::sync::{Notify, OnceCell, watch};
use uuid::Uuid;

use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::fit::system::System;
use run::{Attached, Run, SharedSystem};
use scheduler::Scheduler;
use state::{State, Status};
use store::Record;

/// A job: a problem and what has become of it.
#[derive(Debug)]
pub struct Job {
    id: Uuid,
    name: Option<String>,
    created: Timestamp,
    problem: Arc<Problem>,
    status: watch::Sender<Status>,
    result: OnceLock<Arc<Points>>,
    cancel_requested: AtomicBool,
    cancel: Notify,
    system: Arc<SharedSystem>,
    /// The run that decides the job's fate; gone once the job has ended.
    primary: Mutex<Weak<Run>>,
    /// Runs that readers can share, the primary one among them.
    runs: Mutex<Vec<Weak<Run>>>,
    scheduler: Arc<Scheduler>,
    ring_bytes: usize,
    description: OnceCell<Bytes>,
}

impl Job {
    /// A job as the store knows it.
    fn new(record: Record, scheduler: Arc<Scheduler>, ring_bytes: usize) -> Self {
        let result = OnceLock::new();
        if let Some(points) = record.result {
            let _ = result.set(points);
        }
        Self {
            id: record.id,
            name: record.name,
            created: record.created,
            system: Arc::new(SharedSystem::new(Arc::clone(&record.problem))),
            problem: record.problem,
            status: watch::Sender::new(record.status),
            result,
            cancel_requested: AtomicBool::new(false),
            cancel: Notify::new(),
            primary: Mutex::new(Weak::new()),
            runs: Mutex::new(Vec::new()),
            scheduler,
            ring_bytes,
            description: OnceCell::new(),
        }
    }

    /// The id; ids grow with time.
    pub fn id(&self) -> Uuid {
        self.id
    }

    /// The client's name for the job.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// When the job was accepted.
    pub fn created(&self) -> Timestamp {
        self.created
    }

    /// The problem.
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The state, with the level that a running job has reached by now.
    pub fn status(&self) -> Status {
        let mut status = self.status.borrow().clone();
        if status.state == State::Running
            && let Some(run) = self.primary.lock().upgrade()
        {
            status.levels = run.levels().or(status.levels);
        }
        status
    }

    /// The free control points of the last level, once the job has ended.
    pub fn result(&self) -> Option<&Arc<Points>> {
        self.result.get()
    }

    /// The system of the problem, shared with the job's runs. It can take long to make: not for the
    /// threads that serve the network.
    pub fn system(&self) -> Arc<System> {
        self.system.get()
    }

    /// Waits until the job has ended.
    pub async fn ended(&self) -> Status {
        let mut watcher = self.status.subscribe();
        match watcher.wait_for(|status| status.state.is_final()).await {
            Ok(status) => status.clone(),
            // The sender lives in `self`: this cannot happen.
            Err(_) => self.status(),
        }
    }

    /// Asks the job to end as soon as its current step is done.
    pub fn request_cancel(&self) {
        self.cancel_requested.store(true, Ordering::Release);
        self.cancel.notify_waiters();
        if let Some(run) = self.primary.lock().upgrade() {
            run.stop();
        }
    }

    /// Waits until cancelling is asked for.
    async fn cancel_requested(&self) {
        let mut notified = std::pin::pin!(self.cancel.notified());
        notified.as_mut().enable();
        if !self.cancel_requested.load(Ordering::Acquire) {
            notified.await;
        }
    }

    /// The encoded description of the job, made once by `encode`.
    pub async fn description<F: Future<Output = Bytes>>(
        &self,
        encode: impl FnOnce() -> F,
    ) -> Bytes {
        self.description.get_or_init(encode).await.clone()
    }

    /// The compute pool that the job's runs share.
    pub fn scheduler(&self) -> &Arc<Scheduler> {
        &self.scheduler
    }

    /// Makes the run that decides the job's fate.
    fn start_primary(&self) -> Arc<Run> {
        let run = self.new_run();
        *self.primary.lock() = Arc::downgrade(&run);
        self.runs.lock().push(Arc::downgrade(&run));
        // A request to cancel may have come before there was anything to stop.
        if self.cancel_requested.load(Ordering::Acquire) {
            run.stop();
        }
        run
    }

    fn new_run(&self) -> Arc<Run> {
        Run::new(
            Arc::clone(&self.system),
            Arc::clone(&self.scheduler),
            self.ring_bytes,
        )
    }

    /// A run that can deliver frame `next`: one that has it or has not come so far, else a new one.
    fn attach(&self, next: usize) -> Attached {
        let mut runs = self.runs.lock();
        runs.retain(|run| run.strong_count() > 0);
        let mut live: Vec<Arc<Run>> = runs.iter().filter_map(Weak::upgrade).collect();
        // The run that is furthest needs the fewest steps to get there.
        live.sort_by_key(|run| std::cmp::Reverse(run.levels().map(|levels| levels.last.iteration)));
        if let Some(attached) = live.iter().find_map(|run| run.attach(next)) {
            return attached;
        }
        let run = self.new_run();
        runs.push(Arc::downgrade(&run));
        Attached::to_new(run, next)
    }
}
