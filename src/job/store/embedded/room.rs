//! Room on the disk: what is kept back, so that jobs can be deleted when the disk is full.
//!
//! A change of the file writes new pages before it frees old ones, so that even deleting takes room.
//! A reserve file has some. When the disk is full it gives way to whatever must be possible. Until
//! it stands again, new jobs get only what deleted ones have left.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tracing::{info, warn};

/// The name of the reserve in the data directory.
const FILE: &str = "piad.reserve";

/// Bytes of the reserve: several hundred pages.
const SIZE: usize = 2 << 20;

/// How long what needs room is refused at once after the disk was full: to try takes long, as the
/// database has to be opened again afterwards.
const PAUSE: Duration = Duration::from_millis(500);

/// The room of a store.
#[derive(Debug)]
pub(super) struct Room {
    reserve: PathBuf,
    /// The reserve is there.
    stands: bool,
    /// Bytes of jobs that were deleted since the reserve has given way.
    left: u64,
    /// Nothing was deleted since the disk was full.
    full_until: Option<Instant>,
}

impl Room {
    /// The room in a directory; the reserve is made if it is not there.
    pub(super) fn new(directory: &Path) -> Self {
        let reserve = directory.join(FILE);
        let length = fs::metadata(&reserve).map_or(0, |metadata| metadata.len());
        let mut room = Self {
            reserve,
            stands: length == SIZE as u64,
            left: 0,
            full_until: None,
        };
        if !room.restore() {
            warn!("the disk is full: there is no room for the reserve of the store");
        }
        room
    }

    /// Whether something of so many bytes may be tried.
    pub(super) fn admits(&mut self, bytes: u64) -> bool {
        if self.full_until.is_some_and(|until| Instant::now() < until) {
            return false;
        }
        if self.restore() {
            return true;
        }
        let enough = bytes <= self.left;
        if enough {
            self.left -= bytes;
        }
        enough
    }

    /// There was no room for something that was admitted.
    pub(super) fn was_missing(&mut self) {
        self.full_until = Some(Instant::now() + PAUSE);
    }

    /// So many bytes of jobs were deleted.
    pub(super) fn was_left(&mut self, bytes: u64) {
        self.full_until = None;
        self.left += bytes;
        self.restore();
    }

    /// Makes room for what must be possible; says whether that has helped.
    pub(super) fn release(&mut self) -> bool {
        if !self.stands {
            return false;
        }
        (self.stands, self.left) = (false, 0);
        info!("the disk is full: the reserve of the store gives way");
        fs::remove_file(&self.reserve).is_ok()
    }

    /// Has the reserve stand again, if there is room for it; says whether it stands.
    fn restore(&mut self) -> bool {
        if !self.stands {
            self.stands = write(&self.reserve).is_ok();
            if !self.stands {
                // What was written of it is room for others.
                let _ = fs::remove_file(&self.reserve);
            }
        }
        self.stands
    }
}

/// Writes bytes that no file system makes smaller.
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
