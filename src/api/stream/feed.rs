//! A job as a sequence of events: the job, then every iteration from 0 on, then the end.
//!
//! Events are pulled: the next frame is requested when the connection has taken the one before. The data
//! of an iteration are encoded once for each form and shared by all feeds.

use std::collections::VecDeque;
use std::pin::pin;
use std::sync::Arc;

use futures_util::FutureExt;
use tokio::sync::watch;
use tokio::time::{Duration, Instant, sleep_until};
use tracing::error;

use super::chain::Chain;
use super::encode;
use super::milestones::Milestones;
use crate::api::app::App;
use crate::api::resume::{EventId, Start};
use crate::job::content::Content;
use crate::job::counters::Open;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::memory::Permit;
use crate::job::quota::OpenStream;
use crate::job::service::ephemeral::Ephemeral;
use crate::job::state::Status;
use crate::job::store::StoreError;
use crate::job::{Held, Job};
use crate::model::stream::options::StreamOptions;

/// An event of a job, or of the connection. Data are JSON or a protobuf message, depending on the form
/// of the feed.
#[derive(Clone, Debug)]
pub(crate) enum Event {
    /// The description of the job, which does not change from iteration to iteration.
    Job {
        /// The description.
        data: Content,
        /// The stream restarts: the reader's events are of another kernel.
        again: bool,
    },
    Iteration {
        /// Its number, and its kernel.
        id: EventId,
        /// The smallest milestone that it is the first to reach.
        milestone: Option<f64>,
        /// Its errors and geometry.
        data: Content,
    },
    /// The end of the job.
    End(Content),
    /// Nothing has happened for a while.
    Quiet,
    /// The server stops; nothing follows.
    Stopping,
}

/// The state of a feed.
enum Stage {
    /// Before the `job` event, which has numbers that are known only when the job has begun.
    Waiting,
    Iterations,
    Over,
}

/// The event that ended a wait.
enum Happened {
    Next(Result<Next, StoreError>),
    Nothing,
    Stopping,
}

/// The events of one reader of a job.
pub(crate) struct Feed {
    job: Arc<Job>,
    cursor: Cursor,
    options: StreamOptions,
    /// Events are differences.
    chain: Option<Chain>,
    milestones: Option<Milestones>,
    /// The client has iterations of another kernel.
    again: bool,
    /// The last iteration that the client has.
    seen: Option<usize>,
    /// The last iteration that this stream has reported, with its knots if they were new.
    reported: Option<usize>,
    /// The client has received complete control points, to which changes can be applied.
    complete: bool,
    stage: Stage,
    /// Events that are ready: at most three at a time.
    pending: VecDeque<Event>,
    heartbeat: Duration,
    /// When the next heartbeat is due if there is no other event.
    quiet_until: Instant,
    stopping: watch::Receiver<bool>,
    _open: (Open, OpenStream),
    /// Held so that the feed can end properly even if the job is deleted.
    held: Held,
    /// Ephemeral edits: the level of the parent that they start from.
    before: Option<Arc<Frame>>,
    /// Ephemeral edits: their memory, held until the stream has ended.
    room: Option<Permit>,
}

impl Feed {
    /// The events of a job from there on.
    pub(crate) fn new(
        app: &App,
        job: Arc<Job>,
        options: StreamOptions,
        start: Start,
        held: Held,
        stream: OpenStream,
    ) -> Self {
        let cursor = Cursor::new(Arc::clone(&job), 0);
        Self::reading(app, job, cursor, options, start, held, stream)
    }

    /// The events of an ephemeral edit, which ends with them.
    pub(crate) fn of_ephemeral(
        app: &App,
        edit: Ephemeral,
        before: Arc<Frame>,
        options: StreamOptions,
    ) -> Self {
        let Ephemeral {
            job, run, stream, ..
        } = edit;
        let cursor = Cursor::attached(Arc::clone(&job), run);
        let held = Some(edit.system);
        let (every, selects) = (options.every, !options.milestones.is_empty());
        let mut feed = Self::reading(app, job, cursor, options, Start::First, held, stream);
        // Iteration 0 is the level of the parent, which a stream that skips iterations need not send.
        if every > 1 && !selects {
            feed.cursor.seek(every);
        }
        // The client has the control points of the parent.
        feed.complete = true;
        feed.before = Some(before);
        feed.room = edit.room;
        feed
    }

    fn reading(
        app: &App,
        job: Arc<Job>,
        mut cursor: Cursor,
        options: StreamOptions,
        start: Start,
        held: Held,
        stream: OpenStream,
    ) -> Self {
        if options.latest {
            cursor.only_latest(options.every);
        }
        let seen = match start {
            Start::After(k) => Some(k),
            Start::First | Start::Again => None,
        };
        let first = match seen {
            None => 0,
            // The last iteration seen is read again, to find the milestones that were reached by then.
            Some(k) if !options.milestones.is_empty() => k,
            Some(k) => k + 1,
        };
        cursor.seek(first.next_multiple_of(options.every));
        let milestones = Milestones::new(options.milestones.clone());
        let open = job.resources().counters.open_stream();
        Self {
            cursor,
            job,
            chain: Chain::new(&options),
            milestones: Some(milestones).filter(|milestones| !milestones.all_reached()),
            options,
            again: start == Start::Again,
            seen,
            reported: None,
            complete: false,
            stage: Stage::Waiting,
            pending: VecDeque::new(),
            heartbeat: app.config.heartbeat,
            quiet_until: Instant::now(),
            stopping: app.stopping.clone(),
            _open: (open, stream),
            held,
            before: None,
            room: None,
        }
    }

    /// The job of the events.
    pub(crate) fn job(&self) -> &Arc<Job> {
        &self.job
    }

    /// The next event. A feed that ends without `End` or `Stopping` has failed.
    pub(crate) async fn next(&mut self) -> Option<Event> {
        self.quiet_until = Instant::now() + self.heartbeat;
        loop {
            if let Some(event) = self.pending.pop_front() {
                return Some(event);
            }
            match self.stage {
                Stage::Waiting | Stage::Iterations => self.advance().await,
                Stage::Over => return None,
            }
        }
    }

    /// Waits for the next frame, the next heartbeat or the end of the server.
    async fn advance(&mut self) {
        let happened = {
            let mut next = pin!(self.cursor.next());
            // A frame that is ready is taken without setting up timers and wake-ups. A feed that skips frames has to
            // check its timer in between.
            let waits = *self.stopping.borrow() || self.milestones.is_some();
            let at_hand = (!waits).then(|| next.as_mut().now_or_never());
            match at_hand.flatten() {
                Some(next) => Happened::Next(next),
                None => tokio::select! {
                    next = next => Happened::Next(next),
                    () = sleep_until(self.quiet_until) => Happened::Nothing,
                    _ = self.stopping.wait_for(|stopping| *stopping) => Happened::Stopping,
                },
            }
        };
        match happened {
            Happened::Next(next) => {
                match self.push_next(next).await {
                    Ok(()) => {}
                    // The job was deleted before its points were read: reconnecting would be pointless.
                    Err(StoreError::Gone(_)) => self.push_end(&self.job.status()),
                    Err(reason) => {
                        // The client did not get the end, so it will reconnect.
                        error!(job = %self.job.id(), %reason, "a stream was interrupted");
                        self.stage = Stage::Over;
                    }
                }
            }
            Happened::Nothing => {
                self.quiet_until += self.heartbeat;
                self.pending.push_back(Event::Quiet);
            }
            Happened::Stopping => {
                self.pending.push_back(Event::Stopping);
                self.stage = Stage::Over;
            }
        }
    }

    /// Pushes the next frame or the end; before the first of these, the `job` event.
    async fn push_next(&mut self, next: Result<Next, StoreError>) -> Result<(), StoreError> {
        let next = next?;
        if matches!(self.stage, Stage::Waiting) {
            self.stage = Stage::Iterations;
            if self.held.is_none() {
                self.held = self.job.held().await?;
            }
            let data = encode::description(&self.job, &self.options).await?;
            let again = self.again;
            self.push(Event::Job { data, again });
        }
        match next {
            Next::Frame(frame) => self.take(&frame).await,
            Next::End(status) => self.finish(&status).await,
        }
    }

    /// Pushes a frame, unless milestones leave it out.
    async fn take(&mut self, frame: &Arc<Frame>) -> Result<(), StoreError> {
        let Some(milestones) = &mut self.milestones else {
            return self.push_frame(frame, None).await;
        };
        let milestone = milestones.reach(frame.level.error.max);
        if milestones.all_reached() {
            self.cursor.only_end();
        }
        let new = Some(frame.level.iteration) > self.seen;
        match milestone.filter(|_| new) {
            Some(milestone) => self.push_frame(frame, Some(milestone)).await?,
            // Lets other tasks run, however many frames are skipped.
            None => tokio::task::consume_budget().await,
        }
        Ok(())
    }

    async fn push_frame(
        &mut self,
        frame: &Arc<Frame>,
        milestone: Option<f64>,
    ) -> Result<(), StoreError> {
        let k = frame.level.iteration;
        let changes = self.options.changes.as_ref();
        let frame = &match &self.before {
            Some(before) if k == 0 && changes.is_some() => Arc::new(frame.since(before)),
            _ => Arc::clone(frame),
        };
        let form = changes
            .filter(|_| self.complete && frame.moved.is_some())
            .unwrap_or(&self.options.form);
        // Clients that resume a stream have the knots of level 0, from the `job` event.
        let known = self.reported.unwrap_or(0);
        let tells_knots = frame.knots_since > known;
        let data = match &mut self.chain {
            Some(chain) => chain.event(&self.job, frame, tells_knots).await?,
            None if tells_knots => encode::frame(&self.job, frame, &form.with_knots()).await?,
            None => encode::frame(&self.job, frame, form).await?,
        };
        self.reported = Some(k);
        let id = EventId::new(&self.job, k);
        self.push(Event::Iteration {
            id,
            milestone,
            data,
        });
        self.seen = Some(k);
        self.complete = true;
        if self.milestones.is_none() {
            let next = (k + 1).next_multiple_of(self.options.every);
            self.cursor.seek(next);
        }
        Ok(())
    }

    /// Pushes the last iteration, if it was left out so far, and the end.
    async fn finish(&mut self, status: &Status) -> Result<(), StoreError> {
        let last = status.levels.map(|levels| levels.last.iteration);
        let leaves_out = self.options.every > 1 || self.milestones.is_some();
        if leaves_out && let Some(last) = last.filter(|&last| Some(last) > self.seen) {
            self.cursor.seek(last);
            if let Next::Frame(frame) = self.cursor.next().await? {
                self.push_frame(&frame, None).await?;
            }
        }
        self.push_end(status);
        Ok(())
    }

    fn push_end(&mut self, status: &Status) {
        self.stage = Stage::Over;
        let data = encode::end(&self.job, status, &self.options.form);
        self.push(Event::End(data));
    }

    fn push(&mut self, event: Event) {
        self.job.resources().counters.events.inc();
        self.pending.push_back(event);
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        let gone = !matches!(self.stage, Stage::Over);
        if (gone && self.options.cancels) || !self.job.is_kept() {
            self.job.request_cancel();
        }
    }
}
