//! The compute pool: threads that run work in slices of a few milliseconds, round robin.
//!
//! Work has one of two lanes with threads of their own. Steps on the quick lane take less than a
//! millisecond; those on the heavy lane can take longer than a slice, as a step is not interrupted.
//! Both lanes have as many threads as there are workers, and the operating system shares the cores
//! between them: a small job never waits for a large one.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex};
use thiserror::Error;
use tokio::sync::oneshot;
use tracing::error;

/// How long a piece of work may run before the next one gets its turn.
const SLICE: Duration = Duration::from_millis(2);

/// Multiplications (or numbers to be written) that take well below a millisecond.
const QUICK: usize = 200_000;

/// Which threads do the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// For small steps.
    Quick,
    /// For large steps.
    Heavy,
}

impl Lane {
    /// The lane of work whose indivisible steps take `operations` elementary operations.
    pub fn of(operations: usize) -> Self {
        if operations <= QUICK {
            Self::Quick
        } else {
            Self::Heavy
        }
    }
}

/// Whether work needs another turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Queue it again, behind the others.
    Again,
    /// It is done, or has nothing to do for now.
    Done,
}

/// Work that can be done in slices.
pub trait Work: Send + Sync {
    /// Works until about `deadline`.
    fn slice(&self, deadline: Instant) -> Turn;

    /// Told after a panic in [`slice`](Self::slice), which will not be called again.
    fn broken(&self);
}

/// Work panicked: a defect, contained to this piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the computation broke down")]
pub struct Broken;

/// The compute pool. Its threads end when it is closed, or dropped.
#[derive(Debug)]
pub struct Scheduler {
    quick: Arc<Queue>,
    heavy: Arc<Queue>,
}

#[derive(Default)]
struct Queue {
    state: Mutex<QueueState>,
    filled: Condvar,
}

#[derive(Default)]
struct QueueState {
    waiting: VecDeque<Arc<dyn Work>>,
    closed: bool,
}

impl Scheduler {
    /// Starts `workers` threads for each lane.
    pub fn new(workers: usize) -> std::io::Result<Self> {
        let scheduler = Self {
            quick: Arc::default(),
            heavy: Arc::default(),
        };
        for (queue, lane) in [(&scheduler.quick, "quick"), (&scheduler.heavy, "heavy")] {
            for index in 0..workers {
                let queue = Arc::clone(queue);
                thread::Builder::new()
                    .name(format!("piad-{lane}-{index}"))
                    .spawn(move || queue.serve())?;
            }
        }
        Ok(scheduler)
    }

    /// Queues work.
    pub fn submit(&self, lane: Lane, work: Arc<dyn Work>) {
        match lane {
            Lane::Quick => self.quick.push(work),
            Lane::Heavy => self.heavy.push(work),
        }
    }

    /// Computes a value in the pool, off the threads that serve the network.
    pub async fn compute<T: Send + 'static>(
        &self,
        lane: Lane,
        function: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Broken> {
        let (sender, receiver) = oneshot::channel();
        let call: Box<dyn FnOnce() + Send> = Box::new(move || {
            // Nobody waits for the value of a request that was given up.
            let _ = sender.send(function());
        });
        self.submit(lane, Arc::new(Call(Mutex::new(Some(call)))));
        receiver.await.map_err(|_| Broken)
    }
}

impl Scheduler {
    /// Ends the threads after their current slices. Work that waits, or comes later, is not done.
    pub fn close(&self) {
        self.quick.close();
        self.heavy.close();
    }
}

impl Drop for Scheduler {
    fn drop(&mut self) {
        self.close();
    }
}

impl Queue {
    fn push(&self, work: Arc<dyn Work>) {
        let mut state = self.state.lock();
        if !state.closed {
            state.waiting.push_back(work);
            self.filled.notify_one();
        }
    }

    fn pop(&self) -> Option<Arc<dyn Work>> {
        let mut state = self.state.lock();
        loop {
            if state.closed {
                return None;
            }
            if let Some(work) = state.waiting.pop_front() {
                return Some(work);
            }
            self.filled.wait(&mut state);
        }
    }

    fn close(&self) {
        let mut state = self.state.lock();
        state.closed = true;
        state.waiting.clear();
        self.filled.notify_all();
    }

    fn serve(&self) {
        while let Some(work) = self.pop() {
            let deadline = Instant::now() + SLICE;
            match catch_unwind(AssertUnwindSafe(|| work.slice(deadline))) {
                Ok(Turn::Again) => self.push(work),
                Ok(Turn::Done) => {}
                Err(_) => {
                    error!("a computation panicked; its job fails, the others go on");
                    work.broken();
                }
            }
        }
    }
}

impl std::fmt::Debug for Queue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let waiting = self.state.lock().waiting.len();
        f.debug_struct("Queue").field("waiting", &waiting).finish()
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

    // The waiting side learns it from the closed channel.
    fn broken(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts its turns and notes the order in which they come.
    struct Counting {
        id: usize,
        left: Mutex<usize>,
        log: Arc<Mutex<Vec<usize>>>,
    }

    impl Work for Counting {
        fn slice(&self, _deadline: Instant) -> Turn {
            self.log.lock().push(self.id);
            let mut left = self.left.lock();
            *left -= 1;
            if *left == 0 { Turn::Done } else { Turn::Again }
        }

        fn broken(&self) {}
    }

    #[tokio::test]
    async fn turns_go_round() {
        let scheduler = Scheduler::new(1).unwrap();
        let log = Arc::new(Mutex::new(Vec::new()));
        let (release, blocked) = std::sync::mpsc::channel::<()>();
        let first = scheduler.compute(Lane::Heavy, move || blocked.recv().is_ok());
        let works = async {
            for id in 0..3 {
                let left = Mutex::new(4);
                let log = Arc::clone(&log);
                scheduler.submit(Lane::Heavy, Arc::new(Counting { id, left, log }));
            }
            release.send(()).unwrap();
        };
        let (first, ()) = tokio::join!(first, works);
        assert_eq!(first, Ok(true));
        // Queued behind the rest: once it has run, the others have had their turns.
        while log.lock().len() < 12 {
            scheduler.compute(Lane::Heavy, || ()).await.unwrap();
        }
        assert_eq!(*log.lock(), [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2]);
    }

    #[tokio::test]
    async fn a_panic_breaks_only_its_own_work() {
        let scheduler = Scheduler::new(1).unwrap();
        let broken: Result<(), Broken> = scheduler
            .compute(Lane::Quick, || panic!("meant to happen"))
            .await;
        assert_eq!(broken, Err(Broken));
        assert_eq!(scheduler.compute(Lane::Quick, || 7).await, Ok(7));
    }
}
