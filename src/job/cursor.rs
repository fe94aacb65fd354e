//! A reader of a job, frame by frame, at its own pace.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::watch;
use tokio::time::sleep_until;

use super::Job;
use super::frame::Frame;
use super::peer::Peer;
use super::run::FrameLookup;
use super::run::attached::Attached;
use super::state::{State, Status};
use super::store::StoreError;

/// The next item of a reader.
#[derive(Debug)]
pub(crate) enum Next {
    /// The next frame.
    Frame(Arc<Frame>),
    /// There are no more; the job has ended with this status.
    End(Box<Status>),
}

/// Reads the frames of a job in order, without gaps, from any level on.
///
/// At most a few frames are computed ahead of a reader, and none are kept for it: a reader that falls out of the ring
/// of its run continues with a run of its own.
pub(crate) struct Cursor {
    job: Arc<Job>,
    next: usize,
    run: Option<Attached>,
    /// Since when it has been waiting for readers that would lose their next frame.
    waiting: Option<Instant>,
    peer: Option<Peer>,
    status: watch::Receiver<Status>,
    /// If set, only the newest frame whose level is a multiple of this is read.
    latest: Option<usize>,
    /// The job had not ended when reading began: if it is cancelled, reading ends at once.
    live: bool,
}

impl Cursor {
    /// A reader whose first frame is `next`, for the peer of the current task.
    pub(crate) fn new(job: Arc<Job>, next: usize) -> Self {
        let status = job.status.subscribe();
        let live = !status.borrow().state.is_final();
        Self {
            job,
            next,
            run: None,
            waiting: None,
            peer: Peer::current(),
            status,
            latest: None,
            live,
        }
    }

    /// A reader that is attached to a run of the job already.
    pub(crate) fn attached(job: Arc<Job>, run: Attached) -> Self {
        Self {
            run: Some(run),
            ..Self::new(job, 0)
        }
    }

    /// From now on the reader skips to the newest frame whose level is a multiple of `every`; when the
    /// job has ended, to the last frame.
    pub(crate) fn only_latest(&mut self, every: usize) {
        self.latest = Some(every);
    }

    /// The next frame to read will be `index`.
    pub(crate) fn seek(&mut self, index: usize) {
        // Where frames are skipped, another run may need fewer steps: most often that of the job.
        if index > self.next && self.run.is_some() {
            self.run = self.job.attach_to_live(index, self.peer);
        }
        self.next = index;
    }

    /// Skips all remaining frames: the end comes next.
    pub(crate) fn only_end(&mut self) {
        self.next = usize::MAX;
        self.run = None;
    }

    /// The next frame, or the end. It is cancel-safe: a future that is dropped loses no frame.
    pub(crate) async fn next(&mut self) -> Result<Next, StoreError> {
        loop {
            let status = self.status.borrow_and_update().clone();
            let job_ended = status.state.is_final();
            if let Some(every) = self.latest {
                let newest = self.job.status().levels;
                let newest = newest.map_or(0, |levels| levels.last.iteration);
                let newest = match job_ended {
                    true => newest,
                    false => newest.next_multiple_of(every),
                };
                self.next = self.next.max(newest);
            }
            if job_ended {
                let given_up = self.live && status.state == State::Cancelled;
                let last = status.levels.map(|levels| levels.last.iteration);
                if given_up || last < Some(self.next) {
                    return Ok(Next::End(Box::new(status)));
                }
                if let Some(frame) = self.last_frame(&status).await? {
                    self.next += 1;
                    return Ok(Next::Frame(frame));
                }
            } else if status.state == State::Queued || self.next == usize::MAX {
                changed(&mut self.status).await;
                continue;
            }
            let run = match &mut self.run {
                Some(run) => run,
                none => none.insert(self.job.attach(self.next, self.peer).await?),
            };
            let waiting = &mut self.waiting;
            let goes_on = job_ended || self.job.continues_without_its_run();
            match attempt(run, self.next, waiting, &mut self.status, goes_on).await {
                Attempt::Frame(frame) => {
                    self.waiting = None;
                    self.next += 1;
                    return Ok(Next::Frame(frame));
                }
                // The job has more levels than are computed here: by another version of the program.
                Attempt::Ended if job_ended => return Ok(Next::End(Box::new(status))),
                Attempt::Ended => changed(&mut self.status).await,
                Attempt::TryAgain => {}
                // A reader of the newest frame looks for a newer one.
                Attempt::Passed if self.latest.is_some() && !job_ended => {}
                Attempt::Passed | Attempt::Leave => self.run = None,
            }
        }
    }

    /// The last frame of a job that has ended, made from its stored result.
    async fn last_frame(&self, status: &Status) -> Result<Option<Arc<Frame>>, StoreError> {
        let Some(level) = status.levels.map(|levels| levels.last) else {
            return Ok(None);
        };
        if level.iteration != self.next || self.run.is_some() {
            return Ok(None);
        }
        match self.job.last_frame(level).await {
            // The job was deleted; the frame can still be computed again.
            Err(StoreError::Gone(_)) => Ok(None),
            frame => frame,
        }
    }
}

/// The outcome of an attempt to read a frame.
enum Attempt {
    Frame(Arc<Frame>),
    /// The run or the job has changed in the meantime.
    TryAgain,
    /// The frame has left the ring: only another run can deliver it.
    Passed,
    /// The run was stopped: only another one can deliver the frame.
    Leave,
    /// The fit ends before the frame.
    Ended,
}

async fn attempt(
    run: &Attached,
    index: usize,
    waiting: &mut Option<Instant>,
    status: &mut watch::Receiver<Status>,
    goes_on: bool,
) -> Attempt {
    match run.read(index) {
        FrameLookup::Frame(frame) => return Attempt::Frame(frame),
        FrameLookup::Gone => return Attempt::Passed,
        FrameLookup::Stopped if goes_on => return Attempt::Leave,
        FrameLookup::Stopped => changed(status).await,
        FrameLookup::Ended => return Attempt::Ended,
        FrameLookup::Later => {
            let until = run.want(index, waiting);
            tokio::select! {
                () = run.news() => {}
                () = changed(status) => {}
                () = time(until) => {}
            }
        }
    }
    Attempt::TryAgain
}

/// Waits until this time, or forever without one.
async fn time(until: Option<Instant>) {
    match until {
        Some(until) => sleep_until(until.into()).await,
        None => std::future::pending().await,
    }
}

/// Waits for a change of the job's status, or forever if there can be none any more.
async fn changed(status: &mut watch::Receiver<Status>) {
    if status.changed().await.is_err() {
        std::future::pending().await
    }
}

#[cfg(test)]
mod tests;
