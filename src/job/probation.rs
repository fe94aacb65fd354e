//! Jobs that were running in a crash run again one at a time: each is on probation before the next one starts.
//!
//! A crash during a probation is counted for its job. To rule out requests as the cause, no large body is read
//! meanwhile: one that has arrived ends the probation.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::sync::{Notify, OwnedRwLockReadGuard, OwnedRwLockWriteGuard, RwLock};

/// The possible causes of a crash: one job, or large bodies.
#[derive(Debug, Default)]
pub(crate) struct Probation {
    turn: Arc<RwLock<()>>,
    /// The bodies that wait.
    bodies: AtomicUsize,
    /// Notified when there is one.
    arrived: Notify,
}

/// A job is on probation.
pub(super) type OnProbation = OwnedRwLockWriteGuard<()>;

/// A large body is read; no job is on probation.
pub(crate) type LargeBody = OwnedRwLockReadGuard<()>;

/// A body that waits.
struct Waiting<'a>(&'a AtomicUsize);

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Probation {
    /// Waits until no other job is on probation, and no large body is read.
    pub(super) async fn begin(&self) -> OnProbation {
        Arc::clone(&self.turn).write_owned().await
    }

    /// Waits until a large body has arrived.
    pub(super) async fn interrupted(&self) {
        let arrived = self.arrived.notified();
        if self.bodies.load(Ordering::Acquire) == 0 {
            arrived.await;
        }
    }

    /// Ends the probation of a job, if there is one, before a large body is read.
    pub(crate) async fn read_large_body(&self) -> LargeBody {
        self.bodies.fetch_add(1, Ordering::AcqRel);
        let _waiting = Waiting(&self.bodies);
        self.arrived.notify_waiters();
        Arc::clone(&self.turn).read_owned().await
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    #[tokio::test]
    async fn a_large_body_ends_a_probation_and_holds_the_next_one_up() {
        let probation = Probation::default();
        let job = probation.begin().await;
        let mut interrupted = Box::pin(probation.interrupted());
        assert!(interrupted.as_mut().now_or_never().is_none());
        let mut body = Box::pin(probation.read_large_body());
        assert!(body.as_mut().now_or_never().is_none());
        assert!(interrupted.now_or_never().is_some());
        // Later probations end with it, too.
        assert!(probation.interrupted().now_or_never().is_some());
        drop(job);
        let body = body.now_or_never().unwrap();
        let mut next = Box::pin(probation.begin());
        assert!(next.as_mut().now_or_never().is_none());
        drop(body);
        assert!(next.now_or_never().is_some());
        assert!(probation.interrupted().now_or_never().is_none());
    }
}
