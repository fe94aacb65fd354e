//! The file of a store: locked as long as it is open, with disk space allocated for all of its length.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use redb::StorageBackend;
use redb::backends::FileBackend;

use super::open_error::{self, OpenError};

/// The open file of a store. Databases in it are opened one after the other: it stays the same file even if its name
/// changes.
#[derive(Debug)]
pub(super) struct StoreFile {
    path: PathBuf,
    file: File,
    /// Holds the lock.
    backend: FileBackend,
}

impl StoreFile {
    /// Opens a file that no other process has open.
    pub(super) fn open(path: &Path) -> Result<Self, OpenError> {
        let of_file = |reason| open_error::of_file(path, reason);
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).open(path).map_err(of_file)?;
        let length = file.metadata().map_err(of_file)?.len();
        let backend = file.try_clone().map_err(of_file)?;
        let backend =
            FileBackend::new(backend).map_err(|error| open_error::explain(path, error.into()))?;
        // Another program may have left holes in it. If there is no space, they stay.
        let _ = reserve(&file, 0, length);
        Ok(Self {
            path: path.to_owned(),
            file,
            backend,
        })
    }

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The error if this is not the file at its path any more: what is written to it then is lost when it is closed.
    pub(super) fn misplaced(&self) -> Option<String> {
        let path = &self.path;
        let is_same = fs::metadata(path).and_then(|there| Ok(same(&there, &self.file.metadata()?)));
        match is_same {
            Ok(true) => None,
            Ok(false) => Some(format!(
                "{path:?} is another file than the one that is open: put that one back, or start the server again with this one"
            )),
            Err(reason) => Some(format!(
                "{path:?}, which is open, cannot be found there ({reason}): put it back"
            )),
        }
    }
}

#[cfg(unix)]
fn same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// Elsewhere an open file keeps its name.
#[cfg(not(unix))]
fn same(_: &Metadata, _: &Metadata) -> bool {
    true
}

/// Allocates disk space for bytes of a file, which may be beyond its end.
#[cfg(target_os = "linux")]
fn reserve(file: &File, offset: u64, length: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    use rustix::io::{Errno, retry_on_intr};
    if length == 0 {
        return Ok(());
    }
    match retry_on_intr(|| fallocate(file, FallocateFlags::KEEP_SIZE, offset, length)) {
        // Not every file system supports it.
        Err(Errno::OPNOTSUPP | Errno::NOSYS) => Ok(()),
        done => Ok(done?),
    }
}

#[cfg(not(target_os = "linux"))]
fn reserve(_: &File, _: u64, _: u64) -> io::Result<()> {
    Ok(())
}

impl StorageBackend for StoreFile {
    fn len(&self) -> io::Result<u64> {
        self.backend.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.backend.read(offset, out)
    }

    /// A file that grows has space for what will be written, or fails at once: otherwise the disk could be full in the
    /// middle of a commit.
    fn set_len(&self, length: u64) -> io::Result<()> {
        let before = self.len()?;
        let grown = match length.checked_sub(before) {
            Some(more) => reserve(&self.file, before, more),
            None => Ok(()),
        };
        let done = grown.and_then(|()| self.backend.set_len(length));
        if done.is_err() {
            // Releases the partly allocated space.
            let _ = self.backend.set_len(before);
        }
        done
    }

    fn sync_data(&self) -> io::Result<()> {
        self.backend.sync_data()
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.backend.write(offset, data)
    }
}

/// The storage of a database. After an error it can be opened there again.
pub(super) type Bytes = Arc<dyn StorageBackend>;

/// The bytes of one database after the other, which stay open when a database is closed.
#[derive(Debug)]
pub(super) struct Borrowed(Bytes);

impl Borrowed {
    pub(super) fn of(bytes: &Bytes) -> Self {
        Self(Arc::clone(bytes))
    }
}

impl StorageBackend for Borrowed {
    fn len(&self) -> io::Result<u64> {
        self.0.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.0.read(offset, out)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.0.set_len(length)
    }

    fn sync_data(&self) -> io::Result<()> {
        self.0.sync_data()
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.0.write(offset, data)
    }
}
