//! What stands in the file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use parking_lot::{RwLock, RwLockReadGuard};
use prost::Message;
use redb::{Database, ReadableDatabase, ReadableTable, StorageError, TableDefinition, TableError};
use tracing::error;
use uuid::Uuid;

use super::super::{Made, Record, Selection, StoreError};
use super::header::{Header, KeyMessage};
use super::input::{Input, PointsMessage};
use super::opening::{self, OpenError};
use super::quiet;
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// The version of what is described here. Messages may get new fields under the same version;
/// whatever an older program would misread needs a new one.
pub(super) const VERSION: u64 = 1;

/// Facts about the file itself.
pub(super) const FACTS: TableDefinition<&str, u64> = TableDefinition::new("facts");
pub(super) const VERSION_FACT: &str = "version";

/// How long those who read the file may hold it when it is opened again.
const MOST_READING: Duration = Duration::from_secs(5);

/// Jobs without their points, by id: lists read only these.
pub(super) const HEADERS: TableDefinition<u128, &[u8]> = TableDefinition::new("headers");
/// Problems as they were asked for, by the id of the job.
pub(super) const INPUTS: TableDefinition<u128, &[u8]> = TableDefinition::new("inputs");
/// The free control points of the last level, by the id of the job.
pub(super) const RESULTS: TableDefinition<u128, &[u8]> = TableDefinition::new("results");
/// Which job was made for a key.
pub(super) const KEYS: TableDefinition<&str, &[u8]> = TableDefinition::new("keys");
/// Nothing: pages are taken and given back here, so that there are some.
pub(super) const SLACK: TableDefinition<u64, &[u8]> = TableDefinition::new("slack");

/// The open file.
pub(super) struct File {
    path: PathBuf,
    /// `None` between a failure and the next write: after an I/O error redb has to be opened anew.
    database: RwLock<Option<Database>>,
}

impl File {
    /// Opens or makes the file in a directory, and checks its version.
    pub(super) fn open(directory: &Path, name: &str) -> Result<Self, OpenError> {
        let path = directory.join(name);
        let database = opening::open_or_make(directory, &path)?;
        Ok(Self {
            path,
            database: RwLock::new(Some(database)),
        })
    }

    /// Reads. If the database panics, as it does where pages are damaged, only this read fails.
    pub(super) fn read<T>(
        &self,
        read: impl FnOnce(&Self) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        quiet::catch(|| read(self)).unwrap_or_else(|panic| {
            error!(panic, "the database panicked while it was read");
            let works = quiet::catch(|| self.made("").is_ok()).unwrap_or(false);
            if !works && let Err(error) = self.reopen() {
                error!(%error, "the store could not be opened again");
            }
            Err(damaged("the database does not understand its own pages"))
        })
    }

    /// The database, to be read or written.
    pub(super) fn database(&self) -> RwLockReadGuard<'_, Option<Database>> {
        self.database.read()
    }

    /// Opens the file anew after an I/O error, with what was committed before it.
    pub(super) fn reopen(&self) -> Result<(), StoreError> {
        let mut database = self.database.write();
        // The lock on the file goes with the old one, and with the last of those who still read it.
        if let Err(panic) = quiet::catch(|| drop(database.take())) {
            error!(panic, "the database panicked while it was closed");
        }
        let begin = Instant::now();
        let opened = loop {
            match opening::open_again(&self.path) {
                Err(OpenError::InUse(_)) if begin.elapsed() < MOST_READING => {
                    sleep(Duration::from_millis(5));
                }
                opened => break opened,
            }
        };
        *database = Some(opened.map_err(|error| StoreError::Failed(error.to_string()))?);
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

    /// A table as it is now. Its pages are not used again as long as it lives. What `ReadOnlyTable`
    /// itself returns may outlive it and does not keep them: what the trait returns may not.
    fn table<K: redb::Key + 'static>(
        &self,
        table: TableDefinition<K, &'static [u8]>,
    ) -> Result<impl ReadableTable<K, &'static [u8]> + use<K>, StoreError> {
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
        let table = self.table(table)?;
        let value = table.get(id.as_u128())?;
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

#[cfg(test)]
mod tests {
    use redb::Table;

    use super::*;

    type Results<'a> = Table<'a, u128, &'static [u8]>;

    #[test]
    fn what_is_being_decoded_can_be_deleted() {
        let directory = tempfile::tempdir().unwrap();
        let file = File::open(directory.path(), "jobs").unwrap();
        let write = |change: &dyn Fn(&mut Results<'_>)| {
            let database = file.database();
            let transaction = database.as_ref().unwrap().begin_write().unwrap();
            change(&mut transaction.open_table(RESULTS).unwrap());
            transaction.commit().unwrap();
        };
        for length in [200, 3800, 100_000] {
            let (id, bytes) = (Uuid::from_u128(length), vec![7; length as usize]);
            let insert = |table: &mut Results<'_>, id| {
                table.insert(id, bytes.as_slice()).unwrap();
            };
            write(&|table| insert(table, length));
            let read = file.get(RESULTS, id, |read| {
                write(&|table| drop(table.remove(length).unwrap()));
                // Later commits use the pages of the removed value again, unless they are read.
                for other in 1..6 {
                    write(&|table| insert(table, length + other));
                }
                Ok(read.to_vec())
            });
            assert_eq!(read.unwrap(), Some(bytes));
            assert_eq!(file.get(RESULTS, id, |_| Ok(())).unwrap(), None);
        }
    }
}
