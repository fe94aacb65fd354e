//! Levels that are computed again, for readers that have missed them: by runs that share a part of
//! the memory, in turn.

use std::fmt::Debug;
use std::sync::Weak;
use std::time::Duration;

use parking_lot::Mutex;
use tokio::time::timeout;

use super::memory::{Permit, Share};

/// A run that nobody has asked for anything for this long gives way to those who wait.
const IDLE: Duration = Duration::from_millis(500);

/// A run that has served its readers for this long gives way, too: they go on when it is their turn.
const FAIR: Duration = Duration::from_secs(20);

/// How often those who wait look for a run that gives way.
const LOOK: Duration = Duration::from_millis(100);

/// A run that can be ended when others need its memory.
pub(super) trait Revocable: Debug + Send + Sync {
    /// Whether it may be ended: nobody has asked it for anything for as long as `idle`, or it has served
    /// its readers for as long as `fair`.
    fn is_revocable(&self, idle: Duration, fair: Duration) -> bool;

    /// Ends it and forgets its frames: readers go on with another one.
    fn revoke(&self);
}

/// Runs that compute again.
#[derive(Debug, Default)]
pub struct Again(Mutex<Vec<Weak<dyn Revocable>>>);

impl Again {
    /// Waits for the memory of another run.
    pub(super) async fn turn(&self, share: &Share, bytes: usize) -> Option<Permit> {
        let mut permit = std::pin::pin!(share.take(bytes));
        loop {
            if let Ok(permit) = timeout(LOOK, permit.as_mut()).await {
                return permit;
            }
            self.make_room();
        }
    }

    /// A run that has got its memory here.
    pub(super) fn add(&self, run: Weak<dyn Revocable>) {
        let mut runs = self.0.lock();
        runs.retain(|run| run.strong_count() > 0);
        runs.push(run);
    }

    /// Ends a run that may be ended, if there is one; the oldest first.
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
