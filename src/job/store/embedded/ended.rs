//! The jobs that have ended, in the order of removal: the bookkeeping of stores in memory.

use std::collections::BTreeMap;

use jiff::Timestamp;
use uuid::Uuid;

use crate::job::store::kept::is_older;
use crate::job::store::{FORGOTTEN_AT_ONCE, Retention, Spared};

/// The jobs that have ended and their bytes, in the order of the times at which they ended.
#[derive(Debug, Default)]
pub(crate) struct Ended {
    jobs: BTreeMap<(Timestamp, Uuid), u64>,
    bytes: u64,
}

impl Ended {
    /// A job has ended and takes this many bytes.
    pub(crate) fn add(&mut self, at: Timestamp, id: Uuid, bytes: u64) {
        let before = self.jobs.insert((at, id), bytes).unwrap_or(0);
        self.bytes = self.bytes + bytes - before;
    }

    /// A job is gone.
    pub(crate) fn remove(&mut self, at: Timestamp, id: Uuid) {
        self.bytes -= self.jobs.remove(&(at, id)).unwrap_or(0);
    }

    /// The jobs to be removed, without those that are in use. Younger jobs are not removed in their place: until they
    /// are released, the store has more jobs than its limit.
    pub(crate) fn surplus(
        &self,
        retention: Retention,
        spared: &Spared,
        now: Timestamp,
    ) -> Vec<Uuid> {
        let (mut jobs, mut bytes) = (self.jobs.len(), self.bytes);
        let surplus = self.jobs.iter().take_while(|&(&(at, _), size)| {
            let old = is_older(at, retention.age, now);
            let forget = old || jobs > retention.jobs || bytes > retention.bytes;
            jobs -= 1;
            bytes -= size;
            forget
        });
        surplus
            .filter(|&(&(at, id), _)| !spared.spares(at, id))
            .map(|(&(_, id), _)| id)
            .take(FORGOTTEN_AT_ONCE)
            .collect()
    }
}
