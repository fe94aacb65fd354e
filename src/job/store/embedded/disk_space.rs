//! Space on the disk, some of which is kept back so that jobs can be deleted when the disk is full.
//!
//! A change writes new pages of the file before it frees old ones, so that even a deletion takes space.
//! Beside the file stands a reserve file. When the disk is full, the reserve is removed, and changes that
//! must be possible use its space. Until it could be written again, new jobs get only the space that
//! deleted jobs have left.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tracing::{info, warn};

/// The name of the reserve file in the data directory.
const FILE: &str = "piad.reserve";

/// Bytes of the reserve: several hundred pages.
const SIZE: usize = 2 << 20;

/// For this long after the disk was full, changes that need space are refused without trying: a failed
/// attempt takes long, as the database has to be opened again after it.
const PAUSE: Duration = Duration::from_millis(500);

/// The disk space of a store.
#[derive(Debug)]
pub(super) struct DiskSpace {
    reserve: PathBuf,
    /// The reserve is complete.
    reserve_exists: bool,
    /// Bytes of jobs that were deleted since the reserve was removed.
    freed: u64,
    /// The end of the pause, if nothing was deleted since the disk was full.
    full_until: Option<Instant>,
}

impl DiskSpace {
    /// The space of a directory; the reserve is written if it is not there.
    pub(super) fn new(directory: &Path) -> Self {
        let reserve = directory.join(FILE);
        let length = fs::metadata(&reserve).map_or(0, |metadata| metadata.len());
        let mut space = Self {
            reserve,
            reserve_exists: length == SIZE as u64,
            freed: 0,
            full_until: None,
        };
        if !space.restore_reserve() {
            warn!("the disk is full: there is no space for the reserve of the store");
        }
        space
    }

    /// Whether a change that needs so many bytes may be tried.
    pub(super) fn admits(&mut self, bytes: u64) -> bool {
        if self.full_until.is_some_and(|until| Instant::now() < until) {
            return false;
        }
        if self.restore_reserve() {
            return true;
        }
        let enough = bytes <= self.freed;
        if enough {
            self.freed -= bytes;
        }
        enough
    }

    /// The disk was full when a change was tried.
    pub(super) fn ran_out(&mut self) {
        self.full_until = Some(Instant::now() + PAUSE);
    }

    /// Jobs of so many bytes were deleted.
    pub(super) fn add_freed(&mut self, bytes: u64) {
        self.full_until = None;
        self.freed += bytes;
        self.restore_reserve();
    }

    /// Removes the reserve, for a change that must be possible; says whether that has made space.
    pub(super) fn release_reserve(&mut self) -> bool {
        if !self.reserve_exists {
            return false;
        }
        (self.reserve_exists, self.freed) = (false, 0);
        info!("the disk is full: the reserve of the store gives way");
        fs::remove_file(&self.reserve).is_ok()
    }

    /// Writes the reserve again, if there is space for it; says whether it exists.
    fn restore_reserve(&mut self) -> bool {
        if !self.reserve_exists {
            self.reserve_exists = write(&self.reserve).is_ok();
            if !self.reserve_exists {
                // What was written of it takes space that others need.
                let _ = fs::remove_file(&self.reserve);
            }
        }
        self.reserve_exists
    }
}

/// Writes pseudo-random bytes, which no file system compresses.
fn write(reserve: &Path) -> io::Result<()> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let words = std::iter::repeat_with(|| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state.to_le_bytes()
    });
    let bytes: Vec<u8> = words.take(SIZE / 8).flatten().collect();
    let mut file = fs::File::create(reserve)?;
    file.write_all(&bytes)?;
    file.sync_data()
}
