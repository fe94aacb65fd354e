//! Jobs that have just ended: they are read and edited in the next moments, for which they stay in
//! memory, with their recent frames and collocation matrices, while there is room in the cache.

use std::collections::VecDeque;
use std::sync::Arc;

use parking_lot::Mutex;
use uuid::Uuid;

use super::Job;
use super::memory::{Cache, Charge};
use super::run::Run;
use crate::fit::system::System;

/// The last jobs to end, up to so many bytes.
#[derive(Debug)]
pub(super) struct Recent {
    limit: usize,
    cache: Arc<Cache>,
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
    bytes: usize,
    _charge: Charge,
    /// A job does not hold its runs and its system by itself.
    _run: Option<Arc<Run>>,
    _system: Option<Arc<System>>,
}

impl Recent {
    /// No job yet.
    pub(super) fn new(limit: usize, cache: Arc<Cache>) -> Self {
        Self {
            limit,
            cache,
            kept: Mutex::default(),
        }
    }

    /// Keeps a job at hand, and lets go of the oldest ones that it leaves no room for.
    pub(super) fn keep(&self, job: &Arc<Job>, run: &Arc<Run>) {
        let alone = size_of::<Job>() + job.outline().memory;
        let with_frames = alone + run.ring_bytes();
        let frames_fit = with_frames <= self.limit;
        let entry = Entry {
            job: Arc::clone(job),
            bytes: if frames_fit { with_frames } else { alone },
            // Frames are counted by themselves.
            _charge: self.cache.charge(alone),
            _run: frames_fit.then(|| Arc::clone(run)),
            _system: run.system(),
        };
        if entry.bytes > self.limit {
            return;
        }
        let mut kept = self.kept.lock();
        kept.bytes += entry.bytes;
        kept.jobs.push_back(entry);
        let mut dropped = Vec::new();
        while kept.bytes > self.limit
            && let Some(entry) = kept.jobs.pop_front()
        {
            kept.bytes -= entry.bytes;
            dropped.push(entry);
        }
        // Freeing large arrays takes a while: not under the lock.
        drop(kept);
        drop(dropped);
        self.make_room();
    }

    /// Lets go of the oldest jobs while the cache is full.
    fn make_room(&self) {
        while self.cache.is_full() {
            let mut kept = self.kept.lock();
            let Some(entry) = kept.jobs.pop_front() else {
                return;
            };
            kept.bytes -= entry.bytes;
            drop(kept);
            drop(entry);
        }
    }

    /// Lets go of a job.
    pub(super) fn forget(&self, id: Uuid) {
        let mut kept = self.kept.lock();
        if let Some(place) = kept.jobs.iter().position(|entry| entry.job.id() == id)
            && let Some(entry) = kept.jobs.remove(place)
        {
            kept.bytes -= entry.bytes;
        }
    }
}
