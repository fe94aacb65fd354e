//! Jobs that have just ended: their results are read and their points are edited in the next
//! moments, for which they stay in memory with their collocation matrices.

use std::collections::VecDeque;
use std::sync::Arc;

use parking_lot::Mutex;
use uuid::Uuid;

use super::Job;
use crate::fit::system::System;

/// The last jobs to end, up to so many bytes.
#[derive(Debug)]
pub struct Recent {
    limit: usize,
    kept: Mutex<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    jobs: VecDeque<Entry>,
    bytes: usize,
}

#[derive(Debug)]
struct Entry {
    job: Arc<Job>,
    /// A job does not hold its system by itself.
    _system: Option<Arc<System>>,
}

impl Recent {
    /// No job yet.
    pub fn new(limit: usize) -> Self {
        Self {
            limit,
            kept: Mutex::default(),
        }
    }

    /// Keeps a job at hand, and lets go of the oldest ones that it leaves no room for.
    pub fn keep(&self, job: &Arc<Job>, system: Option<Arc<System>>) {
        let entry = Entry {
            job: Arc::clone(job),
            _system: system,
        };
        if entry.bytes() > self.limit {
            return;
        }
        let mut kept = self.kept.lock();
        kept.bytes += entry.bytes();
        kept.jobs.push_back(entry);
        let mut dropped = Vec::new();
        while kept.bytes > self.limit
            && let Some(entry) = kept.jobs.pop_front()
        {
            kept.bytes -= entry.bytes();
            dropped.push(entry);
        }
        // Freeing large arrays takes a while: not under the lock.
        drop(kept);
        drop(dropped);
    }

    /// Lets go of a job.
    pub fn forget(&self, id: Uuid) {
        let mut kept = self.kept.lock();
        if let Some(place) = kept.jobs.iter().position(|entry| entry.job.id() == id)
            && let Some(entry) = kept.jobs.remove(place)
        {
            kept.bytes -= entry.bytes();
        }
    }
}

impl Entry {
    fn bytes(&self) -> usize {
        size_of::<Job>() + self.job.outline().memory
    }
}
