//! The fit of a file, from its points to its outputs.

use std::env;
use std::path::Path;
use std::sync::Arc;

use axum::body::Body;
use http_body_util::BodyExt;

use super::client::{Client, Current};
use super::events::{EndEvent, Event, Events, JobEvent};
use super::failure::Failure;
use super::file_query::FileQuery;
use super::input::{Content, Input};
use super::iterations;
use super::options::JobOptions;
use super::outputs::{self, Output, Place};
use super::parts::Parts;
use super::point_kind::PointKind;
use super::progress::Progress;
use super::request::Request;
use super::summary::{self, Shape};
use super::table::{self, Row};
use crate::access::tokens::BOOTSTRAP;
use crate::config::fit_arguments::FitArguments;
use crate::files;
use crate::terminal::say;

/// Fits and writes a file, or all parts of one with several.
pub(super) async fn fit(
    arguments: &FitArguments,
    input: &Path,
    outputs: &[Output],
    current: &Current,
    is_one_of_many: bool,
) -> Result<Vec<Row>, Failure> {
    let quiet = arguments.quiet || is_one_of_many;
    let (owned, path, formats) = (arguments.clone(), input.to_owned(), outputs.to_vec());
    let reading = tokio::task::spawn_blocking(move || prepare(&owned, &path, &formats)).await;
    let prepared = reading.map_err(|reason| Failure::Failed(reason.to_string()))??;
    if let Some(directory) = &arguments.iterations {
        iterations::prepare(directory)?;
    }
    let client = Arc::new(client(arguments).await?);
    current.set(&client);
    let Prepared {
        input,
        options,
        request,
        query,
    } = prepared;
    let of_parts = Parts {
        arguments,
        outputs,
        query: &query,
        is_one_of_many,
    };
    if input.content == Content::Batch {
        return of_parts.fit(&client, &input, &options, request).await;
    }
    let Request {
        path,
        media_type,
        body,
    } = request;
    let events = match client.post(&path, media_type, body).await? {
        Ok(events) => events,
        Err(refusal) if refusal.wants_part() && arguments.part.is_none() => {
            let request = Request::of_parts(&input, &options)?;
            return of_parts.fit(&client, &input, &options, request).await;
        }
        Err(refusal) => return Err(refusal.of_fit(&input, &options)),
    };
    let (job, end) = follow(&client, events, Progress::new(quiet)).await?;
    let written = write(&client, arguments, &query, outputs, &end).await;
    let shape = match summary::is_automatic(&job) {
        true => shape(&client).await?,
        false => None,
    };
    if !quiet {
        summary::tell(&input.name, &job, &end, shape.as_ref());
        for (place, bytes) in &written.files {
            summary::tell_written(place, *bytes);
        }
        if client.is_remote() {
            let path = client.job.get().map_or("", String::as_str);
            say(format_args!("job {}", client.shown(path)));
        }
    }
    let rows = vec![summary::row(&input.name, &job, &end, shape.as_ref())];
    if arguments.quiet && !is_one_of_many {
        table::report_bad(&rows);
    }
    match written.failure {
        Some(failure) => Err(failure),
        None => Ok(rows),
    }
}

/// The request, and its input.
struct Prepared {
    input: Input,
    options: JobOptions,
    request: Request,
    /// The options of the outputs.
    query: FileQuery,
}

/// Reads the input, and refuses what cannot succeed before the fit.
fn prepare(
    arguments: &FitArguments,
    input: &Path,
    outputs: &[Output],
) -> Result<Prepared, Failure> {
    let input = Input::read(input, arguments.max_input.as_u64())?;
    let options = JobOptions::of(arguments, &input)?;
    if arguments.server.is_none() {
        options.check_foot_points(&input)?;
    }
    let request = Request::new(&input, &options)?;
    let mut query = FileQuery::new(arguments);
    outputs::check_formats(outputs, &mut query, || {
        let points = PointKind::of(&input, &options.hints())?;
        Some(points.placed(options.places_heights()))
    })?;
    Ok(Prepared {
        input,
        options,
        request,
        query,
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
                let unsaid =
                    || Failure::Failed("the stream ended without a `job` event".to_owned());
                return Ok((job.ok_or_else(unsaid)?, end));
            }
        }
    }
}

/// The files written before a failure.
struct Written {
    files: Vec<(String, u64)>,
    failure: Option<Failure>,
}

/// Writes all outputs of a fit that has a result; a failure does not stop the others.
async fn write(
    client: &Client,
    arguments: &FitArguments,
    query: &FileQuery,
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
        match write_one(client, query, output).await {
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
        let all =
            iterations::write_all(client, arguments, query, (directory, first.format), last).await;
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

async fn write_one(client: &Client, query: &FileQuery, output: &Output) -> Result<u64, Failure> {
    let path = output.format.path(query);
    let job = client.job.get().map_or("", String::as_str);
    match client.get(&format!("{job}{path}"), "*/*").await? {
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
