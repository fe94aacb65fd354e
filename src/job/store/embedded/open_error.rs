//! Why a store cannot be opened.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::error::means_full;
use super::tables::VERSION;
use crate::job::store::StoreError;

/// The store cannot be opened.
#[derive(Debug, Error)]
pub(crate) enum OpenError {
    /// The directory cannot be created or read.
    #[error("the data directory {directory:?} cannot be used: {reason}")]
    Directory {
        /// The directory.
        directory: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// The file cannot be read or written; its contents may be valid.
    #[error("{path:?} cannot be used: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// Another process has it open.
    #[error("{0:?} is in use by another process: give each server a data directory of its own")]
    InUse(PathBuf),
    /// It was written by another version of the program.
    #[error(
        "{path:?} has version {found} of the format, this program reads version {VERSION} only: keep the \
         file and use the program that wrote it, or choose another --store"
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
    /// A URL that is not one of a database.
    #[error("--store: this is no URL of a PostgreSQL database: {0}")]
    Url(String),
    /// The database cannot be used.
    #[error("the database cannot be used: {0}")]
    Database(StoreError),
    /// There is no space for what must be written at the start.
    #[error("there is no room on the disk of {0:?}: make some and start again; no job is lost")]
    Full(PathBuf),
    /// Jobs that were running could not be put back into the queue.
    #[error("the jobs of the last run cannot be recovered: {0}")]
    Recovery(StoreError),
    /// It is not a store, or is damaged.
    #[error(
        "{path:?} cannot be opened, {reason}: `piad store repair` keeps what can be read; or restore it from a backup, or move it away to start \
         without its jobs"
    )]
    Broken {
        /// The file.
        path: PathBuf,
        /// The error.
        reason: String,
    },
}

impl OpenError {
    /// The jobs in the file cannot be read.
    pub(super) fn of_records(path: PathBuf, error: StoreError) -> Self {
        match error {
            StoreError::Failed(reason) => Self::Broken { path, reason },
            StoreError::Full(_) => Self::Full(path),
            error => Self::Recovery(error),
        }
    }
}

/// The meaning of a database error for a file.
pub(super) fn explain(path: &Path, error: redb::Error) -> OpenError {
    match error {
        redb::Error::DatabaseAlreadyOpen => OpenError::InUse(path.to_owned()),
        redb::Error::Io(reason) => match reason.kind() {
            ErrorKind::InvalidData => broken(path, "it is not a store of this program"),
            ErrorKind::UnexpectedEof => broken(path, "its end is missing"),
            kind if means_full(kind) => OpenError::Full(path.to_owned()),
            _ => of_file(path, reason),
        },
        redb::Error::Corrupted(reason) => broken(path, &format!("it is damaged ({reason})")),
        error => broken(path, &format!("it is damaged ({error})")),
    }
}

/// The file is no store, or is damaged.
pub(super) fn broken(path: &Path, reason: &str) -> OpenError {
    OpenError::Broken {
        path: path.to_owned(),
        reason: reason.to_owned(),
    }
}

/// The file cannot be read or written.
pub(super) fn of_file(path: &Path, reason: io::Error) -> OpenError {
    OpenError::File {
        path: path.to_owned(),
        reason,
    }
}
