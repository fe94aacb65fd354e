//! A fit without readers: it computes the same levels as a run, and keeps the last one.
//!
//! A job costs several times as much as a small fit: it has an id, a task, a ring of frames, and clients that wait
//! for each of them. Many small fits in one request need none of that.

use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::frame::Frame;
use super::resources::Resources;
use super::run::Ending;
use super::scheduler::WorkLane;
use super::state::{Levels, Status};
use piad_fit::engine::sweep::LEVELS;
use piad_fit::engine::{Iteration, Level, Outcome, Problem, System, interrupt};

/// A fit that is being computed.
pub(crate) struct DirectFit {
    problem: Arc<Problem>,
    /// `None` before level 0.
    iteration: Option<Iteration>,
    levels: Option<Levels>,
}

/// A fit that has ended.
pub(crate) struct EndedFit {
    /// The final state, and the levels.
    pub status: Status,
    /// The last level; `None` if its numbers have overflowed.
    pub frame: Option<Frame>,
}

impl DirectFit {
    /// Nothing is computed yet.
    pub(crate) fn new(problem: Problem) -> Self {
        Self {
            problem: Arc::new(problem),
            iteration: None,
            levels: None,
        }
    }

    /// The system of the fit.
    pub(crate) fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The queue that its next piece of work belongs to.
    pub(crate) fn lane(&self) -> WorkLane {
        let step = self.problem.step_cost();
        match self.iteration {
            None => WorkLane::of_start(self.problem.start_cost(), step),
            Some(_) => WorkLane::of(step),
        }
    }

    /// Works until about `deadline`, at least one piece; returns the end once it is reached. Level 0 is abandoned by
    /// unwinding if `cancelled` becomes true meanwhile.
    pub(crate) fn work(
        &mut self,
        deadline: Instant,
        cancelled: &Arc<AtomicBool>,
        resources: &Resources,
    ) -> Option<EndedFit> {
        let Some(mut iteration) = self.iteration.take() else {
            return self.start(cancelled, resources);
        };
        loop {
            let before = advance(&mut iteration, resources);
            if let Some(outcome) = iteration.outcome() {
                return Some(self.end(iteration, outcome, before, resources));
            }
            if Instant::now() >= deadline || cancelled.load(Ordering::Acquire) {
                self.reached(&iteration, iteration.level());
                self.iteration = Some(iteration);
                return None;
            }
        }
    }

    /// Computes level 0.
    fn start(&mut self, cancelled: &Arc<AtomicBool>, resources: &Resources) -> Option<EndedFit> {
        let problem = Arc::clone(&self.problem);
        let stopped = Arc::clone(cancelled);
        let is_over = Arc::new(move || stopped.load(Ordering::Acquire));
        // A batch reports no prediction.
        let start = || Iteration::start_unpredicted(Arc::new(System::new(problem)));
        let iteration = interrupt::until(is_over, start);
        resources.counters.iterations.inc();
        let level = iteration.level();
        if let Some(outcome) = iteration.outcome() {
            return Some(self.end(iteration, outcome, level, resources));
        }
        self.reached(&iteration, level);
        self.iteration = Some(iteration);
        None
    }

    /// The end at the current level, which comes after `before`.
    fn end(
        &mut self,
        mut iteration: Iteration,
        outcome: Outcome,
        before: Level,
        resources: &Resources,
    ) -> EndedFit {
        let has_geometry = outcome != Outcome::Overflow;
        if has_geometry {
            iteration.look_closer();
            self.reached(&iteration, iteration.level());
        } else if before.iteration < iteration.level().iteration {
            self.reached(&iteration, before);
        }
        let (state, reason, failure) = Ending::Outcome(outcome).verdict();
        EndedFit {
            status: Status {
                state,
                levels: self.levels,
                reason,
                failure,
                ..Status::QUEUED
            },
            frame: has_geometry.then(|| Frame::of(&iteration, &resources.memory.cache)),
        }
    }

    fn reached(&mut self, iteration: &Iteration, level: Level) {
        self.levels = Some(Levels {
            first: self.levels.map_or(level, |levels| levels.first),
            last: level,
            forecast: iteration.system().forecast(),
        });
    }
}

/// Takes some steps; returns the level before the last one.
fn advance(iteration: &mut Iteration, resources: &Resources) -> Level {
    let (mut before, mut current) = (iteration.level(), iteration.level());
    iteration.steps(LEVELS, &mut |level| {
        resources.counters.iterations.inc();
        before = mem::replace(&mut current, level);
    });
    before
}
