//! The system of a problem, which all its runs share.

use std::sync::{Arc, Weak};

use parking_lot::Mutex;

use crate::job::checkpoints::Checkpoints;
use crate::job::reader_budget::ReaderBudget;
use piad_fit::engine::{Problem, System};

/// The system of a problem: built when it is first needed, shared by all runs that need it at the
/// same time, and dropped with the last of them.
#[derive(Debug)]
pub(crate) struct SharedSystem {
    pub(super) problem: Arc<Problem>,
    system: Mutex<Weak<System>>,
    /// A system that may have the same collocation matrix; dropped once it has been used.
    similar: Mutex<Option<Arc<System>>>,
    /// Levels from which runs can begin.
    pub(in crate::job) checkpoints: Checkpoints,
    /// How long the readers of these runs have made each other wait.
    pub(super) reader_budget: Arc<ReaderBudget>,
}

impl SharedSystem {
    /// Nothing is computed yet. A collocation matrix equal to that of `similar` will be taken from there.
    pub(crate) fn new(problem: Arc<Problem>, similar: Option<Arc<System>>) -> Self {
        Self {
            problem,
            system: Mutex::new(Weak::new()),
            similar: Mutex::new(similar),
            checkpoints: Checkpoints::default(),
            reader_budget: Arc::default(),
        }
    }

    /// The system, if it has been built and is still in use.
    pub(crate) fn at_hand(&self) -> Option<Arc<System>> {
        // The lock is held for long while the system is being built.
        self.system.try_lock()?.upgrade()
    }

    pub(crate) fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The system, which lives as long as it is held. Building it can take long, so this is never called on the network
    /// threads.
    pub(crate) fn get(&self) -> Arc<System> {
        let mut shared = self.system.lock();
        shared.upgrade().unwrap_or_else(|| {
            let problem = Arc::clone(&self.problem);
            let system = Arc::new(match self.similar.lock().take() {
                Some(other) => System::like(problem, &other),
                None => System::new(problem),
            });
            *shared = Arc::downgrade(&system);
            system
        })
    }
}
