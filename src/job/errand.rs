//! Work that is done in slices until it pauses, and is returned then: it may have ended, or need something that threads
//! of the compute pool do not wait for.

use std::sync::Arc;
use std::time::Instant;

use parking_lot::Mutex;
use tokio::sync::oneshot;

use super::peer::Peer;
use super::scheduler::{Broken, Scheduler, Turn, Work, WorkLane};

/// Work that can be done in slices.
pub(crate) trait Errand: Send + 'static {
    /// Works until about `deadline`.
    fn work(&mut self, deadline: Instant) -> Progress;
}

/// The next need of an errand.
pub(crate) enum Progress {
    /// Another slice, on this queue.
    Again(WorkLane),
    /// No slice: it has ended, or waits for something.
    Paused,
}

/// An errand with a task that waits for its end.
struct Awaited<E> {
    errand: Arc<Mutex<E>>,
    done: Mutex<Option<oneshot::Sender<()>>>,
}

impl Scheduler {
    /// Works on an errand for the current peer until it pauses. An abandoned one is left as it is.
    pub(crate) async fn run_errand<E: Errand>(
        &self,
        lane: WorkLane,
        errand: &Arc<Mutex<E>>,
    ) -> Result<(), Broken> {
        let (done, paused) = oneshot::channel();
        let work = Awaited {
            errand: Arc::clone(errand),
            done: Mutex::new(Some(done)),
        };
        self.submit(lane, Peer::current(), Arc::new(work));
        paused.await.map_err(|_| Broken)
    }
}

impl<E: Errand> Work for Awaited<E> {
    fn slice(&self, deadline: Instant) -> Turn {
        let is_gone = |done: &oneshot::Sender<()>| done.is_closed();
        if self.done.lock().as_ref().is_none_or(is_gone) {
            return Turn::Done;
        }
        match self.errand.lock().work(deadline) {
            Progress::Again(lane) => Turn::Again(lane),
            Progress::Paused => {
                if let Some(done) = self.done.lock().take() {
                    let _ = done.send(());
                }
                Turn::Done
            }
        }
    }

    // The waiting task sees the closed channel.
    fn broken(&self) {
        self.done.lock().take();
    }
}
