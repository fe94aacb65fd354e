//! The time of a store of one process, whose machine may set its clock at any moment.
//!
//! The time at which a job ends never decreases, so that the first jobs to end are removed first. Ages are measured by
//! a monotonic clock: a job that ended while the clock of the machine was a week behind is not a week old when that
//! clock is set right.

use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};
use parking_lot::Mutex;

/// The time of a store.
#[derive(Debug)]
pub(super) struct Clock {
    /// When the store was opened, by both clocks.
    opened: (Timestamp, Instant),
    /// The latest time that was returned or seen.
    latest: Mutex<Timestamp>,
}

impl Clock {
    /// The time of a store that is opened now.
    pub(super) fn new() -> Self {
        Self {
            opened: (Timestamp::now(), Instant::now()),
            latest: Mutex::new(Timestamp::MIN),
        }
    }

    /// The time of a job that ends now, which is later than that of all jobs before.
    pub(super) fn stamp(&self) -> Timestamp {
        let mut latest = self.latest.lock();
        let next = latest.checked_add(SignedDuration::from_nanos(1));
        *latest = Timestamp::now().max(next.unwrap_or(Timestamp::MAX));
        *latest
    }

    /// A time that is not before that of any job that has ended.
    pub(super) fn now(&self) -> Timestamp {
        Timestamp::now().max(*self.latest.lock())
    }

    /// A job has ended at this time.
    pub(super) fn see(&self, at: Timestamp) {
        let mut latest = self.latest.lock();
        *latest = at.max(*latest);
    }

    /// The time by the monotonic clock, which decides ages.
    pub(super) fn measured(&self) -> Timestamp {
        let (at, since) = self.opened;
        add(at, since.elapsed())
    }
}

fn add(at: Timestamp, passed: Duration) -> Timestamp {
    let passed = SignedDuration::try_from(passed).unwrap_or(SignedDuration::MAX);
    at.checked_add(passed).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A store that was opened while the clock of the machine was this many hours ahead.
    fn ahead(hours: i64) -> Clock {
        let clock = Clock::new();
        let ahead = SignedDuration::from_hours(hours);
        let opened = (clock.opened.0 + ahead, clock.opened.1);
        Clock { opened, ..clock }
    }

    #[test]
    fn times_never_go_backwards() {
        let clock = Clock::new();
        let mut before = clock.stamp();
        assert!(before <= Timestamp::now());
        for seen in [-3600, 0, 3600] {
            clock.see(Timestamp::now() + SignedDuration::from_secs(seen));
            for _ in 0..3 {
                let now = clock.now();
                assert!(now >= before);
                let next = clock.stamp();
                assert!(next > before && next >= now);
                before = next;
            }
        }
        assert!(before > Timestamp::now() + SignedDuration::from_secs(3500));
        clock.see(Timestamp::MAX);
        assert_eq!(clock.stamp(), Timestamp::MAX);
    }

    #[test]
    fn measured_times_ignore_changes_of_the_clock() {
        for hours in [-200, 200] {
            let clock = ahead(hours);
            let is = clock.measured() - SignedDuration::from_hours(hours);
            assert!(is <= Timestamp::now() && is > Timestamp::now() - SignedDuration::from_mins(1));
        }
    }
}
