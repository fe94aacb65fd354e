//! The system of a problem, which all its runs share.

use std::sync::{Arc, Weak};

use parking_lot::Mutex;

use crate::fit::problem::Problem;
use crate::fit::system::System;
use crate::job::patience::Patience;

/// The system of a problem, made when it is first needed and shared by all runs that need it at
/// the same time.
#[derive(Debug)]
pub struct SharedSystem {
    pub(super) problem: Arc<Problem>,
    system: Mutex<Weak<System>>,
    /// A system that may have the same collocation matrix; given up once it has been used.
    similar: Mutex<Option<Arc<System>>>,
    /// How long readers of the runs have made each other wait.
    pub(super) patience: Arc<Patience>,
}

impl SharedSystem {
    /// Nothing is computed yet. If the matrix is that of the system `similar`, that one is used.
    pub fn new(problem: Arc<Problem>, similar: Option<Arc<System>>) -> Self {
        Self {
            problem,
            system: Mutex::new(Weak::new()),
            similar: Mutex::new(similar),
            patience: Arc::default(),
        }
    }

    /// The system, if somebody holds it.
    pub fn at_hand(&self) -> Option<Arc<System>> {
        // While it is being made the lock is held for long.
        self.system.try_lock()?.upgrade()
    }

    /// The problem.
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The system, which lives as long as somebody holds it. It can take long to make: not
    /// for the threads that serve the network.
    pub fn get(&self) -> Arc<System> {
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
