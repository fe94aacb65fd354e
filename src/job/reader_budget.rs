//! Limits how long the readers of a job wait for each other, so that none loses its next frame.
//!
//! A reader waits up to a second for another reader of its own peer. Readers of another peer can
//! make it wait for a second in total, however many streams that peer opens one after the other:
//! the used time is refilled slowly.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use super::peer::Peer;

/// The longest wait of a reader.
pub(super) const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// Seconds of the budget that are refilled in each second.
const REGAINED: f64 = 0.1;

/// How long each peer has made others wait.
#[derive(Debug, Default)]
pub(crate) struct ReaderBudget(Mutex<HashMap<Option<Peer>, Spent>>);

#[derive(Clone, Copy, Debug)]
struct Spent {
    seconds: f64,
    /// When `seconds` was up to date.
    at: Instant,
}

impl Spent {
    /// The seconds that are still spent at a later time.
    fn until(self, now: Instant) -> f64 {
        let since = now.saturating_duration_since(self.at).as_secs_f64();
        (self.seconds - REGAINED * since).max(0.0)
    }
}

impl ReaderBudget {
    /// Notes that a peer has made others wait from `since` until now.
    pub(super) fn spend(&self, peer: Option<Peer>, since: Instant, now: Instant) {
        let mut peers = self.0.lock();
        // Peers whose budget is complete need no entry.
        if peers.len() == peers.capacity() {
            peers.retain(|_, spent| spent.until(now) > 0.0);
        }
        let spent = peers.entry(peer).or_insert(Spent {
            seconds: 0.0,
            at: since,
        });
        // Several readers may wait at the same time.
        let waited = now.saturating_duration_since(since.max(spent.at));
        let seconds = spent.until(now) + waited.as_secs_f64();
        spent.seconds = seconds.min(LONGEST_WAIT.as_secs_f64());
        spent.at = spent.at.max(now);
    }

    /// How much longer a peer may make others wait.
    pub(super) fn left(&self, peer: Option<Peer>, now: Instant) -> Duration {
        let peers = self.0.lock();
        let spent = peers.get(&peer).map_or(0.0, |spent| spent.until(now));
        LONGEST_WAIT.saturating_sub(Duration::from_secs_f64(spent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_is_spent_once_and_comes_back_slowly() {
        let budget = ReaderBudget::default();
        let peer = Some(Peer::at([127, 0, 0, 2].into()));
        let start = Instant::now();
        let at = |tenths: u32| start + Duration::from_millis(100) * tenths;
        assert_eq!(budget.left(peer, at(0)), LONGEST_WAIT);
        // Two that wait at the same time wait once.
        budget.spend(peer, at(0), at(6));
        budget.spend(peer, at(1), at(6));
        let left = budget.left(peer, at(6)).as_secs_f64();
        assert!((left - 0.4).abs() < 1e-9, "{left}");
        budget.spend(peer, at(6), at(20));
        assert_eq!(budget.left(peer, at(20)), Duration::ZERO);
        assert_eq!(budget.left(None, at(20)), LONGEST_WAIT);
        let left = budget.left(peer, at(70)).as_secs_f64();
        assert!((left - 0.5).abs() < 1e-9, "{left}");
        assert_eq!(budget.left(peer, at(500)), LONGEST_WAIT);
    }
}
