//! The life of a job from the queue to its end.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use tokio::time::sleep;
use tracing::{debug, error, info, warn};

use super::Jobs;
use crate::job::frame::Frame;
use crate::job::probation::OnProbation;
use crate::job::result::LastGeometry;
use crate::job::run::{Ending, Run, SharedSystem};
use crate::job::slots::Slot;
use crate::job::state::{State, Status};
use crate::job::store::StoreError;
use crate::job::store::crash_recovery::probation;
use crate::job::{Job, STORE_AGAIN, retry_until_available};

/// A run that was started.
struct StartedRun {
    run: Arc<Run>,
    /// Held while the job is on probation after a crash.
    probation: Option<OnProbation>,
}

/// The result of waiting for a turn.
enum Turn {
    Run(StartedRun),
    /// It was cancelled before.
    Cancelled,
    /// Another replica was quicker.
    Elsewhere,
}

/// Ends the span of a job when the task that drives it ends, or is dropped with the runtime.
struct Traced(Arc<Job>);

impl Drop for Traced {
    fn drop(&mut self) {
        self.0.trace.end(&self.0.status());
    }
}

impl Jobs {
    /// Drives a job to its end, in a task of its own.
    pub(super) fn start_driving(
        self: &Arc<Self>,
        job: Arc<Job>,
        run: Option<Arc<Run>>,
        slot: Slot,
    ) {
        job.trace.begin(job.outline(), None);
        let (jobs, traced) = (Arc::clone(self), Traced(Arc::clone(&job)));
        tokio::spawn(async move {
            jobs.drive(job, run, slot).await;
            drop(traced);
        });
    }

    /// Drives a job to its end: at once if it has a run, else when its turn comes.
    async fn drive(self: Arc<Self>, job: Arc<Job>, run: Option<Arc<Run>>, slot: Slot) {
        let probation = None;
        let turn = match run {
            Some(run) => Ok(Turn::Run(StartedRun { run, probation })),
            None => self.turn(&job).await,
        };
        let (ending, last) = match turn {
            Ok(Turn::Run(start)) => {
                let _running = self.resources.counters.run_job();
                self.run(&job, start).await
            }
            Ok(Turn::Cancelled) => (Ending::Stopped, None),
            Ok(Turn::Elsewhere) => {
                drop(slot);
                return self.leave(&job).await;
            }
            Err(error) => {
                error!(job = %job.id(), %error, "a job could not be run");
                (Ending::Broken, None)
            }
        };
        if job.is_abandoned() {
            return drop(slot);
        }
        if self.suspended.load(Ordering::Acquire) && ending == Ending::Stopped {
            if let Some(store) = &job.store
                && let Err(error) = store.requeue(job.id()).await
            {
                warn!(job = %job.id(), %error, "a job could not be put back into the queue");
            }
            return drop(slot);
        }
        self.end(&job, ending, last, slot).await;
    }

    /// Stores the end of a job and publishes it.
    async fn end(&self, job: &Arc<Job>, ending: Ending, last: Option<Arc<Frame>>, slot: Slot) {
        let (state, reason, failure) = ending.verdict();
        let status = Status {
            state,
            finished: Some(self.store.stamp()),
            reason,
            failure,
            ..job.status()
        };
        let result = last.map(|frame| LastGeometry::of(&frame));
        let finish = async || match &job.store {
            Some(store) => {
                let (status, result) = (status.clone(), result.clone());
                let finished = store.finish(job.id(), status, result);
                job.trace.store("finish", finished).await
            }
            None => Ok(true),
        };
        // With other replicas the store decides who ends a job; alone, only this one can.
        let is_alone = self.store.shared().is_none();
        let before = job.status.borrow().clone();
        let mut finished = finish().await;
        drop(slot);
        if is_alone {
            self.publish(job, &status, &result);
        }
        // Until it is stored the job stays in memory; after a crash it would run again.
        while let Err(error) = &finished {
            error!(job = %job.id(), %error, "the end of a job could not be stored, yet");
            if job.crashes > 0 && before.state == State::Running {
                self.end_probation(job, before.clone()).await;
            }
            self.retain().await;
            sleep(STORE_AGAIN).await;
            finished = finish().await;
        }
        match finished {
            Ok(false) => return self.leave(job).await,
            _ if !is_alone => self.publish(job, &status, &result),
            _ => {}
        }
        if job.is_kept() {
            self.ended.notify_one();
        }
    }

    /// Notifies clients that a job has ended.
    fn publish(&self, job: &Job, status: &Status, result: &Option<LastGeometry>) {
        if job.is_kept() {
            let state = status.state;
            info!(job = %job.id(), %state, "job ended");
            self.resources.counters.count_end(state);
        }
        let _ = job.result.set(result.clone());
        job.status.send_replace(status.clone());
    }

    /// Leaves a job to the replica that has claimed it.
    async fn leave(&self, job: &Arc<Job>) {
        job.elsewhere.store(true, Ordering::Release);
        if let Some(shared) = self.store.shared()
            && let Err(error) = self.refresh(shared, vec![Arc::clone(job)]).await
        {
            debug!(job = %job.id(), %error, "the state of a job at another replica is not known yet");
        }
    }

    /// Waits for the turn of a queued job and starts its run.
    async fn turn(&self, job: &Job) -> Result<Turn, StoreError> {
        let queue = job.trace.queue();
        let permits = async {
            let outline = job.outline();
            let memory = self
                .share(outline.step_cost)
                .take(job.peer, outline.memory)
                .await?;
            let probation = match job.crashes {
                0 => None,
                _ => Some(self.probation.begin().await),
            };
            Some((memory, probation))
        };
        let permits = tokio::select! {
            biased;
            () = job.stop_requested() => None,
            permits = permits => permits,
        };
        drop(queue);
        let Some((memory, probation)) = permits else {
            return Ok(Turn::Cancelled);
        };
        let (status, store) = (Status::running(), job.store()?);
        // After a crash the store must show which jobs were running.
        let on_probation = probation.is_some();
        let start = || store.start(job.id(), status.clone(), on_probation);
        let started = job.trace.store("start", retry_until_available(start));
        let started = tokio::select! {
            biased;
            started = started => started?,
            () = job.stop_requested() => return Ok(Turn::Cancelled),
        };
        if !started {
            return Ok(Turn::Elsewhere);
        }
        let problem = tokio::select! {
            biased;
            problem = retry_until_available(|| job.problem()) => problem?,
            () = job.stop_requested() => return Ok(Turn::Cancelled),
        };
        let system = SharedSystem::new(problem, None);
        let run = job.begin(Arc::new(system), Some(memory));
        job.status.send_replace(status);
        Ok(Turn::Run(StartedRun { run, probation }))
    }

    /// Drives the run of a job to its end.
    async fn run(&self, job: &Arc<Job>, start: StartedRun) -> (Ending, Option<Arc<Frame>>) {
        let run = &start.run;
        if self.suspended.load(Ordering::Acquire) {
            run.stop();
        }
        let end = match start.probation {
            None => run.complete().await,
            Some(probation) => self.complete_on_probation(job, run, probation).await,
        };
        // The levels must outlive the run. If another replica has ended the job meanwhile, they are its own.
        job.status.send_if_modified(|status| {
            if !status.state.is_final() {
                status.levels = run.levels();
            }
            false
        });
        if job.is_kept() {
            self.recent.keep(job, run);
        }
        end
    }

    /// Drives the run of a job to its end that was running in a crash. Its first moments are its probation.
    async fn complete_on_probation(
        &self,
        job: &Job,
        run: &Arc<Run>,
        on_probation: OnProbation,
    ) -> (Ending, Option<Arc<Frame>>) {
        tokio::select! {
            end = run.complete() => return end,
            () = sleep(probation(job.crashes)) => {}
            () = self.probation.interrupted() => {}
        }
        let status = job.status.borrow().clone();
        self.end_probation(job, status).await;
        drop(on_probation);
        run.complete().await
    }

    /// Records that crashes from now on are not attributed to a job.
    async fn end_probation(&self, job: &Job, status: Status) {
        if let Some(store) = &job.store
            && let Err(error) = store.start(job.id(), status, false).await
        {
            warn!(job = %job.id(), %error, "the end of a probation could not be stored");
        }
    }
}
