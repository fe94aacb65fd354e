//! The compute pool: threads that run work in slices of a few milliseconds, round robin: first over the
//! peers for which there is work, then over the work of each.
//!
//! There are four lanes, each with threads of its own:
//!
//! - quick: steps that take less than a millisecond;
//! - heavy: larger steps, which can take longer than a slice, as a step is not interrupted;
//! - wire: reading requests and encoding answers;
//! - long: work that can take seconds in one piece, like factorising a dense matrix.
//!
//! The operating system shares the cores between the lanes. So a small job never waits for a large one, and no request
//! waits for the set-up of another client's job. Work on the long lane is not cut into slices. For each peer it
//! alternates between the piece with the least work and the oldest piece, so that a short one does not wait for many
//! longer ones, and none waits forever. Samples of curves and surfaces for clients are computed there, if they take
//! long; they let shorter work of other peers run in between.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};
use thiserror::Error;
use tokio::sync::oneshot;
use tracing::error;

use super::fair_queue::{PeerQueue, Turns};
use super::peer::Peer;
use crate::trim;
use piad_fit::engine::interrupt::{self, Interrupted};

/// How long a piece of work may run before the next one gets its turn.
const SLICE: Duration = Duration::from_millis(2);

/// How long a piece of work on the long lane may run before shorter ones of other peers get a turn.
const LONG_SLICE: Duration = Duration::from_millis(20);

/// The niceness of large steps: they get a quarter of a processor that both kinds need.
#[cfg(target_os = "linux")]
const NICE: i32 = 5;

/// Multiplications that take well below a millisecond.
pub(super) const QUICK: usize = 200_000;

/// Multiplications that take a tenth of a second or more.
const LONG_STEP_MULTIPLICATIONS: usize = 100_000_000;

/// The kind of threads that do the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WorkLane {
    /// For small steps.
    Quick,
    /// For large steps.
    Heavy,
    /// For reading requests, and encoding answers.
    Wire,
    /// For work that can take seconds in one piece, with its number of multiplications.
    Long(usize),
}

impl WorkLane {
    /// The lane of work whose indivisible steps take `operations` elementary operations.
    pub(crate) fn of(operations: usize) -> Self {
        if operations <= QUICK {
            Self::Quick
        } else {
            Self::Heavy
        }
    }

    /// The lane of the first slice of a run, which prepares the steps.
    pub(super) fn of_start(start: usize, step: usize) -> Self {
        match start {
            LONG_STEP_MULTIPLICATIONS.. => Self::Long(start),
            _ => Self::of(start.max(step)),
        }
    }

    /// The lane of reading a request or encoding an answer with this many operations.
    pub(crate) fn of_wire(operations: usize) -> Self {
        match Self::of(operations) {
            Self::Quick => Self::Quick,
            _ => Self::Wire,
        }
    }

    /// The lane of evaluating a curve or surface for a client, which takes this many multiplications.
    pub(crate) fn of_samples(multiplications: usize) -> Self {
        match multiplications {
            LONG_STEP_MULTIPLICATIONS.. => Self::Long(multiplications),
            _ => Self::of_wire(multiplications),
        }
    }

    /// The lane of a piece of an answer, which takes this many multiplications.
    pub(super) fn of_pieces(multiplications: usize) -> Self {
        match multiplications {
            LONG_STEP_MULTIPLICATIONS.. => Self::Long(multiplications),
            _ => Self::Wire,
        }
    }

    /// The multiplications of work on the long lane; 0 on the others.
    fn multiplications(self) -> usize {
        match self {
            Self::Long(multiplications) => multiplications,
            Self::Quick | Self::Heavy | Self::Wire => 0,
        }
    }
}

/// The need of work for another turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// Queue it again on this lane, behind the others.
    Again(WorkLane),
    /// It is done, or has nothing to do at the moment.
    Done,
}

/// Work that can be done in slices.
pub(super) trait Work: Send + Sync {
    /// Works until about `deadline`.
    fn slice(&self, deadline: Instant) -> Turn;

    /// Called after a panic in [`slice`](Self::slice), or if that was abandoned; it will not be called again.
    fn broken(&self);
}

/// Work has panicked, which is a bug; other work is not affected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the computation panicked")]
pub struct Broken;

/// The compute pool. Its threads end when it is closed, or dropped.
pub(crate) struct Scheduler(Arc<Queues>);

#[derive(Default)]
struct Queues {
    quick: Queue,
    heavy: Queue,
    wire: Queue,
    long: Queue,
}

impl Queues {
    fn of(&self, lane: WorkLane) -> &Queue {
        match lane {
            WorkLane::Quick => &self.quick,
            WorkLane::Heavy => &self.heavy,
            WorkLane::Wire => &self.wire,
            WorkLane::Long(_) => &self.long,
        }
    }
}

/// The lanes, and the names of their threads.
const LANES: [(WorkLane, &str); 4] = [
    (WorkLane::Quick, "quick"),
    (WorkLane::Heavy, "heavy"),
    (WorkLane::Wire, "wire"),
    (WorkLane::Long(0), "long"),
];

#[derive(Default)]
struct Queue {
    state: Mutex<QueueState>,
    filled: Condvar,
}

#[derive(Default)]
struct QueueState {
    waiting: Turns<Task>,
    closed: bool,
}

/// Work that waits.
struct Task {
    /// The peer it is done for.
    peer: Option<Peer>,
    /// The multiplications of work on the long lane.
    multiplications: usize,
    work: Arc<dyn Work>,
}

impl QueueState {
    /// The oldest work of the peer whose turn it is; on the long lane, alternating with that with the fewest
    /// multiplications.
    fn next(&mut self, lane: WorkLane) -> Option<Task> {
        self.waiting.next(|_, PeerQueue { waiting, turns }| {
            let least = *turns % 2 == 0 && matches!(lane, WorkLane::Long(_));
            let pieces = waiting.iter().enumerate();
            let place = match least {
                true => pieces.min_by_key(|(_, it)| it.multiplications)?.0,
                false => 0,
            };
            waiting.remove(place)
        })
    }

    /// The work with the fewest multiplications of another peer, below this number, as the peers have their turns.
    fn next_of_others(&mut self, peer: Option<Peer>, multiplications: usize) -> Option<Task> {
        self.waiting.next(|other, PeerQueue { waiting, .. }| {
            let pieces = waiting
                .iter()
                .enumerate()
                .filter(|(_, it)| it.multiplications < multiplications);
            let (place, _) = pieces
                .filter(|_| other != peer)
                .min_by_key(|(_, it)| it.multiplications)?;
            waiting.remove(place)
        })
    }
}

impl Scheduler {
    /// Starts `workers` threads for each lane.
    pub(crate) fn new(workers: usize) -> std::io::Result<Self> {
        let scheduler = Self(Arc::default());
        for (lane, name) in LANES {
            for index in 0..workers {
                let queues = Arc::clone(&scheduler.0);
                thread::Builder::new()
                    .name(format!("piad-{name}-{index}"))
                    .spawn(move || {
                        if matches!(lane, WorkLane::Heavy | WorkLane::Long(_)) {
                            give_way();
                        }
                        queues.serve(lane);
                    })?;
            }
        }
        Ok(scheduler)
    }

    /// Queues work that is done for a peer.
    pub(super) fn submit(&self, lane: WorkLane, peer: Option<Peer>, work: Arc<dyn Work>) {
        self.0.push(lane, peer, work);
    }

    /// Computes a value for the current peer in the pool, off the threads that serve the network. It is dropped if it
    /// is abandoned.
    pub(crate) async fn compute<T: Send + 'static>(
        &self,
        lane: WorkLane,
        function: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Broken> {
        self.call(lane, || (), function).await
    }

    /// The same for a function that may take seconds and holds no lock: it lets shorter work of other peers run in
    /// between, on the same thread.
    pub(crate) async fn compute_in_turns<T: Send + 'static>(
        &self,
        lane: WorkLane,
        function: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Broken> {
        let (queues, peer) = (Arc::clone(&self.0), Peer::current());
        let turn = LongTurn::default();
        let others = move || turn.let_others_run(&queues, peer, lane.multiplications());
        self.call(lane, others, function).await
    }

    /// Computes a value; `between` is called each time that the function checks whether it is still wanted.
    async fn call<T: Send + 'static>(
        &self,
        lane: WorkLane,
        between: impl Fn() + Send + Sync + 'static,
        function: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Broken> {
        let (sender, receiver) = oneshot::channel();
        let receiving = Arc::new(sender);
        let call: Box<dyn FnOnce() + Send> = Box::new(move || {
            // The receiver is gone if the request was dropped.
            let waits = Arc::clone(&receiving);
            if waits.is_closed() {
                return;
            }
            let is_over = move || {
                between();
                waits.is_closed()
            };
            let value = interrupt::until(Arc::new(is_over), function);
            if let Some(sender) = Arc::into_inner(receiving) {
                let _ = sender.send(value);
            }
        });
        let call = Call(Mutex::new(Some(call)));
        self.submit(lane, Peer::current(), Arc::new(call));
        receiver.await.map_err(|_| Broken)
    }

    /// Ends the threads after their current slices. Work that is waiting, or comes later, is dropped.
    pub(crate) fn close(&self) {
        for (lane, _) in LANES {
            self.0.of(lane).close();
        }
    }
}

/// Makes the threads of the process that share long loops over points. They give way like the lane of large steps, so
/// that small jobs do not wait for them.
pub(crate) fn share_loops(workers: usize) {
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads(workers)
        .thread_name(|index| format!("piad-loops-{index}"))
        .start_handler(|_| give_way());
    // Another server of this process may have made them.
    let _ = threads.build_global();
}

/// Lowers the priority of this thread: large steps give way to small ones, and to the network threads.
fn give_way() {
    // On other systems it would affect the whole process.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::nice(NICE);
}

impl Drop for Scheduler {
    fn drop(&mut self) {
        self.close();
    }
}

impl Queue {
    fn push(&self, task: Task) {
        let mut state = self.state.lock();
        if !state.closed {
            state.waiting.push(task.peer, task);
            self.filled.notify_one();
        }
    }

    /// Waits for the next work. A thread that waits for long releases memory: see [`trim`].
    fn pop(&self, lane: WorkLane) -> Option<Task> {
        let mut state = self.state.lock();
        let mut rounds = trim::ROUNDS;
        loop {
            if state.closed {
                return None;
            }
            if let Some(task) = state.next(lane) {
                return Some(task);
            }
            if rounds == 0 {
                self.filled.wait(&mut state);
            } else if self.filled.wait_for(&mut state, trim::PAUSE).timed_out() {
                MutexGuard::unlocked(&mut state, trim::this_thread);
                rounds -= 1;
            }
        }
    }

    fn close(&self) {
        let mut state = self.state.lock();
        state.closed = true;
        state.waiting.clear();
        self.filled.notify_all();
    }
}

impl Queues {
    fn push(&self, lane: WorkLane, peer: Option<Peer>, work: Arc<dyn Work>) {
        self.of(lane).push(Task {
            peer,
            multiplications: lane.multiplications(),
            work,
        });
    }

    fn serve(&self, lane: WorkLane) {
        while let Some(task) = self.of(lane).pop(lane) {
            self.run(task);
        }
    }

    fn run(&self, task: Task) {
        let deadline = Instant::now() + SLICE;
        match catch_unwind(AssertUnwindSafe(|| task.work.slice(deadline))) {
            Ok(Turn::Again(lane)) => self.push(lane, task.peer, task.work),
            Ok(Turn::Done) => {}
            Err(panic) => {
                if !panic.is::<Interrupted>() {
                    error!("a computation panicked; its job fails, the others continue");
                }
                task.work.broken();
            }
        }
    }
}

/// When a long computation last let others run.
struct LongTurn(Mutex<Instant>);

impl Default for LongTurn {
    fn default() -> Self {
        Self(Mutex::new(Instant::now()))
    }
}

thread_local! {
    /// This thread of the long lane is between two parts of a computation, and runs another one.
    static IS_BETWEEN: Cell<bool> = const { Cell::new(false) };
}

impl LongTurn {
    /// Runs a piece of work of another peer that waits on the long lane and takes fewer multiplications than this
    /// computation, if this computation has run for long enough.
    fn let_others_run(&self, queues: &Queues, peer: Option<Peer>, multiplications: usize) {
        let Some(mut since) = self.0.try_lock() else {
            return;
        };
        if since.elapsed() < LONG_SLICE || IS_BETWEEN.get() {
            return;
        }
        let task = queues
            .long
            .state
            .lock()
            .next_of_others(peer, multiplications);
        if let Some(task) = task {
            IS_BETWEEN.set(true);
            queues.run(task);
            IS_BETWEEN.set(false);
        }
        *since = Instant::now();
    }
}

impl std::fmt::Debug for Scheduler {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scheduler").finish_non_exhaustive()
    }
}

/// A function that is called once.
struct Call(Mutex<Option<Box<dyn FnOnce() + Send>>>);

impl Work for Call {
    fn slice(&self, _deadline: Instant) -> Turn {
        let call = self.0.lock().take();
        if let Some(call) = call {
            call();
        }
        Turn::Done
    }

    // The caller notices the closed channel.
    fn broken(&self) {}
}

#[cfg(test)]
mod tests;
