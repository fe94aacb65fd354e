//! A reader of a job, frame by frame, at its own pace.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::watch;
use tokio::time::sleep_until;

use super::Job;
use super::frame::Frame;
use super::peer::Peer;
use super::run::Read;
use super::run::attached::Attached;
use super::state::{State, Status};
use super::store::StoreError;

/// What a reader gets next.
#[derive(Debug)]
pub enum Next {
    /// The next frame.
    Frame(Arc<Frame>),
    /// There are no more; the job has ended with this status.
    End(Box<Status>),
}

/// Reads the frames of a job in order, without gaps, from any level on.
///
/// Nothing is computed ahead of a reader beyond a few frames, and nothing is kept for it: a reader
/// that is slower than the ring of the run it follows goes on with a run of its own.
pub struct Cursor {
    job: Arc<Job>,
    next: usize,
    run: Option<Attached>,
    /// Since when others are waited for, that would lose their next frame.
    waiting: Option<Instant>,
    peer: Option<Peer>,
    status: watch::Receiver<Status>,
    /// Frames that are not the newest are left out.
    latest: Option<usize>,
    /// The job was not over when reading began: if it is cancelled, reading ends at once.
    live: bool,
}

impl Cursor {
    /// A reader whose first frame is `next`, for the peer of the current task.
    pub fn new(job: Arc<Job>, next: usize) -> Self {
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

    /// From now on only the newest frame is of interest, of those whose level is a multiple of
    /// `every`; in the end it is the last.
    pub fn only_latest(&mut self, every: usize) {
        self.latest = Some(every);
    }

    /// The next frame to read will be `index`.
    pub fn seek(&mut self, index: usize) {
        self.next = index;
    }

    /// No more frames are wanted: the end comes next.
    pub fn only_end(&mut self) {
        self.next = usize::MAX;
        self.run = None;
    }

    /// The next frame, or the end. Giving up the wait loses nothing.
    pub async fn next(&mut self) -> Result<Next, StoreError> {
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
            match attempt(run, self.next, waiting, &mut self.status, job_ended).await {
                Attempt::Frame(frame) => {
                    self.waiting = None;
                    self.next += 1;
                    return Ok(Next::Frame(frame));
                }
                Attempt::TryAgain => {}
                // Where only the newest frame counts, there is a newer one by now.
                Attempt::Leave if self.latest.is_some() && !job_ended => {}
                Attempt::Leave => self.run = None,
            }
        }
    }

    /// The last frame of a job that has ended is at hand, whoever computed it.
    async fn last_frame(&self, status: &Status) -> Result<Option<Arc<Frame>>, StoreError> {
        let Some(level) = status.levels.map(|levels| levels.last) else {
            return Ok(None);
        };
        if level.iteration != self.next || self.run.is_some() {
            return Ok(None);
        }
        let points = match self.job.result().await {
            // It was deleted, but can be computed again.
            Err(StoreError::Gone(_)) => None,
            points => points?,
        };
        Ok(points.map(|points| Arc::new(Frame::last(level, points))))
    }
}

/// What came of trying to read a frame.
enum Attempt {
    Frame(Arc<Frame>),
    /// Something has changed since.
    TryAgain,
    /// This run will not deliver the frame; another one can.
    Leave,
}

async fn attempt(
    run: &Attached,
    index: usize,
    waiting: &mut Option<Instant>,
    status: &mut watch::Receiver<Status>,
    job_ended: bool,
) -> Attempt {
    // Nearly always it is there.
    if let Read::Frame(frame) = run.read(index) {
        return Attempt::Frame(frame);
    }
    let mut advanced = std::pin::pin!(run.changed());
    // From here on no advance goes unnoticed.
    advanced.as_mut().enable();
    match run.read(index) {
        Read::Frame(frame) => return Attempt::Frame(frame),
        // Out of the ring, or a run that was stopped.
        Read::Gone => return Attempt::Leave,
        Read::Ended if job_ended => return Attempt::Leave,
        Read::Ended => changed(status).await,
        Read::Later => {
            let until = run.want(index, waiting);
            tokio::select! {
                () = advanced => {}
                () = changed(status) => {}
                () = time(until) => {}
            }
        }
    }
    Attempt::TryAgain
}

/// Waits for a time; for ever if there is none.
async fn time(until: Option<Instant>) {
    match until {
        Some(until) => sleep_until(until.into()).await,
        None => std::future::pending().await,
    }
}

/// Waits for a change of the job's state; for ever if there will be none.
async fn changed(status: &mut watch::Receiver<Status>) {
    if status.changed().await.is_err() {
        std::future::pending().await
    }
}
