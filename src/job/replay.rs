//! Replays recompute iterations for readers that fell behind. All replays share one memory budget; when it
//! is exhausted, the oldest idle replay ends, and its readers queue for memory again.

use std::sync::Weak;
use std::time::Duration;

use parking_lot::Mutex;
use tokio::time::timeout;

use super::memory::{Permit, Share};
use super::peer::Peer;
use super::run::Run;

/// A run without reads for this long gives its memory to waiting runs.
const IDLE: Duration = Duration::from_millis(500);

/// A run that has served its readers for this long also gives way; its readers then queue for memory like the others.
const FAIR: Duration = Duration::from_secs(20);

/// The interval at which waiting runs search for an idle run.
const LOOK: Duration = Duration::from_millis(100);

/// The replays that hold memory of this budget.
#[derive(Debug, Default)]
pub(crate) struct Replays(Mutex<Vec<Weak<Run>>>);

impl Replays {
    /// Waits for memory, and ends a run that may be ended to get it.
    pub(super) async fn turn(
        &self,
        share: &Share,
        peer: Option<Peer>,
        bytes: usize,
    ) -> Option<Permit> {
        let mut permit = std::pin::pin!(share.take(peer, bytes));
        loop {
            if let Ok(permit) = timeout(LOOK, permit.as_mut()).await {
                return permit;
            }
            self.make_room();
        }
    }

    /// Registers a run that has got its memory here.
    pub(super) fn add(&self, run: Weak<Run>) {
        let mut runs = self.0.lock();
        runs.retain(|run| run.strong_count() > 0);
        runs.push(run);
    }

    /// Ends the oldest of the runs that may be ended, if there is one.
    fn make_room(&self) {
        let mut runs = self.0.lock();
        let live = runs.iter().enumerate();
        let found = live
            .filter_map(|(place, run)| Some((place, run.upgrade()?)))
            .find(|(_, run)| run.is_revocable(IDLE, FAIR));
        if let Some((place, run)) = found {
            runs.remove(place);
            run.revoke();
        }
    }
}
