//! A batch from its body to its answer: reads, computes and sends at the same time.

use std::collections::VecDeque;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::body::Body;
use bytes::Bytes;
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::answer::{Lines, Output};
use super::arrival::{Arrival, Arrived};
use super::item::Item;
use super::pieces::Piece;
use super::settings::Settings;
use super::splitter::Splitter;
use super::task::Running;
use crate::api::create_job::{self, PARSED_AT_ONCE};
use crate::api::http::body_limits::{ARRIVING, SMALL, check_rate, take_memory};
use crate::api::http::coding::Coding;
use crate::api::json::view::batch::BatchTotals;
use crate::api::problem::{Kind, Problem};
use crate::job::memory::Permit;
use crate::job::peer;
use crate::job::scheduler::WorkLane;
use crate::job::service::batch::BatchPlace;

/// The groups of a batch for each thread of the compute pool: one that is computed, and one that waits.
const GROUPS_PER_THREAD: usize = 2;

/// The most items of a group, and the bytes that are enough for one.
const MOST_ITEMS: usize = 64;
const ENOUGH_BYTES: usize = 64 * 1024;

/// How long a group should take: long enough to amortize its hand-over, and short enough for equal shares of the
/// threads.
const GROUP_TIME: Duration = Duration::from_millis(1);

/// From this size on, an item that has not arrived completely takes memory of its own.
const LARGE: usize = 2 * SMALL;

/// How long the rest of a body is read and discarded after an error, so that clients still sending it receive the
/// answer.
const DISCARDING: Duration = Duration::from_secs(2);

/// A batch that is being read.
pub(in crate::api) struct Batch {
    settings: Arc<Settings>,
    begun: Instant,
    arrival: Arrival,
    splitter: Splitter,
    /// The memory of an item that has not arrived completely, its bytes, and since when it is large.
    large: Option<Permit>,
    large_bytes: usize,
    large_since: Option<Instant>,
    /// Items that belong to no group yet, and their bytes.
    pending: Vec<Item>,
    pending_bytes: usize,
    /// The number of items so far.
    items: usize,
    /// The number of items of the next group.
    group_size: usize,
    /// Groups whose lines have not been sent, in order.
    groups: VecDeque<Running>,
    most_groups: usize,
    /// The body has ended, or why it is not read any more.
    end: Option<Result<(), Problem>>,
    totals: BatchTotals,
    _place: BatchPlace,
}

/// Cancels the computation of a batch when it is dropped.
struct CancelledAtEnd(Arc<Settings>);

impl Drop for CancelledAtEnd {
    fn drop(&mut self) {
        self.0.cancelled.store(true, Ordering::Release);
    }
}

impl Batch {
    /// Begins to read a batch for the current peer. When this returns, there is an item, or the body has ended; an
    /// error before the first item is returned.
    pub(in crate::api) async fn begin(
        settings: Arc<Settings>,
        body: Body,
        coding: Option<Coding>,
    ) -> Result<Self, Problem> {
        let app = &settings.app;
        create_job::check_open(app)?;
        let place = app.jobs.begin_batch()?;
        let limit = usize::try_from(app.config.max_body.as_u64()).unwrap_or(usize::MAX);
        let mut batch = Self {
            begun: Instant::now(),
            arrival: Arrival::begin(app, body, coding),
            splitter: Splitter::new(settings.body, limit),
            large: None,
            large_bytes: 0,
            large_since: None,
            pending: Vec::new(),
            pending_bytes: 0,
            items: 0,
            group_size: 1,
            groups: VecDeque::new(),
            most_groups: GROUPS_PER_THREAD * app.config.worker_count(),
            end: None,
            totals: BatchTotals::default(),
            _place: place,
            settings,
        };
        while batch.pending.is_empty() && batch.end.is_none() {
            batch.cut().await;
            if batch.wants_more() && batch.pending.is_empty() {
                let arrived = batch.arrival.next().await;
                batch.take(arrived).await;
            }
        }
        match batch.end.take() {
            Some(Err(problem)) if batch.pending.is_empty() => Err(problem),
            end => {
                batch.end = end;
                Ok(batch)
            }
        }
    }

    /// Its settings.
    pub(super) fn settings(&self) -> &Arc<Settings> {
        &self.settings
    }

    /// Computes it, and sends the results.
    pub(super) fn run(self) -> mpsc::Receiver<Output> {
        let (output, answer) = mpsc::channel(1);
        let cancelled = CancelledAtEnd(Arc::clone(&self.settings));
        peer::spawn(async move {
            let _cancelled = cancelled;
            self.drive(output).await;
        });
        answer
    }

    async fn drive(mut self, output: mpsc::Sender<Output>) {
        let app = self.settings.app.clone();
        let end = tokio::select! {
            () = output.closed() => return,
            () = app.stopped() => Err(create_job::stopping()),
            end = self.compute(&output) => end,
        };
        self.groups.clear();
        let end = end.map(|()| BatchTotals {
            items: self.totals.converged + self.totals.failed,
            seconds: self.begun.elapsed().as_secs_f64(),
            ..self.totals
        });
        let is_error = end.is_err();
        if output.send(Output::End(end)).await.is_ok() && is_error {
            let _ = timeout(DISCARDING, self.discard()).await;
        }
    }

    /// Reads and computes everything, and sends the lines of items in order.
    async fn compute(&mut self, output: &mpsc::Sender<Output>) -> Result<(), Problem> {
        loop {
            self.cut().await;
            while !self.pending.is_empty() && self.groups.len() < self.most_groups {
                let items = mem::take(&mut self.pending);
                self.pending_bytes = 0;
                self.groups.push_back(Running::begin(&self.settings, items));
                self.cut().await;
            }
            let wants_more = self.wants_more();
            let front = self.groups.front_mut();
            if front.is_none()
                && let Some(end) = &self.end
            {
                return end.clone();
            }
            tokio::select! {
                lines = next(front) => match lines {
                    Some(lines) => self.send(lines, output).await?,
                    None => self.end_group().await,
                },
                arrived = self.arrival.next(), if wants_more => self.take(arrived).await,
            }
        }
    }

    /// Returns true if there should be more bytes.
    fn wants_more(&self) -> bool {
        self.end.is_none() && !self.is_full()
    }

    /// Returns true if there are enough items for a group.
    fn is_full(&self) -> bool {
        self.pending.len() >= self.group_size || self.pending_bytes >= ENOUGH_BYTES
    }

    /// Cuts items out of the received bytes until there are enough for a group, or no more bytes are available.
    async fn cut(&mut self) {
        while self.wants_more() {
            match self.splitter.next() {
                Ok(Some(piece)) => self.add(piece).await,
                Ok(None) if self.splitter.waiting() > LARGE => return,
                Ok(None) => match self.arrival.ready() {
                    None => return,
                    Some(arrived) => self.take(arrived).await,
                },
                Err(problem) => self.end = Some(Err(problem)),
            }
        }
    }

    /// Adds bytes that have arrived.
    async fn take(&mut self, arrived: Result<Arrived, Problem>) {
        match arrived {
            Err(problem) => self.end = Some(Err(problem)),
            Ok(arrived) if arrived.bytes.is_empty() => match self.splitter.finish() {
                Err(problem) => self.end = Some(Err(problem)),
                Ok(piece) => {
                    if let Some(piece) = piece {
                        self.add(piece).await;
                    }
                    self.end.get_or_insert(Ok(()));
                }
            },
            Ok(arrived) => {
                self.splitter.push(&arrived.bytes);
                if let Err(problem) = self.make_room().await {
                    self.end = Some(Err(problem));
                }
            }
        }
    }

    /// Takes memory for an item that is large and has not arrived completely.
    async fn make_room(&mut self) -> Result<(), Problem> {
        let waiting = self.splitter.waiting();
        if waiting <= LARGE {
            return Ok(());
        }
        let app = &self.settings.app;
        let since = *self.large_since.get_or_insert_with(Instant::now);
        check_rate(&app.config, since, waiting)?;
        let needed = ARRIVING.saturating_mul(waiting.next_power_of_two());
        if needed > self.large_bytes {
            let bodies = &app.jobs.resources().memory.bodies;
            take_memory(bodies, &mut self.large, needed - self.large_bytes).await?;
            self.large_bytes = needed;
        }
        Ok(())
    }

    async fn add(&mut self, piece: Piece) {
        let is_large = matches!(&piece, Piece::Defaults(it) | Piece::Item(it) if it.len() > SMALL);
        let memory = self.large.take_if(|_| is_large);
        if memory.is_some() {
            self.large_bytes = 0;
        }
        self.large_since = None;
        match piece {
            Piece::Item(bytes) => {
                self.pending_bytes += bytes.len();
                self.pending.push(Item {
                    index: self.items,
                    bytes,
                    memory,
                });
                self.items += 1;
            }
            Piece::Defaults(bytes) => {
                if let Err(problem) = self.read_defaults(bytes).await {
                    self.end = Some(Err(problem));
                }
            }
        }
    }

    async fn read_defaults(&self, bytes: Bytes) -> Result<(), Problem> {
        if bytes.len() <= PARSED_AT_ONCE {
            return self.settings.set_common(&bytes);
        }
        let settings = Arc::clone(&self.settings);
        let scheduler = &self.settings.app.jobs.resources().scheduler;
        let read = move || settings.set_common(&bytes);
        scheduler.compute(WorkLane::Wire, read).await?
    }

    /// Sends lines; the batch ends with its last line.
    async fn send(
        &mut self,
        mut lines: Lines,
        output: &mpsc::Sender<Output>,
    ) -> Result<(), Problem> {
        self.totals.converged += lines.converged;
        self.totals.failed += lines.failed;
        let fatal = lines.fatal.take();
        for content in lines.into_contents() {
            let gone = |_| Problem::new(Kind::Internal, "the client has disconnected");
            output.send(Output::Lines(content)).await.map_err(gone)?;
        }
        fatal.map_or(Ok(()), Err)
    }

    /// Drops the first group, whose lines have all been sent, and adapts the size of the next ones to its pace.
    async fn end_group(&mut self) {
        let Some(group) = self.groups.pop_front() else {
            return;
        };
        let Some(pace) = group.pace().await else {
            let detail = "some items could not be computed";
            self.end = Some(Err(Problem::new(Kind::Internal, detail)));
            return;
        };
        let due = GROUP_TIME.as_nanos() / pace.as_nanos().max(1);
        let due = usize::try_from(due).unwrap_or(MOST_ITEMS);
        self.group_size = due.clamp(1, MOST_ITEMS).min(2 * self.group_size);
    }

    /// Reads the rest of the body.
    async fn discard(&mut self) {
        while self
            .arrival
            .next()
            .await
            .is_ok_and(|it| !it.bytes.is_empty())
        {}
    }
}

/// The next lines of a group; pending forever without one.
async fn next(group: Option<&mut Running>) -> Option<Lines> {
    match group {
        Some(group) => group.next().await,
        None => std::future::pending().await,
    }
}
