//! Opens or creates a database; errors are described in words.

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use redb::{Database, ReadableDatabase, TableError};

use super::error::catch_panic;
use super::file::{Borrowed, Bytes, StoreFile};
use super::open_error::{OpenError, broken, explain, of_file};
use super::overlay::Overlay;
use super::tables::{FACTS, HEADERS, INPUTS, KEYS, RESULTS, SLACK, VERSION, VERSION_FACT};
use crate::job::store::StoreError;

/// Bytes of the cache of a database, whether its file is on a disk or in memory. Half of it holds the pages
/// of a commit; pages that do not fit in are written first and read again for their checksums.
const CACHE: usize = 32 << 20;

/// Files up to this size are read from end to end at the start, to find damage early.
const CHECKED: u64 = 1 << 30;

/// Opens a database that was open before.
pub(super) fn open_again(bytes: &Bytes) -> Result<Database, StoreError> {
    let open = || {
        let mut builder = Database::builder();
        let bytes = Borrowed::of(bytes);
        Ok(builder.set_cache_size(CACHE).create_with_backend(bytes)?)
    };
    catch_panic(open)?.map_err(|error: redb::Error| error.into())
}

/// Opens the database in these bytes, or creates it.
pub(super) fn in_bytes(bytes: &Bytes) -> Result<Database, OpenError> {
    attempt(Path::new(":memory:"), || {
        let mut builder = Database::builder();
        let bytes = Borrowed::of(bytes);
        let database = builder.set_cache_size(CACHE).create_with_backend(bytes)?;
        make_tables(&database)?;
        Ok(database)
    })
}

/// Opens the file in a directory, or creates it if it is not there, and checks its version.
pub(super) fn open_or_make(
    directory: &Path,
    path: &Path,
) -> Result<(Arc<StoreFile>, Database), OpenError> {
    let of_directory = |reason| OpenError::Directory {
        directory: directory.to_owned(),
        reason,
    };
    fs::create_dir_all(directory).map_err(of_directory)?;
    if !path.try_exists().map_err(of_directory)? {
        make(path)?;
        // On Unix a new name is durable once its directory is on the disk.
        #[cfg(unix)]
        File::open(directory)
            .and_then(|directory| directory.sync_all())
            .map_err(of_directory)?;
    }
    let length = fs::metadata(path).map_err(of_directory)?.len();
    if length == 0 {
        return Err(broken(path, "it is empty"));
    }
    let file = Arc::new(StoreFile::open(path)?);
    let repaired = Arc::new(AtomicBool::new(false));
    let opened = attempt(path, || {
        let mut builder = Database::builder();
        let noted = Arc::clone(&repaired);
        builder.set_repair_callback(move |_| noted.store(true, Ordering::Relaxed));
        let bytes = Borrowed::of(&(Arc::clone(&file) as Bytes));
        let mut database = builder.set_cache_size(CACHE).create_with_backend(bytes)?;
        // A repair, after a crash, has read everything.
        let checked = repaired.load(Ordering::Relaxed) || length > CHECKED;
        if !checked {
            check(&mut database)?;
        }
        Ok(database)
    })?;
    match attempt(path, || version(&opened))? {
        Some(VERSION) => Ok((file, opened)),
        Some(found) => Err(OpenError::Version {
            path: path.to_owned(),
            found,
        }),
        None => Err(broken(path, "it is a database without jobs")),
    }
}

/// Opens the database in a file without changing the file; returns the errors of its pages.
pub(super) fn open_below(
    path: &Path,
    file: &File,
) -> Result<(Database, Option<String>), OpenError> {
    let open = || {
        attempt(path, || {
            let overlay = Overlay::new(file.try_clone()?)?;
            let mut builder = Database::builder();
            Ok(builder.set_cache_size(CACHE).create_with_backend(overlay)?)
        })
    };
    if file
        .metadata()
        .map_err(|reason| of_file(path, reason))?
        .len()
        == 0
    {
        return Err(broken(path, "it is empty"));
    }
    let mut database = open()?;
    let complaint = match attempt(path, || check(&mut database)) {
        Ok(()) => None,
        // The checked database cannot be used any more.
        Err(OpenError::Broken { reason, .. }) => {
            let _ = catch_panic(|| drop(database));
            database = open()?;
            Some(reason)
        }
        Err(error) => return Err(error),
    };
    match attempt(path, || version(&database)) {
        Ok(Some(VERSION)) => Ok((database, complaint)),
        Ok(Some(found)) => Err(OpenError::Version {
            path: path.to_owned(),
            found,
        }),
        Ok(None) => Err(broken(path, "it is a database without jobs")),
        Err(error) => Err(error),
    }
}

/// Creates the file under another name first, so that a file with its name is complete.
fn make(path: &Path) -> Result<(), OpenError> {
    let unfinished = path.with_extension("new");
    let tables = || {
        attempt(&unfinished, || {
            let database = Database::create(&unfinished)?;
            make_tables(&database)
        })
    };
    match tables() {
        Err(OpenError::Broken { .. }) => {
            // An earlier attempt was interrupted.
            let removed = fs::remove_file(&unfinished);
            removed.map_err(|reason| of_file(&unfinished, reason))?;
            tables()?;
        }
        made => made?,
    }
    fs::rename(&unfinished, path).map_err(|reason| of_file(path, reason))
}

fn make_tables(database: &Database) -> Result<(), redb::Error> {
    let transaction = database.begin_write()?;
    transaction
        .open_table(FACTS)?
        .insert(VERSION_FACT, VERSION)?;
    transaction.open_table(HEADERS.table)?;
    transaction.open_table(INPUTS.table)?;
    transaction.open_table(RESULTS.table)?;
    transaction.open_table(KEYS)?;
    transaction.open_table(SLACK)?;
    transaction.commit()?;
    Ok(())
}

/// Reads the whole file and compares the checksums of its pages. redb's other finding, that it has counted the free
/// pages again, happens after each start and does not concern the jobs.
fn check(database: &mut Database) -> Result<(), redb::Error> {
    let _counted_again = database.check_integrity()?;
    Ok(())
}

/// The version of the file; `None` if it has other tables.
fn version(database: &Database) -> Result<Option<u64>, redb::Error> {
    let facts = match database.begin_read()?.open_table(FACTS) {
        Err(TableError::TableDoesNotExist(_)) => return Ok(None),
        facts => facts?,
    };
    let version = facts.get(VERSION_FACT)?;
    Ok(version.map(|version| version.value()))
}

/// Runs an operation of the database, which panics at times on damage.
fn attempt<T>(path: &Path, work: impl FnOnce() -> Result<T, redb::Error>) -> Result<T, OpenError> {
    match catch_panic(work) {
        Ok(done) => done.map_err(|error| explain(path, error)),
        Err(_) => Err(broken(path, "its pages do not fit together")),
    }
}
