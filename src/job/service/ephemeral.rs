//! Ephemeral fits: computed for one answer, and never stored.

use std::sync::Arc;

use super::Jobs;
use super::refused::Refused;
use super::sessions::SessionTurn;
use crate::job::Job;
use crate::job::memory::Permit;
use crate::job::outline::{Label, Outline};
use crate::job::peer::Peer;
use crate::job::quota::OpenStream;
use crate::job::run::SharedSystem;
use crate::job::run::attached::Attached;
use crate::job::scheduler::WorkLane;
use crate::job::state::Status;
use crate::job::store::{Record, StoreError};
use crate::job::trace::JobTrace;
use crate::telemetry::request::RequestTrace;
use piad_fit::engine::{Problem, System};

/// A fit for one answer. Its owner has to cancel the job when dropping it.
pub(crate) struct Ephemeral {
    pub job: Arc<Job>,
    /// The run, held from before its first level: no frame is lost.
    pub run: Attached,
    /// Held only here once the run has ended.
    pub system: Arc<SharedSystem>,
    /// It counts as a stream of its tenant.
    pub stream: OpenStream,
    /// The memory for all this; `None` if it was replaced before it began.
    pub room: Option<Permit>,
}

impl Jobs {
    /// The place of a new edit of this job in a drag.
    pub(crate) fn session(&self, parent: &Job, name: String) -> SessionTurn {
        self.sessions.next(parent.id(), Peer::current(), name)
    }

    /// Keeps the points and the collocation matrix of a job in memory while it is edited repeatedly: reading and
    /// computing them would take longer than the edit.
    pub(crate) async fn keep_at_hand(
        &self,
        job: &Arc<Job>,
        shared: &Arc<SharedSystem>,
    ) -> Result<(), StoreError> {
        if self.recent.has_points(job.id()) {
            return Ok(());
        }
        let (lane, made) = (WorkLane::of(job.outline().step_cost), Arc::clone(shared));
        let system = self.resources.scheduler.compute(lane, move || made.get());
        let system = system.await?;
        self.recent.keep_edited(job, Arc::clone(shared), system);
        Ok(())
    }

    /// Begins a fit that is neither stored nor listed, as soon as there is memory for it. One that is
    /// replaced by a newer one of its session is cancelled.
    pub(crate) async fn begin_ephemeral(
        self: &Arc<Self>,
        label: Label,
        problem: Problem,
        similar: Option<Arc<System>>,
        mut turn: Option<SessionTurn>,
    ) -> Result<Ephemeral, Refused> {
        let peer = Peer::current();
        let outline = Outline::new(label, &problem, peer);
        let slot = self.slots.take(peer)?;
        let stream = self.resources.open_stream(outline.tenant)?;
        let trace = Arc::new(JobTrace::default());
        trace.begin(&outline, RequestTrace::current().as_ref());
        let queue = trace.queue();
        let share = self.share(outline.step_cost);
        let room = tokio::select! {
            biased;
            () = replaced(&mut turn) => None,
            room = share.take(peer, outline.memory) => room,
        };
        drop(queue);
        let record = Record::new(outline, Status::running());
        let mut job = Job::new(record, None, peer, self.shared());
        job.trace = trace;
        let job = Arc::new(job);
        if room.is_none() {
            job.request_cancel();
        }
        let system = Arc::new(SharedSystem::new(Arc::new(problem), similar));
        let run = job.begin(Arc::clone(&system), None);
        let attached = Attached::to_new(Arc::clone(&run), 0, peer);
        let (jobs, driven) = (Arc::clone(self), Arc::clone(&job));
        tokio::spawn(async move {
            tokio::select! {
                () = replaced(&mut turn) => driven.request_cancel(),
                _ = driven.ended() => {}
            }
        });
        jobs.start_driving(Arc::clone(&job), Some(run), slot);
        self.resources.counters.ephemeral.inc();
        Ok(Ephemeral {
            job,
            run: attached,
            system,
            stream,
            room,
        })
    }
}

/// Completes when there is a newer edit; never without a session.
async fn replaced(turn: &mut Option<SessionTurn>) {
    match turn {
        Some(turn) => turn.replaced().await,
        None => std::future::pending().await,
    }
}
