//! A change of the store on its way to the thread that writes, and back to the task that has requested it.

use tokio::sync::oneshot;
use uuid::Uuid;

use super::error::closed;
use super::transaction::Transaction;
use crate::job::store::StoreError;

/// A change with any kind of outcome.
pub(super) trait Change: Send {
    /// The number of points that it writes. Without any it needs only a few pages of the file, and must be possible
    /// when the disk is full.
    fn points(&self) -> usize {
        0
    }

    /// The new job that it writes.
    fn inserts(&self) -> Option<Uuid> {
        None
    }

    /// Returns true if it writes something.
    fn writes(&self) -> bool {
        true
    }

    /// Applies it; repeated if the transaction was not committed.
    fn apply(&mut self, transaction: &mut Transaction<'_>) -> Result<(), StoreError>;

    /// Sends its outcome once it is committed, or the error.
    fn answer(self: Box<Self>, committed: Result<(), StoreError>);
}

/// A change by a function.
pub(super) struct Pending<T, F> {
    pub(super) points: usize,
    pub(super) inserts: Option<Uuid>,
    pub(super) function: F,
    /// Its result in the transaction.
    pub(super) outcome: Option<T>,
    pub(super) reply: oneshot::Sender<Result<T, StoreError>>,
}

impl<T, F> Change for Pending<T, F>
where
    T: Send,
    F: Fn(&mut Transaction<'_>) -> Result<T, StoreError> + Send,
{
    fn points(&self) -> usize {
        self.points
    }

    fn inserts(&self) -> Option<Uuid> {
        self.inserts
    }

    fn apply(&mut self, transaction: &mut Transaction<'_>) -> Result<(), StoreError> {
        self.outcome = Some((self.function)(transaction)?);
        Ok(())
    }

    fn answer(self: Box<Self>, committed: Result<(), StoreError>) {
        let Self { outcome, reply, .. } = *self;
        // The task may have ended.
        let _ = reply.send(committed.and_then(|()| outcome.ok_or_else(closed)));
    }
}

/// No change: it is answered after the changes before it, by a store that is open.
pub(super) struct Barrier(pub(super) oneshot::Sender<Result<(), StoreError>>);

impl Change for Barrier {
    fn writes(&self) -> bool {
        false
    }

    fn apply(&mut self, _: &mut Transaction<'_>) -> Result<(), StoreError> {
        Ok(())
    }

    fn answer(self: Box<Self>, committed: Result<(), StoreError>) {
        let _ = self.0.send(committed);
    }
}
