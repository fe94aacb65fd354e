//! `piad store copy`: moves the jobs of a server to another store.

use std::io::{IsTerminal, stderr};
use std::process::ExitCode;
use std::time::Duration;

use indicatif::ProgressBar;
use tokio::runtime::Runtime;

use crate::config::Storage;
use crate::job::counters::Counters;
use crate::job::store::Store;
use crate::job::store::copy::copy as copy_jobs;
use crate::job::store::shared::Settings;

/// What is copied job by job needs few connections.
const SETTINGS: Settings = Settings {
    connections: 2,
    lease: Duration::from_secs(15),
};

/// Copies all jobs; the status says whether it has succeeded.
pub fn copy(from: &Storage, to: &Storage) -> ExitCode {
    let copied = Runtime::new()
        .map_err(|reason| reason.to_string())
        .and_then(|runtime| runtime.block_on(copy_all(from, to)));
    match copied {
        Ok(count) => {
            eprintln!("{count} jobs copied");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("piad: {reason}");
            ExitCode::FAILURE
        }
    }
}

async fn copy_all(from: &Storage, to: &Storage) -> Result<usize, String> {
    if from == to {
        return Err("both stores are the same".to_owned());
    }
    if let Storage::Directory(path) = from
        && !path.exists()
    {
        return Err(format!("there is no store in {path:?}"));
    }
    let (from, to) = (open(from).await?, open(to).await?);
    let bar = match stderr().is_terminal() {
        true => ProgressBar::new_spinner(),
        false => ProgressBar::hidden(),
    };
    let tell = |count: usize| bar.set_message(format!("{count} jobs"));
    let copied = copy_jobs(&from, &to, tell).await;
    bar.finish_and_clear();
    copied.map_err(|error| error.to_string())
}

/// Opens a store that no server uses.
async fn open(storage: &Storage) -> Result<Store, String> {
    if *storage == Storage::Memory {
        return Err(":memory: is no store that lasts".to_owned());
    }
    let store = Store::open(storage.place(SETTINGS), Counters::default()).await;
    let store = store.map_err(|error| error.to_string())?;
    if let Some(shared) = store.shared()
        && shared
            .is_in_use()
            .await
            .map_err(|error| error.to_string())?
    {
        return Err("servers are running jobs of the database: stop them first".to_owned());
    }
    Ok(store)
}
