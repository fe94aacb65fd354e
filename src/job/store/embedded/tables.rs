//! What stands in the file.

use std::io::{self, ErrorKind};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parking_lot::{RwLock, RwLockReadGuard};
use prost::Message;
use redb::{
    Database, DatabaseError, ReadOnlyTable, ReadableDatabase, ReadableTable, StorageError,
    TableDefinition, TableError,
};
use thiserror::Error;
use uuid::Uuid;

use super::super::{Made, Record, Selection, StoreError};
use super::header::{Header, KeyMessage};
use super::input::{Input, PointsMessage};
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// The version of what is described here. Messages may get new fields under the same version;
/// whatever an older program would misread needs a new one.
pub(super) const VERSION: u64 = 1;

/// Facts about the file itself.
pub(super) const FACTS: TableDefinition<&str, u64> = TableDefinition::new("facts");
const VERSION_FACT: &str = "version";

/// Bytes of the file that are kept in memory. Most jobs are read once.
const CACHE: usize = 32 << 20;

/// Jobs without their points, by id: lists read only these.
pub(super) const HEADERS: TableDefinition<u128, &[u8]> = TableDefinition::new("headers");
/// Problems as they were asked for, by the id of the job.
pub(super) const INPUTS: TableDefinition<u128, &[u8]> = TableDefinition::new("inputs");
/// The free control points of the last level, by the id of the job.
pub(super) const RESULTS: TableDefinition<u128, &[u8]> = TableDefinition::new("results");
/// Which job was made for a key.
pub(super) const KEYS: TableDefinition<&str, &[u8]> = TableDefinition::new("keys");

/// The store cannot be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The directory cannot be made or read.
    #[error("the data directory {directory:?} cannot be used: {reason}")]
    Directory {
        /// The directory.
        directory: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// Another process has it open.
    #[error("{0:?} is in use by another process: give each server a data directory of its own")]
    InUse(PathBuf),
    /// It was written by another version of the program.
    #[error(
        "{path:?} has version {found} of the format, this program knows version {VERSION}: start the \
         program that wrote it, or choose another --data-dir"
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
    /// What was running could not be put back into the queue.
    #[error("the jobs of the last run cannot be recovered: {0}")]
    Recovery(StoreError),
    /// It is not a store, or is damaged.
    #[error("{path:?} cannot be opened: {reason}")]
    Broken {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: redb::Error,
    },
}

/// The open file.
pub(super) struct File {
    path: PathBuf,
    /// `None` between a failure and the next write: after an I/O error redb has to be opened anew.
    database: RwLock<Option<Database>>,
}

impl File {
    /// Opens or makes the file in a directory, and checks its version.
    pub(super) fn open(directory: &Path, name: &str) -> Result<Self, OpenError> {
        std::fs::create_dir_all(directory).map_err(|reason| OpenError::Directory {
            directory: directory.to_owned(),
            reason,
        })?;
        let path = directory.join(name);
        let database = open(&path, true)?;
        let broken = |reason| OpenError::Broken {
            path: path.clone(),
            reason,
        };
        match prepare(&database).map_err(broken)? {
            VERSION => Ok(Self {
                path,
                database: RwLock::new(Some(database)),
            }),
            found => Err(OpenError::Version { path, found }),
        }
    }

    /// The database, to be read or written.
    pub(super) fn database(&self) -> RwLockReadGuard<'_, Option<Database>> {
        self.database.read()
    }

    /// Opens the file anew after an I/O error, with what was committed before it.
    pub(super) fn reopen(&self) -> Result<(), StoreError> {
        let mut database = self.database.write();
        // The lock on the file goes with the old one.
        drop(database.take());
        let opened =
            open(&self.path, false).map_err(|error| StoreError::Failed(error.to_string()))?;
        *database = Some(opened);
        Ok(())
    }

    /// A job without its points.
    pub(super) fn record(&self, id: Uuid) -> Result<Option<Record>, StoreError> {
        self.get(HEADERS, id, |bytes| {
            Header::decode(bytes).map_err(damaged)?.into_record()
        })
    }

    /// The problem of a job.
    pub(super) fn problem(&self, id: Uuid) -> Result<Option<Arc<Problem>>, StoreError> {
        self.get(INPUTS, id, |bytes| {
            let request = Input::decode(bytes).map_err(damaged)?.into_request()?;
            Problem::new(request).map(Arc::new).map_err(damaged)
        })
    }

    /// The free control points of the last level of a job.
    pub(super) fn result(&self, id: Uuid) -> Result<Option<Arc<Points>>, StoreError> {
        self.get(RESULTS, id, |bytes| {
            let points = PointsMessage::decode(bytes).map_err(damaged)?;
            points.into_points().map(Arc::new)
        })
    }

    /// Jobs, the newest first.
    pub(super) fn list(&self, selection: Selection) -> Result<Vec<Record>, StoreError> {
        let end = selection.before.unwrap_or(Uuid::max()).as_u128();
        let mut records = Vec::new();
        let headers = self.table(HEADERS)?;
        for entry in headers.range(..end)?.rev() {
            if records.len() == selection.limit {
                break;
            }
            let record = Header::decode(entry?.1.value())
                .map_err(damaged)?
                .into_record()?;
            let state = record.status.state;
            if selection.state.is_none_or(|wanted| wanted == state) {
                records.push(record);
            }
        }
        Ok(records)
    }

    /// Jobs that have not ended, the oldest first.
    pub(super) fn unfinished(&self) -> Result<Vec<Record>, StoreError> {
        let mut records = Vec::new();
        for entry in self.table(HEADERS)?.iter()? {
            let header = Header::decode(entry?.1.value()).map_err(damaged)?;
            let record = header.into_record()?;
            if !record.status.state.is_final() {
                records.push(record);
            }
        }
        Ok(records)
    }

    /// The job that was made for a key.
    pub(super) fn made(&self, key: &str) -> Result<Option<Made>, StoreError> {
        let keys = self.table(KEYS)?;
        let Some(bytes) = keys.get(key)? else {
            return Ok(None);
        };
        let made = KeyMessage::decode(bytes.value())
            .map_err(damaged)?
            .into_made()?;
        Ok((!made.is_forgotten()).then_some(made))
    }

    fn table<K: redb::Key + 'static>(
        &self,
        table: TableDefinition<K, &'static [u8]>,
    ) -> Result<ReadOnlyTable<K, &'static [u8]>, StoreError> {
        let database = self.database();
        let database = database.as_ref().ok_or_else(closed)?;
        Ok(database.begin_read()?.open_table(table)?)
    }

    fn get<T>(
        &self,
        table: TableDefinition<u128, &'static [u8]>,
        id: Uuid,
        decode: impl FnOnce(&[u8]) -> Result<T, StoreError>,
    ) -> Result<Option<T>, StoreError> {
        let value = self.table(table)?.get(id.as_u128())?;
        value.map(|bytes| decode(bytes.value())).transpose()
    }
}

/// Between a failure and the next write there is no database.
pub(super) fn closed() -> StoreError {
    StoreError::Failed("the file could not be opened again after an error".to_owned())
}

/// What was read makes no sense.
pub(super) fn damaged(reason: impl ToString) -> StoreError {
    StoreError::Failed(format!("a record cannot be read: {}", reason.to_string()))
}

/// Opens the file; makes it if it `may_be_new`: one that was there before must not be replaced by
/// an empty one.
fn open(path: &Path, may_be_new: bool) -> Result<Database, OpenError> {
    let mut builder = Database::builder();
    builder.set_cache_size(CACHE);
    // A file that was cut off can make redb panic.
    let opened = catch_unwind(AssertUnwindSafe(|| match may_be_new {
        true => builder.create(path),
        false => builder.open(path),
    }));
    let opened = opened.unwrap_or_else(|_| {
        let damaged = StorageError::Corrupted("it is shorter than it says".to_owned());
        Err(DatabaseError::Storage(damaged))
    });
    opened.map_err(|error| match error {
        DatabaseError::DatabaseAlreadyOpen => OpenError::InUse(path.to_owned()),
        error => OpenError::Broken {
            path: path.to_owned(),
            reason: error.into(),
        },
    })
}

/// Makes the tables of a new file; gives the version of the file.
fn prepare(database: &Database) -> Result<u64, redb::Error> {
    let transaction = database.begin_write()?;
    let version = {
        let mut facts = transaction.open_table(FACTS)?;
        let found = facts.get(VERSION_FACT)?.map(|version| version.value());
        match found {
            Some(version) => version,
            None => {
                facts.insert(VERSION_FACT, VERSION)?;
                VERSION
            }
        }
    };
    if version != VERSION {
        transaction.abort()?;
        return Ok(version);
    }
    transaction.open_table(HEADERS)?;
    transaction.open_table(INPUTS)?;
    transaction.open_table(RESULTS)?;
    transaction.open_table(KEYS)?;
    transaction.commit()?;
    Ok(version)
}

impl From<redb::Error> for StoreError {
    fn from(error: redb::Error) -> Self {
        let text = error.to_string();
        let full = [
            ErrorKind::StorageFull,
            ErrorKind::QuotaExceeded,
            ErrorKind::FileTooLarge,
        ];
        match error {
            redb::Error::Io(reason) if full.contains(&reason.kind()) => Self::Full(text),
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
