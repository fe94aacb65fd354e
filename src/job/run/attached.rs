//! A reader's hold on a run.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::futures::Notified;

use super::{LOOK_AHEAD, Read, Reader, Run};
use crate::job::patience::PATIENCE;
use crate::job::peer::Peer;

/// A reader's hold on a run: while there is one, the run keeps its recent frames.
#[derive(Debug)]
pub struct Attached {
    run: Arc<Run>,
    reader: u64,
    peer: Option<Peer>,
}

impl Run {
    /// Becomes a reader from frame `next` on, if the run can still deliver that frame.
    pub fn attach(self: &Arc<Self>, next: usize, peer: Option<Peer>) -> Option<Attached> {
        let mut state = self.state.lock();
        if matches!(state.read(next), Read::Gone) {
            return None;
        }
        let reader = state.add_reader(Reader { next, peer });
        drop(state);
        let run = Arc::clone(self);
        Some(Attached { run, reader, peer })
    }
}

impl Attached {
    /// The first reader of a run, from frame `next` on.
    pub fn to_new(run: Arc<Run>, next: usize, peer: Option<Peer>) -> Self {
        let reader = run.state.lock().add_reader(Reader { next, peer });
        Self { run, reader, peer }
    }

    /// What the run has to say about frame `index`, which is the next one that the reader wants.
    pub fn read(&self, index: usize) -> Read {
        let mut state = self.run.state.lock();
        if let Some(reader) = state.readers.get_mut(&self.reader) {
            reader.next = index;
        }
        state.touched = Instant::now();
        let read = state.read(index);
        state.delivered |= matches!(read, Read::Frame(_));
        read
    }

    /// Lets the run advance to frame `index`, and a little further where frames are small; unless
    /// another reader would lose its next frame by that. Readers of large frames that go together
    /// share one run, and one that is a moment slower does not need a run of its own.
    ///
    /// Says until when to wait for the others, at most, and then to call this again; and knows from
    /// `waiting` since when they are waited for.
    pub fn want(&self, index: usize, waiting: &mut Option<Instant>) -> Option<Instant> {
        let lost = self.lost_before(index);
        let now = Instant::now();
        let since = waiting.unwrap_or(now);
        let mut until = None;
        let mut state = self.run.state.lock();
        for reader in state.readers.values_mut().filter(|it| it.next < lost) {
            let left = self.left_for(reader.peer, since, now);
            if left.is_zero() {
                // It has had its time, and will need a run of its own.
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

    /// How much longer to wait for a reader of a peer.
    fn left_for(&self, peer: Option<Peer>, since: Instant, now: Instant) -> Duration {
        let left = PATIENCE.saturating_sub(now - since);
        if peer == self.peer {
            return left;
        }
        let patience = &self.run.patience;
        patience.spend(peer, since, now);
        left.min(patience.left(peer, now))
    }

    fn advance(&self, index: usize) {
        self.run.want(self.ahead_of(index));
    }

    fn ahead_of(&self, index: usize) -> usize {
        index.saturating_add(LOOK_AHEAD.min((self.run.capacity - 1) / 2))
    }

    /// Frames before this one go out of the ring if the run advances as wanted.
    fn lost_before(&self, index: usize) -> usize {
        (self.ahead_of(index).saturating_add(1)).saturating_sub(self.run.capacity)
    }

    /// Completes at the next change of the run after this call.
    pub fn changed(&self) -> Notified<'_> {
        self.run.changed.notified()
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        let mut state = self.run.state.lock();
        state.readers.remove(&self.reader);
        if state.readers.is_empty() && !state.to_the_end {
            // Nobody waits for what was wanted.
            state.wanted = None;
        }
        drop(state);
        // Others may have waited for this one.
        self.run.changed.notify_waiters();
    }
}
