//! Jobs that were running when the process crashed. They run again a few at a time: so the job that
//! crashes the process does so among few, which after the next crash are tried one by one (see
//! [`crash`](super::store::crash)).

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// How long a suspect runs under watch.
pub(super) const WATCH: Duration = Duration::from_millis(250);

/// Suspects of equally many crashes are tried in so many parts, one after the other. So all of them are
/// cleared within 32 watches, and among 1000 suspects the culprit is found after three crashes.
pub(super) const PARTS: u32 = 32;

/// The permits that suspects under watch share: the fewer may run at a time, the more each of them takes.
const WHOLE: u32 = 1 << 20;

/// The right to run under watch.
pub(super) type Watch = OwnedSemaphorePermit;

/// The suspects of a server, from its start on.
#[derive(Debug)]
pub(super) struct Suspects {
    watch: Arc<Semaphore>,
    /// How many permits a suspect takes, by its number of crashes.
    shares: OnceLock<BTreeMap<u32, u32>>,
}

impl Default for Suspects {
    /// No suspects yet.
    fn default() -> Self {
        Self {
            watch: Arc::new(Semaphore::new(WHOLE as usize)),
            shares: OnceLock::new(),
        }
    }
}

impl Suspects {
    /// Takes note of the crashes of all jobs that were found unfinished at the start.
    pub(super) fn gather(&self, crashes: impl Iterator<Item = u32>) {
        let mut counts = BTreeMap::new();
        for crashes in crashes.filter(|crashes| *crashes > 0) {
            *counts.entry(crashes).or_insert(0_u32) += 1;
        }
        let share = |count: u32| (WHOLE / count.div_ceil(PARTS)).max(1);
        let shares = counts
            .into_iter()
            .map(|(crashes, count)| (crashes, share(count)));
        // This is called once, at the start.
        let _ = self.shares.set(shares.collect());
    }

    /// Waits until a job that was running in so many crashes may run under watch; `None` if it is no
    /// suspect.
    pub(super) async fn turn(&self, crashes: u32) -> Option<Watch> {
        let share = *self.shares.get()?.get(&crashes)?;
        let watch = Arc::clone(&self.watch);
        watch.acquire_many_owned(share).await.ok()
    }
}
