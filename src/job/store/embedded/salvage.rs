//! Reads a file that may be damaged, without changing it.
//!
//! The database is read first, with an [`Overlay`] above the file. What it does not yield is searched in the whole file
//! by the [envelopes](super::envelope) of the values, which separate good values from damaged ones. There may be values
//! of jobs that were deleted and whose pages were not used again; they count only where the database does not say any
//! more which jobs there are.

use std::collections::{BTreeSet, HashMap};
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jiff::Timestamp;
use memchr::memmem;
use parking_lot::Mutex;
use uuid::Uuid;

use super::database::JobDatabase;
use super::envelope::{self, Kind};
use super::error::catch_panic;
use super::open_error::{self, OpenError};
use super::opening;
use super::tables::{self, HEADERS, Header, INPUTS, RESULTS, Values};
use super::{Embedded, FILE};
use crate::job::counters::Counters;
use crate::job::state::Status;
use crate::job::store::copy::WholeJob;
use crate::job::store::{IdempotencyKey, Store, StoreError, record};

/// The name of the new file while it is written.
const REPAIRED: &str = "piad.repaired";

/// Bytes of the file that are searched at a time.
const CHUNK: usize = 8 << 20;

/// A file of jobs that is not changed meanwhile.
pub(crate) struct Salvage {
    path: PathBuf,
    /// Locked as long as it is open.
    file: File,
    /// The database, if it can be opened.
    database: Option<JobDatabase>,
    /// The error of the database, apart from those of values in it.
    complaint: Option<String>,
    ids: BTreeSet<Uuid>,
    /// Good values in the file, once they were searched.
    found: Mutex<Option<Arc<Found>>>,
}

type Found = HashMap<(Kind, Uuid), Place>;

/// The position of a value.
#[derive(Clone, Copy)]
struct Place {
    offset: u64,
    length: usize,
}

/// A job that could be read.
pub(crate) struct Salvaged {
    pub job: WholeJob,
    /// The error about lost parts, if there are some: then the job runs again.
    pub lost: Option<StoreError>,
}

impl Salvage {
    /// Opens the file in this directory, which no server may use.
    pub(crate) fn open(directory: &Path) -> Result<Self, OpenError> {
        let path = directory.join(FILE);
        let of_file = |reason| open_error::of_file(&path, reason);
        let file = File::open(&path).map_err(of_file)?;
        if let Err(reason) = file.try_lock() {
            return Err(match reason {
                TryLockError::WouldBlock => OpenError::InUse(path),
                TryLockError::Error(reason) => of_file(reason),
            });
        }
        let (database, complaint) = match opening::open_below(&path, &file) {
            Ok((database, complaint)) => (Some(JobDatabase::on_overlay(database)), complaint),
            Err(OpenError::Broken { reason, .. }) => (None, Some(reason)),
            Err(error) => return Err(error),
        };
        let mut salvage = Self {
            path,
            file,
            database,
            complaint,
            ids: BTreeSet::new(),
            found: Mutex::new(None),
        };
        let listed = salvage
            .database
            .as_ref()
            .map(|it| it.read(JobDatabase::ids));
        salvage.ids = match listed {
            Some(Ok(ids)) => ids,
            listed => {
                if let Some(Err(error)) = listed {
                    salvage.complaint.get_or_insert(error.to_string());
                    let _ = catch_panic(|| drop(salvage.database.take()));
                }
                let found = salvage.found().map_err(of_file_in(&salvage.path))?;
                let found = found.keys().filter(|(kind, _)| *kind == Kind::Header);
                found.map(|(_, id)| *id).collect()
            }
        };
        Ok(salvage)
    }

    /// A store in a new file beside the damaged one.
    pub(crate) fn make(directory: &Path) -> Result<Store, OpenError> {
        let path = directory.join(REPAIRED);
        match fs::remove_file(&path) {
            Err(reason) if reason.kind() != io::ErrorKind::NotFound => {
                return Err(open_error::of_file(&path, reason));
            }
            _ => {}
        }
        let store = Embedded::open_file(directory, REPAIRED, Counters::default())?;
        Ok(Store::Embedded(store))
    }

    /// Replaces the damaged file by that store; returns the new name of the damaged one.
    pub(crate) fn replace(self, directory: &Path, repaired: Store) -> io::Result<PathBuf> {
        // Its file is complete when it is closed.
        drop(repaired);
        let kept = (0..).map(|number| match number {
            0 => self.path.with_extension("damaged"),
            number => self.path.with_extension(format!("damaged{number}")),
        });
        let mut kept = kept.filter(|path| !path.exists());
        let kept = kept.next().unwrap_or_default();
        // There is a file of jobs at each moment: a server without one would start with an empty store.
        fs::hard_link(&self.path, &kept).or_else(|_| fs::copy(&self.path, &kept).map(drop))?;
        fs::rename(directory.join(REPAIRED), &self.path)?;
        #[cfg(unix)]
        File::open(directory)?.sync_all()?;
        Ok(kept)
    }

    /// The errors of the file outside its jobs.
    pub(crate) fn complaint(&self) -> Option<&str> {
        self.complaint.as_deref()
    }

    /// The jobs that are in it, the oldest first.
    pub(crate) fn ids(&self) -> impl Iterator<Item = Uuid> {
        self.ids.iter().copied()
    }

    /// A job with all of its readable parts.
    pub(crate) fn job(&self, id: Uuid) -> Result<Salvaged, StoreError> {
        let missing =
            |what| StoreError::damaged(format!("the {what} of job {id}"), "it is not there");
        let header = self.value(&HEADERS, id)?;
        let header = tables::header(id, &header.ok_or_else(|| missing("header"))?)?;
        let input = self.value(&INPUTS, id)?.ok_or_else(|| missing("problem"))?;
        let has_result = header.bytes > input.len() as u64;
        let result = match self.value(&RESULTS, id) {
            Ok(Some(bytes)) => record::result(id, &bytes).map(Some),
            Ok(None) if has_result => Err(missing("result")),
            Ok(None) => Ok(None),
            Err(error) => Err(error),
        };
        let mut job = WholeJob {
            key: self.key(id, &header),
            record: header.record,
            problem: record::problem(id, &input).map(Arc::new)?,
            result: None,
        };
        let lost = match result {
            Ok(result) => {
                job.result = result;
                None
            }
            Err(error) => {
                job.record.status = Status::QUEUED;
                Some(error)
            }
        };
        Ok(Salvaged { job, lost })
    }

    /// The idempotency key of a job, if it can be read and has not expired.
    fn key(&self, id: Uuid, header: &Header) -> Option<IdempotencyKey> {
        let name = header.key.clone()?;
        let entry = match &self.database {
            Some(database) => database
                .read(|it| it.idempotency_entry(&name))
                .ok()
                .flatten(),
            None => None,
        };
        let entry = entry.or_else(|| record::entry(&self.found_value(Kind::Key, id).ok()??).ok());
        let entry = entry.filter(|entry| entry.id == id && !entry.has_expired(Timestamp::now()))?;
        let digest = entry.digest;
        Some(IdempotencyKey { name, digest })
    }

    /// The bytes of a value.
    fn value(&self, values: &Values, id: Uuid) -> Result<Option<Vec<u8>>, StoreError> {
        let read = match &self.database {
            Some(database) => database.read(|it| it.bytes(values, id)),
            None => Ok(None),
        };
        let is_certain = self.database.is_some() && self.complaint.is_none();
        match read {
            Ok(Some(bytes)) => Ok(Some(bytes)),
            Ok(None) if is_certain => Ok(None),
            read => match self.found_value(values.kind, id)? {
                Some(bytes) => Ok(Some(bytes)),
                None => read,
            },
        }
    }

    /// The bytes of a value where it was found.
    fn found_value(&self, kind: Kind, id: Uuid) -> Result<Option<Vec<u8>>, StoreError> {
        let found = self.found().map_err(unreadable)?;
        let Some(place) = found.get(&(kind, id)) else {
            return Ok(None);
        };
        let read = read_at(&self.file, place.offset, place.length).map_err(unreadable)?;
        Ok(Some(read))
    }

    /// All good values of the file.
    fn found(&self) -> io::Result<Arc<Found>> {
        let mut found = self.found.lock();
        match &*found {
            Some(found) => Ok(Arc::clone(found)),
            None => Ok(Arc::clone(found.insert(Arc::new(find(&self.file)?)))),
        }
    }
}

impl Drop for Salvage {
    /// A damaged database may panic when it is closed.
    fn drop(&mut self) {
        let _ = catch_panic(|| drop(self.database.take()));
    }
}

fn of_file_in(path: &Path) -> impl FnOnce(io::Error) -> OpenError {
    |reason| open_error::of_file(path, reason)
}

fn unreadable(reason: io::Error) -> StoreError {
    StoreError::Failed(reason.to_string())
}

fn read_at(mut file: &File, offset: u64, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; length];
    file.seek(SeekFrom::Start(offset))?;
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Searches the whole file for values.
fn find(file: &File) -> io::Result<Found> {
    let length = file.metadata()?.len();
    let (mut found, mut offset) = (Found::new(), 0);
    while offset < length {
        // Chunks overlap by an envelope.
        let there = (length - offset).min((CHUNK + envelope::BYTES) as u64);
        let chunk = read_at(file, offset, there as usize)?;
        for place in memmem::find_iter(&chunk, envelope::MAGIC) {
            let Some(outside) = chunk[place..].first_chunk() else {
                continue;
            };
            let begin = offset + place as u64;
            if let Some((kind, id, bytes)) = envelope::announced(outside)
                && bytes <= length - begin - envelope::BYTES as u64
            {
                let whole = read_at(file, begin, envelope::BYTES + bytes as usize)?;
                note(&mut found, kind, id, begin, &whole);
            }
        }
        offset += CHUNK as u64;
    }
    Ok(found)
}

/// Notes a value if it is good. Of several headers one that has the end of the job counts.
fn note(found: &mut Found, kind: Kind, id: Uuid, begin: u64, whole: &[u8]) {
    let Ok(value) = envelope::opened(kind, id, "", whole) else {
        return;
    };
    let is_better = kind == Kind::Header
        && tables::header(id, value).is_ok_and(|it| it.record.status.state.is_final());
    let place = Place {
        offset: begin + envelope::BYTES as u64,
        length: value.len(),
    };
    let known = found.entry((kind, id)).or_insert(place);
    if is_better {
        *known = place;
    }
}
