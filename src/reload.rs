//! Files that are read again when they change, or when the process gets SIGHUP.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use prometheus_client::metrics::counter::Counter;
use tokio::task::spawn_blocking;
use tokio::time::sleep;
use tracing::{error, info};

use crate::signals;

/// How often files are looked at.
const LOOK: Duration = Duration::from_secs(2);

/// By what changes of files are noticed: their times and lengths.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Seen(Vec<Option<(SystemTime, u64)>>);

impl Seen {
    /// How files are now.
    pub(crate) fn of<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        let seen = |path| {
            let about = fs::metadata(path).ok()?;
            Some((about.modified().ok()?, about.len()))
        };
        Self(files.into_iter().map(seen).collect())
    }
}

/// What is read from files.
pub(crate) trait Reload: Send + Sync + 'static {
    /// What it is called in the log.
    const WHAT: &'static str;

    /// Reads the files if they have changed, or anyway; tells whether it has. If they are not valid, what was read
    /// before stays.
    fn load_again(&self, anyway: bool) -> Result<bool, String>;
}

/// Reads the files again whenever it is due.
pub(crate) async fn keep_current<R: Reload>(it: Arc<R>, failures: Counter) {
    let mut hangups = signals::hangups();
    loop {
        let is_asked_for = tokio::select! {
            () = sleep(LOOK) => false,
            () = hangups.next() => true,
        };
        let reloaded = Arc::clone(&it);
        match spawn_blocking(move || reloaded.load_again(is_asked_for)).await {
            Ok(Ok(true)) => info!("the {} were loaded again", R::WHAT),
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
