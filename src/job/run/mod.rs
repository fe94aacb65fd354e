//! A run: an iteration that several readers share. It advances only as far as a reader, or the job itself, needs it.
//!
//! - `state`: its progress; `ring`: its recent frames;
//! - `shared`: the system that it iterates;
//! - [`attached`]: a reader's hold on it.

pub(crate) mod attached;
mod ring;
mod shared;
mod state;

use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::{Mutex, MutexGuard};
use tokio::sync::Notify;

pub(crate) use shared::SharedSystem;
pub(crate) use state::{Ending, FrameLookup};

use crate::job::checkpoints::Checkpoints;
use crate::job::frame::Frame;
use crate::job::memory::Permit;
use crate::job::peer::Peer;
use crate::job::reader_budget::ReaderBudget;
use crate::job::resources::Resources;
use crate::job::scheduler::{Turn, Work, WorkLane};
use crate::job::state::Levels;
use crate::job::trace::JobTrace;
use piad_fit::engine::sweep::LEVELS;
use piad_fit::engine::{Iteration, Level, Outcome, System, interrupt};
use state::RunState;

/// The most levels that a run may be ahead of its readers.
const LOOK_AHEAD: usize = 32;

/// A shared iteration with a bounded ring of recent frames.
#[derive(Debug)]
pub(crate) struct Run {
    resources: Arc<Resources>,
    /// The peer whose turns it takes.
    peer: Option<Peer>,
    /// The lane of the first slice, which builds the system, and that of the steps.
    lanes: [WorkLane; 2],
    /// The number of frames of the ring, at least one.
    capacity: usize,
    frame_bytes: usize,
    /// Bytes of the iteration.
    bytes: usize,
    /// True if frames of this run are small enough to be kept before they are read.
    keeps_unread: bool,
    reader_budget: Arc<ReaderBudget>,
    state: Mutex<RunState>,
    /// Notified when it has ended.
    ended: Notify,
    stopped: Arc<AtomicBool>,
    trace: Arc<JobTrace>,
}

impl Run {
    /// A run for a peer that has not begun, with the memory that it takes and the spans that it adds to.
    pub(crate) fn new(
        system: Arc<SharedSystem>,
        resources: Arc<Resources>,
        permit: Option<Permit>,
        peer: Option<Peer>,
        trace: Arc<JobTrace>,
    ) -> Arc<Self> {
        let problem = &system.problem;
        let weight = Frame::weight(problem.data().dimension(), problem.most_control_points());
        let capacity = (resources.ring_bytes / weight).max(1);
        Arc::new(Self {
            lanes: [
                WorkLane::of_start(problem.start_cost(), problem.step_cost()),
                WorkLane::of(problem.step_cost()),
            ],
            resources,
            peer,
            capacity,
            frame_bytes: weight,
            bytes: problem.memory(),
            keeps_unread: capacity >= 4 * LOOK_AHEAD,
            reader_budget: Arc::clone(&system.reader_budget),
            state: Mutex::new(RunState::new(system, permit)),
            ended: Notify::new(),
            stopped: Arc::default(),
            trace,
        })
    }

    /// The levels reached, if any.
    pub(crate) fn levels(&self) -> Option<Levels> {
        self.state.lock().levels
    }

    /// The system, once it has been made.
    pub(crate) fn system(&self) -> Option<Arc<System>> {
        self.state.lock().system.clone()
    }

    /// Bytes of the frames that it keeps.
    pub(crate) fn ring_bytes(&self) -> usize {
        self.state.lock().ring.len() * self.frame_bytes
    }

    /// Stops the run after its current step, or at once while the system is still being built, which
    /// can take long. Frames in the ring can still be read.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Ordering::Release);
        let mut state = self.state.lock();
        if state.ending.is_some() || (state.working && state.levels.is_some()) {
            return;
        }
        let last = state.iteration.take().map(|it| last_frame(&it));
        state.last = last;
        state.end(Ending::Stopped);
        self.tell_end(state);
    }

    /// Runs to its end, with or without readers; returns why it ended, and the last frame.
    pub(crate) async fn complete(self: &Arc<Self>) -> (Ending, Option<Arc<Frame>>) {
        self.state.lock().to_the_end = true;
        self.want(usize::MAX);
        loop {
            let mut ended = std::pin::pin!(self.ended.notified());
            ended.as_mut().enable();
            {
                let state = self.state.lock();
                if let Some(ending) = state.ending {
                    return (ending, state.last.clone());
                }
            }
            ended.await;
        }
    }

    /// Returns true if it may be ended when others need its memory: it has not been read for the time `idle`, or it has
    /// served its readers for the time `fair`.
    pub(super) fn is_revocable(&self, idle: Duration, fair: Duration) -> bool {
        let state = self.state.lock();
        let is_idle = !state.scheduled && state.touched.elapsed() >= idle;
        is_idle || (state.delivered && state.begun.elapsed() >= fair)
    }

    /// Ends it and drops its frames: its readers continue with another run.
    pub(super) fn revoke(&self) {
        let mut state = self.state.lock();
        state.end(Ending::Revoked);
        state.ring.clear();
        let system = state.system.take();
        let shared = state.shared.take();
        self.tell_end(state);
        drop((system, shared));
    }

    /// Notifies all waiting tasks of the end.
    fn tell_end(&self, state: MutexGuard<'_, RunState>) {
        state.tell(usize::MAX);
        drop(state);
        self.ended.notify_waiters();
    }

    /// Lets the run advance to `level`.
    fn want(self: &Arc<Self>, level: usize) {
        let mut state = self.state.lock();
        state.wanted = state.wanted.max(Some(level));
        if state.has_work() && !state.scheduled {
            state.scheduled = true;
            let lane = self.lanes[usize::from(state.levels.is_some())];
            drop(state);
            let work: Arc<dyn Work> = Arc::<Self>::clone(self);
            self.resources.scheduler.submit(lane, self.peer, work);
        }
    }

    /// The first level: 0, or for a run that recomputes the last checkpoint before the levels that its readers want.
    fn start(&self, shared: &SharedSystem) -> Iteration {
        let first = self.state.lock().first_wanted();
        let checkpoint = first.and_then(|first| shared.checkpoints.before(first));
        checkpoint.unwrap_or_else(|| {
            self.resources.counters.iterations.inc();
            self.level_0(shared)
        })
    }

    /// Level 0. Its computation is abandoned if the run is stopped.
    fn level_0(&self, shared: &SharedSystem) -> Iteration {
        let _traced = self.trace.set_up();
        let stopped = Arc::clone(&self.stopped);
        let is_stopped = Arc::new(move || stopped.load(Ordering::Acquire));
        interrupt::until(is_stopped, || Iteration::start(shared.get()))
    }

    /// Takes a step, or several at once if no reader wants the levels between; returns the level before the one
    /// that is reached.
    fn advance(&self, iteration: &mut Iteration) -> Level {
        let level = iteration.level();
        let next = match self.keeps_unread() {
            true => level.iteration + 1,
            false => self.state.lock().next_seen(),
        };
        let most = LEVELS.min(Checkpoints::at_once(level.iteration));
        let count = next.saturating_sub(level.iteration).clamp(1, most);
        let (mut before, mut current) = (level, level);
        iteration.steps(count, &mut |level| {
            self.resources.counters.iterations.inc();
            before = mem::replace(&mut current, level);
        });
        before
    }

    /// Records the level that was reached after `before`, and keeps its frame if it may be read.
    fn publish(&self, iteration: &mut Iteration, before: Option<Level>) {
        let outcome = iteration.outcome();
        if outcome.is_some_and(|outcome| outcome != Outcome::Overflow) {
            iteration.look_closer();
        }
        let level = iteration.level();
        let cache = &self.resources.memory.cache;
        let mut state = self.state.lock();
        if state.ending.is_some() {
            return;
        }
        if outcome == Some(Outcome::Overflow) {
            // This level has no geometry, so the one before it is the last. Its frame may not have been kept.
            if let Some(before) = before {
                state.reached(before, iteration.system());
                state.last = state.ring.get(before.iteration).cloned();
            }
            state.end(Ending::Outcome(Outcome::Overflow));
            return self.tell_end(state);
        }
        let mut oldest = None;
        let keep = self.keeps_unread() || outcome.is_some() || state.is_read(level.iteration);
        if keep {
            // Copying the control points can take as long as a step: the lock is not held meanwhile.
            drop(state);
            let frame = Arc::new(Frame::of(iteration, cache));
            state = self.state.lock();
            if state.ending.is_some() {
                return;
            }
            state.last = outcome.map(|_| Arc::clone(&frame));
            state.ring.push(frame);
            while state.ring.len() > self.capacity {
                oldest = state.ring.pop_oldest();
            }
            // A full cache drops two frames for each new one, so that other runs get room, too.
            for _ in 0..2 {
                if cache.is_full() && state.ring.len() > 1 {
                    oldest = state.ring.pop_oldest();
                }
            }
            if cache.is_full() {
                state.look_ahead_no_more();
            }
        } else {
            state.ring.clear();
        }
        state.reached(level, iteration.system());
        match outcome {
            Some(outcome) => {
                state.end(Ending::Outcome(outcome));
                self.tell_end(state);
            }
            None => state.tell(level.iteration),
        }
        if let Some(frame) = oldest {
            iteration.take_back(Arc::clone(&frame.control_points));
        }
    }

    /// Returns true if frames are kept before they are requested.
    fn keeps_unread(&self) -> bool {
        self.keeps_unread && !self.resources.memory.cache.is_half_full()
    }

    /// Takes the iteration out of the state for a slice, if there is work to do. Before level 0 there is
    /// no iteration.
    fn checkout(&self) -> Option<(Option<Iteration>, Arc<SharedSystem>)> {
        let mut state = self.state.lock();
        let shared = state.shared.clone().filter(|_| state.has_work());
        state.working = shared.is_some();
        state.scheduled = shared.is_some();
        shared.map(|shared| (state.iteration.take(), shared))
    }

    /// Puts the iteration back at the end of a slice; returns whether another slice is needed.
    fn check_in(&self, iteration: Iteration) -> Turn {
        let mut state = self.state.lock();
        state.working = false;
        if state.ending.is_some() {
            state.permit = None;
            drop(state);
            drop(iteration);
            return Turn::Done;
        }
        state.iteration = Some(iteration);
        state.scheduled = state.has_work();
        match state.scheduled {
            true => Turn::Again(self.lanes[1]),
            false => Turn::Done,
        }
    }

    /// Ends the run because it was stopped.
    fn end_stopped(&self, iteration: Iteration) -> Turn {
        let frame = last_frame(&iteration);
        let mut state = self.state.lock();
        if state.ending.is_none() {
            state.last = Some(frame);
            state.end(Ending::Stopped);
        }
        self.tell_end(state);
        self.check_in(iteration)
    }
}

/// The level at which a run was stopped.
fn last_frame(iteration: &Iteration) -> Arc<Frame> {
    let points = iteration.shared_control_points();
    let problem = Arc::clone(iteration.problem());
    Arc::new(Frame::last(iteration.level(), problem, points))
}

impl Work for Run {
    fn slice(&self, deadline: Instant) -> Turn {
        let Some((mut current, shared)) = self.checkout() else {
            return Turn::Done;
        };
        let mut traced = None;
        loop {
            let (mut iteration, before) = match current.take() {
                None => (self.start(&shared), None),
                Some(iteration) if self.stopped.load(Ordering::Acquire) => {
                    return self.end_stopped(iteration);
                }
                Some(mut iteration) => {
                    let level = iteration.level().iteration;
                    traced.get_or_insert_with(|| self.trace.slice(level));
                    let before = self.advance(&mut iteration);
                    (iteration, Some(before))
                }
            };
            self.publish(&mut iteration, before);
            let cache = &self.resources.memory.cache;
            shared.checkpoints.pass(&iteration, self.bytes, cache);
            // A thread that has just been woken would wait for a time slice of the operating system.
            if self.lanes[1] == WorkLane::Heavy {
                thread::yield_now();
            }
            let more = self.state.lock().has_work();
            let goes_on = more && Instant::now() < deadline;
            // The first slice and the steps may belong to different lanes.
            if !goes_on || (before.is_none() && self.lanes[0] != self.lanes[1]) {
                return self.check_in(iteration);
            }
            current = Some(iteration);
        }
    }

    fn broken(&self) {
        let mut state = self.state.lock();
        state.working = false;
        // A run that was stopped during its set-up was abandoned.
        state.end(match self.stopped.load(Ordering::Acquire) {
            true => Ending::Stopped,
            false => Ending::Broken,
        });
        state.permit = None;
        self.tell_end(state);
    }
}

#[cfg(test)]
mod tests;
