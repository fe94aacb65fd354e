//! Reloads files when they change, or when the process gets SIGHUP.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use prometheus_client::metrics::counter::Counter;
use sha2::{Digest, Sha256};
use tokio::task::spawn_blocking;
use tokio::time::sleep;
use tracing::{error, info};

use crate::files::{self, MAX_SETTINGS_BYTES};
use crate::signals;

/// The interval between checks of files.
const LOOK: Duration = Duration::from_secs(2);

/// The state of a file by which changes are noticed: its contents, as times and lengths can be the same after a change.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Seen(Vec<Result<State, ErrorKind>>);

/// The state of a file.
#[derive(Debug, PartialEq, Eq)]
enum State {
    /// The SHA-256 of its content.
    Content([u8; 32]),
    /// The time and the length of a pipe, whose content can be read once.
    Pipe(SystemTime, u64),
}

impl Seen {
    /// The current states of files.
    pub(crate) fn of<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        let seen = |path: &PathBuf| State::of(path).map_err(|reason| reason.kind());
        Self(files.into_iter().map(seen).collect())
    }
}

impl State {
    fn of(path: &Path) -> io::Result<Self> {
        let about = fs::metadata(path)?;
        if !about.is_file() {
            return Ok(Self::Pipe(about.modified()?, about.len()));
        }
        let content = files::read(path, MAX_SETTINGS_BYTES)?;
        Ok(Self::Content(Sha256::digest(content).into()))
    }
}

/// The value read from files.
pub(crate) trait Reload: Send + Sync + 'static {
    /// Its name in the log.
    const WHAT: &'static str;

    /// Reads the files if they have changed, or if `anyway`; returns true if it has read them. If they are not valid,
    /// the last valid contents stay.
    fn load_again(&self, anyway: bool) -> Result<bool, String>;
}

/// Reloads the files when it is due.
pub(crate) async fn keep_current<R: Reload>(it: Arc<R>, failures: Counter) {
    let mut hangups = signals::hangups();
    loop {
        let is_requested = tokio::select! {
            () = sleep(LOOK) => false,
            () = hangups.next() => true,
        };
        let reloaded = Arc::clone(&it);
        match spawn_blocking(move || reloaded.load_again(is_requested)).await {
            Ok(Ok(true)) => info!("the {} were reloaded", R::WHAT),
            Ok(Ok(false)) => {}
            Ok(Err(reason)) => {
                failures.inc();
                error!("{reason}; the {} before stay in use", R::WHAT);
            }
            // The runtime ends.
            Err(_) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn changes_of_equal_time_and_length_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.toml");
        let write = |text: &str, at: SystemTime| {
            fs::write(&path, text).unwrap();
            let file = File::options().write(true).open(&path).unwrap();
            file.set_modified(at).unwrap();
            Seen::of([&path])
        };
        let (now, later) = (SystemTime::UNIX_EPOCH, SystemTime::now());
        let one = write("one", now);
        assert_ne!(one, write("two", now));
        assert_eq!(one, write("one", later));
        fs::remove_file(&path).unwrap();
        let gone = Seen::of([&path]);
        assert_ne!(one, gone);
        assert_eq!(gone, Seen::of([&path]));
    }
}
