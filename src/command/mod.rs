//! `piad fit`: a fit from a file to files, and what shells and manuals need to know of the program.
//!
//! A fit is asked of a server as any client asks it: one inside of this process without a port, or one
//! at a URL. So both give the same control points and refuse the same things.
//!
//! - `input`: what is read; the flags are in `config`;
//! - `point_kind`: what is known of the points before the fit;
//! - `options`: flags as fields of a job; `request`: the job that is posted;
//! - `client`: the server; `events`: what it tells of the fit;
//! - `outputs`, `iterations`: the files; `progress`, `summary`: what is told to people;
//! - `refusal`: what is wrong, at its flag or line (`pointer`); `failure`: the status in the end;
//! - [`shells`]: completions and manual pages;
//! - [`store`]: `piad store`, which is about the jobs of servers.

mod client;
mod events;
mod failure;
mod input;
mod iterations;
mod lines;
mod options;
mod outputs;
mod point_kind;
mod pointer;
mod progress;
mod refusal;
mod request;
pub mod shells;
pub mod store;
mod summary;
pub mod token;

use std::env;
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::Duration;

use axum::body::Body;
use http_body_util::BodyExt;
use tokio::runtime::Runtime;
use tokio::time::timeout;

use client::Client;
use events::{EndEvent, Event, Events, JobEvent};
use failure::Failure;
use input::Input;
use options::Asked;
use outputs::{Output, Place};
use point_kind::PointKind;
use progress::Progress;
use request::Request;
use summary::Shape;

use crate::access::tokens::BOOTSTRAP;
use crate::config::fit_arguments::FitArguments;
use crate::files;
use crate::signals;
use crate::terminal::say;

/// The status after an interrupt, as shells tell it.
const INTERRUPTED: u8 = 130;

/// How long the cancelling of a job on another server may take.
const CANCELLING: Duration = Duration::from_secs(2);

/// Fits what the arguments ask for; the status says how it ended.
pub fn fit(arguments: &FitArguments) -> ExitCode {
    let runtime = match Runtime::new() {
        Ok(runtime) => runtime,
        Err(reason) => {
            say(format_args!("piad: {reason}"));
            return ExitCode::FAILURE;
        }
    };
    let status = runtime.block_on(async {
        let client = OnceLock::new();
        let outcome = tokio::select! {
            biased;
            () = signals::interrupted() => {
                if let Some(client) = client.get() {
                    // A server that does not answer is not waited for.
                    let _ = timeout(CANCELLING, Client::cancel(client)).await;
                }
                return INTERRUPTED;
            }
            outcome = run(arguments, &client) => outcome,
        };
        match outcome {
            Ok(converged) => u8::from(!converged),
            Err(failure) => {
                failure.tell();
                failure.status()
            }
        }
    });
    // Work that nobody waits for any more ends with the process.
    runtime.shutdown_background();
    status.into()
}

/// Fits and writes; tells whether the fit has converged.
async fn run(arguments: &FitArguments, shared: &OnceLock<Client>) -> Result<bool, Failure> {
    let outputs = outputs::outputs(arguments)?;
    let (owned, formats) = (arguments.clone(), outputs.clone());
    let reading = tokio::task::spawn_blocking(move || prepare(&owned, &formats)).await;
    let prepared = reading.map_err(|reason| Failure::Failed(reason.to_string()))??;
    let Prepared {
        input,
        asked,
        request,
    } = prepared;
    if let Some(directory) = &arguments.iterations {
        iterations::prepare(directory)?;
    }
    let client = client(arguments).await?;
    let client = shared.get_or_init(|| client);
    let Request {
        path,
        media_type,
        body,
    } = request;
    let answer = client.post(&path, media_type, body).await?;
    let events = answer.map_err(|refusal| refusal.of_fit(&input, &asked))?;
    let (job, end) = follow(client, events, Progress::new(arguments.quiet)).await?;
    let written = write(client, arguments, &outputs, &end).await;
    if !arguments.quiet {
        let shape = match summary::is_automatic(&job) {
            true => shape(client).await?,
            false => None,
        };
        summary::tell(&input.name, &job, &end, shape.as_ref());
        for (place, bytes) in &written.files {
            summary::tell_written(place, *bytes);
        }
        if client.is_remote() {
            let path = client.job.get().map_or("", String::as_str);
            say(format_args!("job {}", client.shown(path)));
        }
    }
    match written.failure {
        Some(failure) => Err(failure),
        None => Ok(end.state == "converged"),
    }
}

/// What is posted, and what it was made of.
struct Prepared {
    input: Input,
    asked: Asked,
    request: Request,
}

/// Reads the input, and refuses what is known to be impossible before the fit.
fn prepare(arguments: &FitArguments, outputs: &[Output]) -> Result<Prepared, Failure> {
    let input = Input::read(&arguments.input, arguments.max_input.as_u64())?;
    let asked = Asked::of(arguments, &input)?;
    if arguments.server.is_none() {
        asked.check_foot_points(&input)?;
    }
    let request = Request::new(&input, &asked)?;
    outputs::check_formats(outputs, || PointKind::of(&input, &asked.hints()))?;
    Ok(Prepared {
        input,
        asked,
        request,
    })
}

/// The server that fits.
async fn client(arguments: &FitArguments) -> Result<Client, Failure> {
    let Some(url) = &arguments.server else {
        return Client::here(arguments.iterations.is_some()).await;
    };
    let token = arguments.token_file.as_ref().map(|path| {
        let failed = |reason| Failure::usage(format!("{}: {reason}", path.display()));
        files::read_settings(path).map_err(failed)
    });
    let variable = || env::var(BOOTSTRAP).ok().filter(|it| !it.is_empty());
    let token = token.transpose()?.or_else(variable);
    Client::there(url, token.as_deref().map(str::trim))
}

/// Follows a fit to its end.
async fn follow(
    client: &Client,
    body: Body,
    mut progress: Progress,
) -> Result<(Box<JobEvent>, Box<EndEvent>), Failure> {
    let mut events = Events::new(client, body);
    let mut job = None;
    loop {
        match events.next().await? {
            Event::Job(event) => {
                progress.begin(&event);
                job = Some(event);
            }
            Event::Iteration(level) => progress.step(&level),
            Event::End(end) => {
                progress.end();
                let unsaid = || Failure::Failed("the fit has ended without a word".to_owned());
                return Ok((job.ok_or_else(unsaid)?, end));
            }
        }
    }
}

/// What was written, until something went wrong.
struct Written {
    files: Vec<(String, u64)>,
    failure: Option<Failure>,
}

/// Writes all outputs of a fit that has a result; those that cannot be written keep no other back.
async fn write(
    client: &Client,
    arguments: &FitArguments,
    outputs: &[Output],
    end: &EndEvent,
) -> Written {
    let mut written = Written {
        files: Vec::new(),
        failure: None,
    };
    if end.error.is_none() {
        return written;
    }
    for output in outputs {
        match write_one(client, arguments, output).await {
            Ok(_) if output.place == Place::Standard => {}
            Ok(bytes) => written.files.push((output.place.to_string(), bytes)),
            Err(failure) => {
                if let Some(before) = written.failure.replace(failure) {
                    before.tell();
                }
            }
        }
    }
    if let (Some(directory), Some(first)) = (&arguments.iterations, outputs.first()) {
        let last = end.iterations;
        let all = iterations::write_all(client, arguments, directory, first.format, last).await;
        match all {
            Ok((files, bytes)) => {
                let name = format!("{files} iterations to {}", directory.display());
                written.files.push((name, bytes));
            }
            Err(failure) => written.failure = Some(failure),
        }
    }
    written
}

async fn write_one(
    client: &Client,
    arguments: &FitArguments,
    output: &Output,
) -> Result<u64, Failure> {
    let suffix = output.format.suffix(arguments.units.as_deref());
    let job = client.job.get().map_or("", String::as_str);
    match client.get(&format!("{job}/result{suffix}"), "*/*").await? {
        Ok(body) => outputs::write(&output.place, body).await,
        Err(refusal) => Err(Failure::Failed(format!(
            "{}: {}",
            output.place, refusal.detail
        ))),
    }
}

/// The shape of the control points of a result.
async fn shape(client: &Client) -> Result<Option<Shape>, Failure> {
    let job = client.job.get().map_or("", String::as_str);
    let path = format!("{job}/result?encoding=base64");
    let Ok(body) = client.get(&path, "application/json").await? else {
        return Ok(None);
    };
    let body = body.collect().await.map(|body| body.to_bytes());
    Ok(serde_json::from_slice(&body.unwrap_or_default()).ok())
}
