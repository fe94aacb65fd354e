//! `piad fit`: a fit from a file to files; and completions and manual pages of the program.
//!
//! The command sends the same requests as any client, to a server in this process without a port, or to one at a URL.
//! So both give the same control points and the same errors.
//!
//! - `single`: the fit of a file; `parts`: those of all parts of a file; `several`: those of many files;
//! - `input`: the input; the flags are in `config`;
//! - `point_kind`: the kind of points, detected before the fit;
//! - `options`: flags as fields of a job; `request`: the job that is posted;
//! - `client`: the server; `events`: its events of the fit;
//! - `outputs`, `iterations`: the files; `progress`, `summary`, `table`: reports on the terminal;
//! - `refusal`: errors at their flag or line (`pointer`); `failure`: the exit status;
//! - [`shells`]: completions and manual pages;
//! - [`store`]: `piad store`, for the stores of servers.

mod client;
mod events;
mod failure;
mod file_query;
mod input;
mod iterations;
mod options;
mod outputs;
mod parts;
mod point_kind;
mod pointer;
mod progress;
mod refusal;
mod request;
mod several;
pub mod shells;
mod single;
pub mod store;
mod summary;
mod table;
pub mod token;

use std::process::ExitCode;
use std::time::Duration;

use tokio::runtime::Runtime;
use tokio::time::timeout;

use client::Current;
use failure::Failure;
use table::Row;

use crate::config::fit_arguments::FitArguments;
use crate::signals;
use crate::terminal::say;

/// The exit status after an interrupt, as shells report it.
const INTERRUPTED: u8 = 130;

/// How long the cancelling of a job on another server may take.
const CANCELLING: Duration = Duration::from_secs(2);

/// Runs `piad fit`; the exit status says how it ended.
pub fn fit(arguments: &FitArguments) -> ExitCode {
    let runtime = match Runtime::new() {
        Ok(runtime) => runtime,
        Err(reason) => {
            say(format_args!("piad: {reason}"));
            return ExitCode::FAILURE;
        }
    };
    let status = runtime.block_on(async {
        let current = Current::default();
        let outcome = tokio::select! {
            biased;
            () = signals::interrupted() => {
                if let Some(client) = current.get() {
                    // A server that does not answer is not waited for.
                    let _ = timeout(CANCELLING, client.cancel()).await;
                }
                return INTERRUPTED;
            }
            outcome = run(arguments, &current) => outcome,
        };
        match outcome {
            Ok(converged) => u8::from(!converged),
            Err(failure) => {
                failure.tell();
                failure.status()
            }
        }
    });
    // Abandoned work ends with the process.
    runtime.shutdown_background();
    status.into()
}

/// Fits and writes; returns true if all fits have converged.
async fn run(arguments: &FitArguments, current: &Current) -> Result<bool, Failure> {
    let rows = match &arguments.input[..] {
        [input] if !outputs::is_directory(arguments) => {
            let outputs = outputs::outputs(arguments)?;
            single::fit(arguments, input, &outputs, current, false).await?
        }
        inputs => several::fit(arguments, inputs, current).await?,
    };
    Ok(rows.iter().all(Row::is_good))
}
