//! The state of a run: its recent frames, its readers, and why it ended.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use tokio::sync::Notify;

use super::ring::FrameRing;
use super::shared::SharedSystem;
use crate::job::frame::Frame;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use crate::job::state::{Failure, Levels, Reason, State};
use piad_fit::engine::{Iteration, Level, Outcome, System};

/// Why a run has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The iteration has ended.
    Outcome(Outcome),
    /// It was stopped.
    Stopped,
    /// The computation panicked, which is a bug.
    Broken,
    /// Its memory was given to another run.
    Revoked,
}

impl Ending {
    /// The final state of a job whose run has ended like this, with the reason, and the failure of a failed one.
    pub(crate) fn verdict(self) -> (State, Option<Reason>, Option<Failure>) {
        match self {
            Self::Outcome(outcome) => match outcome {
                Outcome::Converged => (State::Converged, None, None),
                Outcome::Minimum => (State::Converged, Some(Reason::Minimum), None),
                Outcome::Exhausted => (State::Exhausted, None, None),
                Outcome::Stalled(reason) => (State::Stalled, Some(reason), None),
                Outcome::Overflow => (State::Failed, None, Some(Failure::Overflow)),
            },
            Self::Broken => (State::Failed, None, Some(Failure::Defect)),
            // Primary runs are never revoked.
            Self::Stopped | Self::Revoked => (State::Cancelled, None, None),
        }
    }
}

/// The outcome of looking for a frame in a run.
#[derive(Debug)]
pub(crate) enum FrameLookup {
    Frame(Arc<Frame>),
    /// The run has not reached it yet.
    Later,
    /// It has left the ring: only another run can compute it again.
    Gone,
    /// The run has ended before it.
    Ended,
    /// The run was stopped before it: another run can continue.
    Stopped,
}

#[derive(Debug)]
pub(super) struct RunState {
    /// `None` before the first slice, while a slice works on it, and after the end.
    pub(super) iteration: Option<Iteration>,
    /// A slice is running.
    pub(super) working: bool,
    /// The system; `None` once the run was revoked.
    pub(super) shared: Option<Arc<SharedSystem>>,
    /// The memory of the run, until it has ended.
    pub(super) permit: Option<Permit>,
    /// True if it runs to its end, with or without readers.
    pub(super) to_the_end: bool,
    pub(super) begun: Instant,
    /// When a frame was last requested.
    pub(super) touched: Instant,
    /// At least one frame has been delivered.
    pub(super) delivered: bool,
    /// Kept after the end of the iteration, for edits and later readers.
    pub(super) system: Option<Arc<System>>,
    pub(super) levels: Option<Levels>,
    /// The highest level that is wanted.
    pub(super) wanted: Option<usize>,
    pub(super) scheduled: bool,
    pub(super) ring: FrameRing,
    pub(super) readers: BTreeMap<u64, Follower>,
    pub(super) next_reader: u64,
    pub(super) ending: Option<Ending>,
    /// The frame of the last level.
    pub(super) last: Option<Arc<Frame>>,
}

/// A reader of the run.
#[derive(Debug)]
pub(super) struct Follower {
    /// The frame that it wants next.
    pub(super) next: usize,
    pub(super) peer: Option<Peer>,
    /// Notified when that frame is there, when the run has ended, and when another reader has left.
    pub(super) news: Arc<Notify>,
}

impl RunState {
    pub(super) fn new(system: Arc<SharedSystem>, permit: Option<Permit>) -> Self {
        let now = Instant::now();
        Self {
            iteration: None,
            working: false,
            shared: Some(system),
            permit,
            to_the_end: false,
            begun: now,
            touched: now,
            delivered: false,
            system: None,
            levels: None,
            wanted: None,
            scheduled: false,
            ring: FrameRing::default(),
            readers: BTreeMap::new(),
            next_reader: 0,
            ending: None,
            last: None,
        }
    }

    pub(super) fn has_work(&self) -> bool {
        let reached = self.levels.map(|levels| levels.last.iteration);
        self.ending.is_none() && self.wanted.is_some() && reached < self.wanted
    }

    /// Adds a reader whose next frame is `next`; returns its number and its notification.
    pub(super) fn add_reader(&mut self, next: usize, peer: Option<Peer>) -> (u64, Arc<Notify>) {
        let (number, news) = (self.next_reader, Arc::<Notify>::default());
        self.next_reader += 1;
        let reader = Follower {
            next,
            peer,
            news: Arc::clone(&news),
        };
        self.readers.insert(number, reader);
        (number, news)
    }

    /// Notifies the readers that want a frame up to this one: those of far ones sleep.
    pub(super) fn tell(&self, level: usize) {
        let waiting = self.readers.values().filter(|it| it.next <= level);
        waiting.for_each(|reader| reader.news.notify_one());
    }

    /// The first level that a reader wants of a run that recomputes.
    pub(super) fn first_wanted(&self) -> Option<usize> {
        self.first_read().filter(|_| !self.to_the_end)
    }

    /// The next level that is wanted itself, not only on the way to another one.
    pub(super) fn next_seen(&self) -> usize {
        let wanted = self.wanted.unwrap_or(0);
        self.first_read().map_or(wanted, |read| read.min(wanted))
    }

    /// Limits the wanted level to levels that a reader wants: further ones would push those out of the ring, which
    /// would be recomputed forever.
    pub(super) fn look_ahead_no_more(&mut self) {
        if !self.to_the_end {
            let last_read = self.readers.values().map(|reader| reader.next).max();
            self.wanted = self.wanted.min(last_read);
        }
    }

    /// The first level that a reader wants.
    fn first_read(&self) -> Option<usize> {
        self.readers.values().map(|reader| reader.next).min()
    }

    pub(super) fn is_read(&self, level: usize) -> bool {
        self.readers.values().any(|reader| reader.next <= level)
    }

    pub(super) fn reached(&mut self, level: Level, system: &Arc<System>) {
        self.system.get_or_insert_with(|| Arc::clone(system));
        let first = self.levels.map_or(level, |levels| levels.first);
        self.levels = Some(Levels {
            first,
            last: level,
            forecast: system.forecast(),
        });
    }

    pub(super) fn end(&mut self, ending: Ending) {
        if self.ending.is_none() {
            self.ending = Some(ending);
            self.iteration = None;
            self.scheduled = false;
            if !self.working {
                self.permit = None;
            }
        }
    }

    /// Returns true if it has reached this level.
    pub(super) fn has_reached(&self, level: usize) -> bool {
        let reached = self.levels.map(|levels| levels.last.iteration);
        reached >= Some(level)
    }

    pub(super) fn read(&self, index: usize) -> FrameLookup {
        if self.ending == Some(Ending::Revoked) {
            return FrameLookup::Gone;
        }
        if !self.has_reached(index) {
            return match self.ending {
                None => FrameLookup::Later,
                Some(Ending::Stopped) => FrameLookup::Stopped,
                Some(_) => FrameLookup::Ended,
            };
        }
        let frame = self.ring.get(index).map(Arc::clone);
        frame.map_or(FrameLookup::Gone, FrameLookup::Frame)
    }
}
