//! Rate limit for log lines about events that happen often.

use std::time::{Duration, Instant};

/// Limits a message to one in every `pause`.
#[derive(Debug)]
pub(super) struct Rarely {
    pause: Duration,
    told: Option<Instant>,
    untold: u64,
}

impl Rarely {
    pub(super) fn new(pause: Duration) -> Self {
        Self {
            pause,
            told: None,
            untold: 0,
        }
    }

    /// Notes an event. Returns how many there were since the last message if one is due now.
    pub(super) fn happened(&mut self, now: Instant) -> Option<u64> {
        self.untold += 1;
        let recent = |told: Instant| now.saturating_duration_since(told) < self.pause;
        if self.told.is_some_and(recent) {
            return None;
        }
        self.told = Some(now);
        Some(std::mem::take(&mut self.untold))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_told_is_counted() {
        let mut rarely = Rarely::new(Duration::from_secs(10));
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        let told: Vec<_> = [0, 1, 9, 10, 30]
            .map(|at| rarely.happened(after(at)))
            .into();
        assert_eq!(told, [Some(1), None, None, Some(3), Some(1)]);
    }
}
