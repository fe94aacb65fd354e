//! Errors of the database and of its contents.

use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};

use redb::{StorageError, TableError};

use crate::job::store::StoreError;

/// Does work in which the database may panic, as it does where pages of the file are damaged. A
/// panic becomes an error: only what needs the page fails, and the thread continues
/// (`tests/api/damage.rs`).
pub(super) fn catch_panic<T>(work: impl FnOnce() -> T) -> Result<T, StoreError> {
    let damaged = |_| StoreError::damaged("a record", "pages of the database do not fit together");
    catch_unwind(AssertUnwindSafe(work)).map_err(damaged)
}

/// After a failure there is no database until it could be opened again.
pub(super) fn not_open() -> StoreError {
    StoreError::Unusable("it could not be opened again after an error".to_owned())
}

/// The thread that writes has ended.
pub(super) fn closed() -> StoreError {
    StoreError::Failed("the store is closed".to_owned())
}

/// Returns true if an error means that there is no space.
pub(super) fn means_full(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge
    )
}

impl From<redb::Error> for StoreError {
    fn from(error: redb::Error) -> Self {
        let text = error.to_string();
        match error {
            redb::Error::Io(reason) if means_full(reason.kind()) => Self::Full(text),
            // After an error it is opened again.
            redb::Error::PreviousIo | redb::Error::DatabaseClosed => Self::Unusable(text),
            _ => Self::Failed(text),
        }
    }
}

impl From<StorageError> for StoreError {
    fn from(error: StorageError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<TableError> for StoreError {
    fn from(error: TableError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::TransactionError> for StoreError {
    fn from(error: redb::TransactionError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::CommitError> for StoreError {
    fn from(error: redb::CommitError) -> Self {
        redb::Error::from(error).into()
    }
}
