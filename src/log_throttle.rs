//! Rate limit for log lines about events that happen often.

use std::time::{Duration, Instant};

/// Limits a message to one in every `pause`.
#[derive(Debug)]
pub(crate) struct LogThrottle {
    pause: Duration,
    last_emitted: Option<Instant>,
    suppressed: u64,
}

impl LogThrottle {
    pub(crate) fn new(pause: Duration) -> Self {
        Self {
            pause,
            last_emitted: None,
            suppressed: 0,
        }
    }

    /// Notes an event. Returns how many there were since the last message if one is due now.
    pub(crate) fn record(&mut self, now: Instant) -> Option<u64> {
        self.suppressed += 1;
        let recent = |emitted: Instant| now.saturating_duration_since(emitted) < self.pause;
        if self.last_emitted.is_some_and(recent) {
            return None;
        }
        self.last_emitted = Some(now);
        Some(std::mem::take(&mut self.suppressed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suppressed_events_are_counted() {
        let mut throttle = LogThrottle::new(Duration::from_secs(10));
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        let emitted: Vec<_> = [0, 1, 9, 10, 30]
            .map(|at| throttle.record(after(at)))
            .into();
        assert_eq!(emitted, [Some(1), None, None, Some(3), Some(1)]);
    }
}
