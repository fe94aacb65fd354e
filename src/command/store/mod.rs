//! `piad store`: the jobs of servers that do not run.
//!
//! - `copy`: to another store;
//! - `check`, `repair`, `export`: of a store that may be damaged (`source`).

mod check;
mod copy;
mod export;
mod repair;
mod source;

use std::io::{IsTerminal, stderr};
use std::process::ExitCode;
use std::time::Duration;

use indicatif::ProgressBar;
use tokio::runtime::Runtime;

use super::shells;
use crate::config::{Storage, StoreCommand};
use crate::job::counters::Counters;
use crate::job::store::Store;
use crate::job::store::shared::Settings;
use crate::terminal::say;

/// What is done job by job needs few connections.
const SETTINGS: Settings = Settings {
    connections: 2,
    lease: Duration::from_secs(15),
};

/// Does what is asked for; the status says whether it has succeeded.
pub fn run(command: &StoreCommand) -> ExitCode {
    let done = Runtime::new()
        .map_err(|reason| reason.to_string())
        .and_then(|runtime| {
            runtime.block_on(async {
                match command {
                    StoreCommand::Copy { from, to } => copy::copy(from, to).await,
                    StoreCommand::Check { store } => check::check(store).await,
                    StoreCommand::Repair { store } => repair::repair(store).await,
                    StoreCommand::Export { store, directory } => {
                        export::export(store, directory).await
                    }
                }
            })
        });
    match done {
        Ok(said) => shells::show_lines([said.as_str()]),
        Err(reason) => {
            say(format_args!("piad: {reason}"));
            ExitCode::FAILURE
        }
    }
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

/// Tells how many jobs were looked at, on a terminal.
fn counter() -> ProgressBar {
    match stderr().is_terminal() {
        true => ProgressBar::new_spinner(),
        false => ProgressBar::hidden(),
    }
}

/// A number of jobs in words.
fn jobs(count: usize) -> String {
    match count {
        1 => "1 job".to_owned(),
        count => format!("{count} jobs"),
    }
}
