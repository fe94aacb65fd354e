//! A reader's hold on a run.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::Notify;

use super::{FrameLookup, LOOK_AHEAD, Run};
use crate::job::peer::Peer;
use crate::job::reader_budget::LONGEST_WAIT;

/// A reader's hold on a run: while there is one, the run keeps its recent frames.
#[derive(Debug)]
pub(crate) struct Attached {
    run: Arc<Run>,
    reader: u64,
    news: Arc<Notify>,
    peer: Option<Peer>,
}

impl Run {
    /// Becomes a reader from frame `next` on, if the run can still deliver that frame. A stopped run is left if the job
    /// `goes_on`, or has continued, without it.
    pub(crate) fn attach(
        self: &Arc<Self>,
        next: usize,
        peer: Option<Peer>,
        goes_on: bool,
    ) -> Option<Attached> {
        let mut state = self.state.lock();
        match state.read(next) {
            FrameLookup::Gone => return None,
            FrameLookup::Stopped if goes_on => return None,
            _ => {}
        }
        let (reader, news) = state.add_reader(next, peer);
        drop(state);
        Some(Attached {
            run: Arc::clone(self),
            reader,
            news,
            peer,
        })
    }
}

impl Attached {
    /// The first reader of a new run, from frame `next` on.
    pub(crate) fn to_new(run: Arc<Run>, next: usize, peer: Option<Peer>) -> Self {
        let (reader, news) = run.state.lock().add_reader(next, peer);
        Self {
            run,
            reader,
            news,
            peer,
        }
    }

    /// Asks the run for frame `index`, the next one that the reader wants.
    pub(crate) fn read(&self, index: usize) -> FrameLookup {
        let mut state = self.run.state.lock();
        if let Some(reader) = state.readers.get_mut(&self.reader) {
            reader.next = index;
        }
        state.touched = Instant::now();
        let read = state.read(index);
        state.delivered |= matches!(read, FrameLookup::Frame(_));
        read
    }

    /// Lets the run advance to frame `index`, and a little further if frames are small, unless that pushed the next
    /// frame of another reader out of the ring. So readers of large frames with about the same speed share one run.
    ///
    /// If the run has to wait for another reader, this returns until when, at most; then the caller
    /// calls it again. `waiting` is the time since which it has been waiting.
    pub(crate) fn want(&self, index: usize, waiting: &mut Option<Instant>) -> Option<Instant> {
        let lost = self.lost_before(index);
        let now = Instant::now();
        let since = waiting.unwrap_or(now);
        let mut until = None;
        let mut state = self.run.state.lock();
        for reader in state.readers.values_mut().filter(|it| it.next < lost) {
            let left = self.left_for(reader.peer, since, now);
            if left.is_zero() {
                // Its time is up: it will need its own run.
                reader.next = usize::MAX;
            }
            until = until.max(Some(now + left).filter(|until| *until > now));
        }
        drop(state);
        *waiting = until.map(|_| since);
        if until.is_none() {
            self.advance(index);
        }
        until
    }

    /// How much longer to wait for a reader of this peer.
    fn left_for(&self, peer: Option<Peer>, since: Instant, now: Instant) -> Duration {
        let left = LONGEST_WAIT.saturating_sub(now - since);
        if peer == self.peer {
            return left;
        }
        let budget = &self.run.reader_budget;
        budget.spend(peer, since, now);
        left.min(budget.left(peer, now))
    }

    fn advance(&self, index: usize) {
        self.run.want(self.ahead_of(index));
    }

    fn ahead_of(&self, index: usize) -> usize {
        index.saturating_add(LOOK_AHEAD.min((self.run.capacity - 1) / 2))
    }

    /// Frames before this one leave the ring if the run advances as wanted.
    fn lost_before(&self, index: usize) -> usize {
        (self.ahead_of(index).saturating_add(1)).saturating_sub(self.run.capacity)
    }

    /// Completes when there is news for this reader, also since it last waited.
    pub(crate) async fn news(&self) {
        self.news.notified().await;
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        let mut state = self.run.state.lock();
        let gone = state.readers.remove(&self.reader);
        if state.readers.is_empty() && !state.to_the_end {
            // The readers of what was wanted are gone.
            state.wanted = None;
        }
        // Others may be waiting for this reader, if its next frame is there.
        if gone.is_some_and(|it| state.has_reached(it.next)) {
            state.tell(usize::MAX);
        }
    }
}
