//! Jobs that were running in a crash of the process run again a few at a time: what brings it down
//! does so among few, which after the next crash are tried by themselves (see
//! [`blame`](super::store::blame)).

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// How long a suspect runs under watch.
pub(super) const WATCH: Duration = Duration::from_millis(250);

/// In how many parts suspects of as many crashes are tried, one after the other. All of them are
/// cleared within so many watches, and of 1000 suspects the culprit is known after three crashes.
pub(super) const PARTS: u32 = 32;

/// What those under watch share. A suspect takes the more of it the fewer there may be.
const WHOLE: u32 = 1 << 20;

/// The right to run under watch.
pub(super) type Watch = OwnedSemaphorePermit;

/// The suspects of a server, from its start on.
#[derive(Debug)]
pub(super) struct Suspects {
    watch: Arc<Semaphore>,
    /// What a suspect of so many crashes takes.
    shares: OnceLock<BTreeMap<u32, u32>>,
}

impl Default for Suspects {
    /// Nobody is suspect yet.
    fn default() -> Self {
        Self {
            watch: Arc::new(Semaphore::new(WHOLE as usize)),
            shares: OnceLock::new(),
        }
    }
}

impl Suspects {
    /// Learns of how many crashes the jobs are suspect that were found at the start.
    pub(super) fn gather(&self, crashes: impl Iterator<Item = u32>) {
        let mut counts = BTreeMap::new();
        for crashes in crashes.filter(|crashes| *crashes > 0) {
            *counts.entry(crashes).or_insert(0_u32) += 1;
        }
        let share = |count: u32| (WHOLE / count.div_ceil(PARTS)).max(1);
        let shares = counts
            .into_iter()
            .map(|(crashes, count)| (crashes, share(count)));
        // There is one start.
        let _ = self.shares.set(shares.collect());
    }

    /// Waits until a job that was running in so many crashes may run under watch; `None` if it is
    /// above suspicion.
    pub(super) async fn turn(&self, crashes: u32) -> Option<Watch> {
        let share = *self.shares.get()?.get(&crashes)?;
        let watch = Arc::clone(&self.watch);
        watch.acquire_many_owned(share).await.ok()
    }
}
