//! Jobs that have just ended, or were just edited. They are likely to be read and edited in the next
//! moments, so they stay in memory with their recent frames and collocation matrices while there is room
//! in the cache.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::{Arc, Weak};

use parking_lot::Mutex;
use uuid::Uuid;

use super::Job;
use super::memory::{Cache, Charge};
use super::run::{Run, SharedSystem};
use piad_fit::engine::System;

/// The last jobs to end, up to a number of bytes.
#[derive(Debug)]
pub(super) struct Recent {
    limit: usize,
    cache: Arc<Cache>,
    kept: Mutex<KeptJobs>,
}

#[derive(Debug, Default)]
struct KeptJobs {
    jobs: VecDeque<KeptJob>,
    bytes: usize,
}

#[derive(Debug)]
struct KeptJob {
    job: Arc<Job>,
    bytes: usize,
    _charge: Charge,
    /// A job itself holds its runs and its system only weakly.
    run: Option<Arc<Run>>,
    shared: Option<Arc<SharedSystem>>,
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

    /// Keeps a job, and drops the oldest ones if there is no room for all.
    pub(super) fn keep(&self, job: &Arc<Job>, run: &Arc<Run>) {
        let alone = size_of::<Job>() + job.outline().memory;
        let with_frames = alone + run.ring_bytes();
        let frames_fit = with_frames <= self.limit;
        let entry = KeptJob {
            job: Arc::clone(job),
            bytes: if frames_fit { with_frames } else { alone },
            // Frames have charges of their own.
            _charge: self.cache.charge(alone),
            run: frames_fit.then(|| Arc::clone(run)),
            shared: None,
            _system: run.system(),
        };
        self.push(entry);
    }

    /// Returns true if the points of a job are kept.
    pub(super) fn has_points(&self, id: Uuid) -> bool {
        let kept = self.kept.lock();
        let has = |entry: &KeptJob| entry.run.is_some() || entry.shared.is_some();
        kept.jobs
            .iter()
            .any(|entry| entry.job.id() == id && has(entry))
    }

    /// Keeps a job that is edited.
    pub(super) fn keep_edited(
        &self,
        job: &Arc<Job>,
        shared: Arc<SharedSystem>,
        system: Arc<System>,
    ) {
        let bytes = size_of::<Job>() + job.outline().memory;
        self.push(KeptJob {
            job: Arc::clone(job),
            bytes,
            _charge: self.cache.charge(bytes),
            run: None,
            shared: Some(shared),
            _system: Some(system),
        });
    }

    /// Keeps an entry, if there is room for it.
    fn push(&self, entry: KeptJob) {
        if entry.bytes > self.limit {
            return;
        }
        let mut kept = self.kept.lock();
        kept.bytes += entry.bytes;
        kept.jobs.push_back(entry);
        drop(kept);
        self.make_room();
    }

    /// Drops the oldest jobs while there are too many, or the cache is full.
    fn make_room(&self) {
        loop {
            let mut kept = self.kept.lock();
            if kept.bytes <= self.limit && !self.cache.is_full() {
                return;
            }
            let Some(oldest) = kept.jobs.pop_front() else {
                return;
            };
            kept.bytes -= oldest.bytes;
            // Freeing large arrays takes a while, so the lock is released first.
            drop(kept);
            drop(oldest);
        }
    }

    /// The jobs in memory that are in use: held not only here.
    pub(super) fn held(&self, live: &Mutex<HashMap<Uuid, Weak<Job>>>) -> HashSet<Uuid> {
        // While this is locked, no job is added or dropped here.
        let kept = self.kept.lock();
        let mut here: HashMap<Uuid, usize> = HashMap::new();
        for entry in &kept.jobs {
            *here.entry(entry.job.id()).or_default() += 1;
        }
        let is_held = |id: &Uuid, job: &Weak<Job>| {
            job.strong_count() > here.get(id).copied().unwrap_or_default()
        };
        let live = live.lock();
        let held = live.iter().filter(|(id, job)| is_held(id, job));
        held.map(|(&id, _)| id).collect()
    }

    /// Drops a job.
    pub(super) fn forget(&self, id: Uuid) {
        let mut kept = self.kept.lock();
        while let Some(place) = kept.jobs.iter().position(|entry| entry.job.id() == id)
            && let Some(entry) = kept.jobs.remove(place)
        {
            kept.bytes -= entry.bytes;
        }
    }
}
