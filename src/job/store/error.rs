//! Errors of a store.

use std::fmt::Display;

use futures_util::future::BoxFuture;
use thiserror::Error;
use uuid::Uuid;

use crate::job::scheduler::Broken;

/// The store has failed to carry out a request.
#[derive(Clone, Debug, Error)]
pub enum StoreError {
    /// There is no space for what was to be kept. It may succeed later.
    #[error("the store is full: {0}")]
    Full(String),
    /// The job was deleted in the meantime.
    #[error("the job {0} was deleted")]
    Gone(Uuid),
    /// The database cannot be reached. It may succeed later.
    #[error("the database cannot be reached: {0}")]
    Away(String),
    /// The file cannot be used now. It may succeed later.
    #[error("the store cannot be used now: {0}")]
    Unusable(String),
    /// Anything else.
    #[error("the store failed: {0}")]
    Failed(String),
    /// The store worked, but the computation that needed its records panicked.
    #[error(transparent)]
    Broken(#[from] Broken),
}

impl StoreError {
    /// Returns true if a retry may succeed.
    pub(crate) fn may_pass(&self) -> bool {
        matches!(self, Self::Full(_) | Self::Away(_) | Self::Unusable(_))
    }

    /// Stored data are invalid.
    pub(super) fn damaged(what: impl Display, reason: impl Display) -> Self {
        Self::Failed(format!("{what} cannot be read: {reason}"))
    }
}

/// Completes when a change is durable, with its result.
pub(crate) type Acknowledgement<T> = BoxFuture<'static, Result<T, StoreError>>;
