//! `piad store`: operations on stores of stopped servers.
//!
//! - `copy`: to another store;
//! - `check`, `repair`, `export`: for a store that may be damaged (`source`).

mod check;
mod copy;
mod counting;
mod export;
mod opening;
mod repair;
mod source;

use std::process::ExitCode;

use tokio::runtime::Runtime;

use super::shells;
use crate::config::StoreCommand;
use crate::terminal::say;

/// Runs the command; the exit status says whether it has succeeded.
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
