//! The activity on a connection, from which its timeouts follow.

use std::sync::Arc;

use parking_lot::Mutex;
use tokio::time::{Duration, Instant, sleep, sleep_until};

use crate::trim;

/// Timeouts of a connection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// For the head of a request to arrive.
    pub(super) head: Duration,
    /// Between requests.
    pub(super) idle: Duration,
    /// For the client to read something of what is being written.
    pub(super) write: Duration,
}

/// The activity on a connection.
#[derive(Debug)]
pub(super) struct Activity(Mutex<ConnectionState>);

#[derive(Debug)]
struct ConnectionState {
    /// Requests whose answers are not complete.
    open: usize,
    /// Since when there are none.
    idle: Instant,
    /// When the first byte of a request came whose head is not complete yet.
    head: Option<Instant>,
    /// When something was last written, and how many bytes in all.
    written: (Instant, u64),
    /// True if the client reads nothing of what is being written.
    blocked: bool,
    /// There has been a request.
    served: bool,
    /// True if a request was answered before all of its body had arrived.
    cut_short: bool,
    /// True if it is HTTP/2, where bytes may be exchanged without a request.
    multiplexed: bool,
}

/// Why a connection has timed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Overdue {
    /// The head of a request was not completed in time.
    Half,
    /// There are no requests.
    Idle,
}

impl Activity {
    /// The activity of a new connection.
    pub(super) fn new() -> Self {
        let now = Instant::now();
        Self(Mutex::new(ConnectionState {
            open: 0,
            idle: now,
            head: None,
            written: (now, 0),
            blocked: false,
            served: false,
            cut_short: false,
            multiplexed: false,
        }))
    }

    /// Notes that bytes were received.
    pub(super) fn read(&self) {
        let mut state = self.0.lock();
        if state.open == 0 && state.head.is_none() {
            state.head = Some(Instant::now());
        }
    }

    /// Notes that this many bytes were sent.
    pub(super) fn wrote(&self, bytes: usize) {
        let mut state = self.0.lock();
        state.written = (Instant::now(), state.written.1 + bytes as u64);
    }

    /// Notes whether the client reads nothing of what is being written.
    pub(super) fn set_blocked(&self, blocked: bool) {
        self.0.lock().blocked = blocked;
    }

    /// Notes a request, which is open until the guard is dropped.
    pub(super) fn open(self: &Arc<Self>, multiplexed: bool) -> OpenRequest {
        let mut state = self.0.lock();
        state.open += 1;
        state.head = None;
        state.served = true;
        state.multiplexed = multiplexed;
        OpenRequest(Arc::clone(self))
    }

    /// Notes that a request is answered before all of its body has come: the connection ends with the
    /// answer.
    pub(super) fn cut_short(&self) {
        self.0.lock().cut_short = true;
    }

    /// Returns true if the rest of a request may still come.
    pub(super) fn is_cut_short(&self) -> bool {
        self.0.lock().cut_short
    }

    /// Completes when the connection has timed out.
    pub(super) async fn overdue(&self, times: Times) -> Overdue {
        // No timeout that begins after one check can pass before the next one.
        let shortest = times.head.min(times.idle);
        loop {
            let now = Instant::now();
            let (end, why) = self
                .0
                .lock()
                .end(times)
                .unwrap_or((now + shortest, Overdue::Idle));
            if end <= now {
                return why;
            }
            sleep_until(end.min(now + shortest)).await;
        }
    }

    /// Completes when there has been nothing on a connection with HTTP/1.1 for a time: all answers have been read, and
    /// nothing of a request has arrived.
    pub(super) async fn quiet(&self, time: Duration) {
        loop {
            let now = Instant::now();
            let end = self.0.lock().quiet_since().map(|since| since + time);
            match end {
                Some(end) if end <= now => return,
                end => sleep_until(end.unwrap_or(now + time)).await,
            }
        }
    }

    /// Completes when no request is open and nothing has been written for a time.
    pub(super) async fn silence(&self, time: Duration) {
        let of = |state: &ConnectionState| (state.open == 0).then_some(state.written.1);
        loop {
            let before = of(&self.0.lock());
            sleep(time).await;
            if before.is_some() && before == of(&self.0.lock()) {
                return;
            }
        }
    }
}

impl ConnectionState {
    /// Since when there has been nothing on a connection with HTTP/1.1.
    fn quiet_since(&self) -> Option<Instant> {
        let is_busy = self.open > 0 || self.head.is_some() || self.blocked;
        let is_quiet = self.served && !is_busy && !self.cut_short && !self.multiplexed;
        is_quiet.then(|| self.idle.max(self.written.0))
    }

    /// When and why the connection times out if nothing happens on it.
    fn end(&self, times: Times) -> Option<(Instant, Overdue)> {
        if self.open > 0 {
            return None;
        }
        if !self.served {
            let end = self.idle + times.head;
            return Some(match self.head {
                // The first bytes of a request do not extend the time.
                Some(_) => (end, Overdue::Half),
                None => (end, Overdue::Idle),
            });
        }
        if self.multiplexed {
            return Some((self.idle + times.idle, Overdue::Idle));
        }
        match self.head {
            Some(since) => Some((since + times.head, Overdue::Half)),
            // The end of an answer may still be on its way.
            None => Some((self.idle.max(self.written.0) + times.idle, Overdue::Idle)),
        }
    }
}

/// A request whose answer is not complete.
#[derive(Debug)]
#[must_use]
pub(super) struct OpenRequest(Arc<Activity>);

impl Drop for OpenRequest {
    fn drop(&mut self) {
        let mut state = self.0.0.lock();
        state.open -= 1;
        state.idle = Instant::now();
        drop(state);
        trim::soon();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: Times = Times {
        head: Duration::from_secs(10),
        idle: Duration::from_secs(100),
        write: Duration::from_secs(1000),
    };

    fn left(activity: &Activity, since: Instant) -> Option<(u64, Overdue)> {
        let (end, why) = activity.0.lock().end(TIMES)?;
        Some(((end - since).as_secs_f64().round() as u64, why))
    }

    #[test]
    fn requests_and_their_heads_and_pauses_have_times_of_their_own() {
        let activity = Arc::new(Activity::new());
        let now = Instant::now();
        assert_eq!(left(&activity, now), Some((10, Overdue::Idle)));
        activity.read();
        assert_eq!(left(&activity, now), Some((10, Overdue::Half)));
        let request = activity.open(false);
        assert_eq!(left(&activity, now), None);
        activity.read();
        activity.wrote(5);
        drop(request);
        assert_eq!(left(&activity, now), Some((100, Overdue::Idle)));
        activity.read();
        assert_eq!(left(&activity, now), Some((10, Overdue::Half)));
    }

    #[test]
    fn a_connection_is_quiet_when_all_is_said_and_taken() {
        let activity = Arc::new(Activity::new());
        let is_quiet = || activity.0.lock().quiet_since().is_some();
        activity.read();
        assert!(!is_quiet(), "a head is coming");
        let request = activity.open(false);
        assert!(!is_quiet(), "it is not answered");
        activity.set_blocked(true);
        drop(request);
        assert!(!is_quiet(), "the answer is not taken");
        activity.set_blocked(false);
        assert!(is_quiet());
        activity.read();
        assert!(!is_quiet(), "the next one is coming");
        drop(activity.open(false));
        activity.cut_short();
        assert!(!is_quiet(), "the rest of a body may come");
    }

    #[test]
    fn pings_of_http_2_are_no_requests() {
        let activity = Arc::new(Activity::new());
        let now = Instant::now();
        let requests = [activity.open(true), activity.open(true)];
        for request in requests {
            assert_eq!(left(&activity, now), None);
            drop(request);
        }
        activity.read();
        assert_eq!(left(&activity, now), Some((100, Overdue::Idle)));
    }
}
