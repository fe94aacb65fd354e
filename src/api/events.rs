//! A job as a stream of events: `job`, then every `iteration` from 0 on, then `end`.
//!
//! The stream is pulled: the next frame is asked for when the connection has taken the one before.
//! The JSON of an iteration is made once for each view and shared by all streams; only what stands
//! around it differs between server-sent events and NDJSON.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::{Bytes, BytesMut};
use futures_util::stream;
use serde_json::json;
use tokio::sync::watch;
use tokio::time::{Duration, Instant, sleep_until};
use tracing::error;
use uuid::Uuid;

use super::milestones::Milestones;
use super::negotiate::{self, Framing};
use super::options::form::Encoding;
use super::options::object::StreamObject;
use super::options::{StreamOptions, StreamParameters};
use super::problem::Problem;
use super::{App, encode, jobs, view};
use crate::job::Job;
use crate::job::cursor::{Cursor, Next};
use crate::job::frame::Frame;
use crate::job::state::Status;
use crate::job::store::StoreError;

const LAST_EVENT_ID: &str = "last-event-id";
const RESUMED_AFTER: HeaderName = HeaderName::from_static("piad-resumed-after");
const END: &str = "end";

/// Events up to this size are sent in one piece.
const ONE_PIECE: usize = 16 * 1024;

/// `GET /v1/jobs/{id}/events`
pub async fn get(
    State(app): State<App>,
    Path(id): Path<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let framing = negotiate::framing(&headers)?;
    let parameters: StreamParameters = negotiate::query(&uri)?;
    let job = jobs::find(&app, &id).await?;
    let defaults = StreamObject::of(&job.outline().label)?;
    let options = parameters.options(defaults.as_ref(), job.outline().surface)?;
    if options.form.encoding == Encoding::Base64F32 {
        let problem = job.problem().await?;
        parameters.check_range(defaults.as_ref(), &problem)?;
    }
    match last_event_id(&headers, parameters.last_event_id)? {
        None => Ok(stream(&app, job, framing, options, None)),
        // Only this status keeps an EventSource from connecting again.
        Some(LastEvent::End) => Ok(StatusCode::NO_CONTENT.into_response()),
        Some(LastEvent::Iteration(k)) => Ok(stream(&app, job, framing, options, Some(k))),
    }
}

/// The last event that a client has seen.
enum LastEvent {
    Iteration(usize),
    End,
}

/// The header wins over the query parameter, which is for clients that cannot set headers.
fn last_event_id(
    headers: &HeaderMap,
    parameter: Option<String>,
) -> Result<Option<LastEvent>, Problem> {
    let header = headers
        .get(LAST_EVENT_ID)
        .map(|value| value.to_str().unwrap_or("?").to_owned())
        .filter(|id| !id.is_empty());
    let in_header = header.is_some();
    let Some(id) = header.or(parameter).filter(|id| !id.is_empty()) else {
        return Ok(None);
    };
    if id == END {
        return Ok(Some(LastEvent::End));
    }
    negotiate::plain_number(&id)
        .map(|k| Some(LastEvent::Iteration(k)))
        .ok_or_else(|| {
            let detail = format!("{id:?} is no event id: ids are iteration numbers and \"end\"");
            if in_header {
                Problem::at_header("Last-Event-ID", detail)
            } else {
                Problem::at_parameter("last_event_id", detail)
            }
        })
}

/// The events of a job after iteration `seen`.
pub fn stream(
    app: &App,
    job: Arc<Job>,
    framing: Framing,
    options: StreamOptions,
    seen: Option<usize>,
) -> Response {
    let mut cursor = Cursor::new(Arc::clone(&job), 0);
    if options.latest {
        cursor.only_latest();
    }
    let first = match seen {
        None => 0,
        // What the client has seen tells which milestones it has seen reached.
        Some(k) if !options.milestones.is_empty() => k,
        Some(k) => k + 1,
    };
    cursor.seek(first.next_multiple_of(options.every));
    let milestones = Milestones::new(options.milestones.clone());
    let feed = Feed {
        cursor,
        job,
        framing,
        milestones: Some(milestones).filter(|milestones| !milestones.all_reached()),
        options,
        seen,
        complete: false,
        stage: Stage::Opening,
        pending: VecDeque::new(),
        heartbeat: app.config.heartbeat,
        quiet_until: Instant::now(),
        stopping: app.stopping.clone(),
    };
    let body = stream::unfold(feed, |mut feed| async move {
        let piece = feed.next().await?;
        Some((Ok::<_, Infallible>(piece), feed))
    });
    let mut response = Response::new(Body::from_stream(body));
    let headers = response.headers_mut();
    let content_type = match framing {
        Framing::Sse => "text/event-stream",
        Framing::Ndjson => "application/x-ndjson",
    };
    for (name, value) in [
        (header::CONTENT_TYPE, content_type),
        (header::CACHE_CONTROL, "no-store, no-transform"),
        (HeaderName::from_static("x-accel-buffering"), "no"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if let Some(k) = seen {
        headers.insert(RESUMED_AFTER, HeaderValue::from(k));
    }
    response
}

/// Where a stream is.
enum Stage {
    Opening,
    /// Before the `job` event, which tells numbers that are known when the job has begun.
    Waiting,
    Iterations,
    Over,
}

/// What a stream was waiting for.
enum Happened {
    Next(Result<Next, StoreError>),
    Nothing,
    Stopping,
}

/// The state of one stream.
struct Feed {
    job: Arc<Job>,
    cursor: Cursor,
    framing: Framing,
    options: StreamOptions,
    milestones: Option<Milestones>,
    /// The last iteration that the client has.
    seen: Option<usize>,
    /// The client has complete control points, to which changes can be applied.
    complete: bool,
    stage: Stage,
    /// Pieces of the event that is being sent.
    pending: VecDeque<Bytes>,
    heartbeat: Duration,
    /// When the client hears that the stream is still there, if it hears nothing else.
    quiet_until: Instant,
    stopping: watch::Receiver<bool>,
}

impl Feed {
    /// The next piece of the stream.
    async fn next(&mut self) -> Option<Bytes> {
        self.quiet_until = Instant::now() + self.heartbeat;
        loop {
            if let Some(piece) = self.pending.pop_front() {
                return Some(piece);
            }
            match self.stage {
                Stage::Opening => {
                    self.stage = Stage::Waiting;
                    // Proxies hold the answer back until there is something to pass on.
                    if self.framing == Framing::Sse {
                        return Some(Bytes::from_static(b": piad\nretry: 2000\n\n"));
                    }
                }
                Stage::Waiting | Stage::Iterations => self.advance().await,
                Stage::Over => return None,
            }
        }
    }

    /// Waits for the next frame, the next heartbeat or the end of the server.
    async fn advance(&mut self) {
        let happened = tokio::select! {
            next = self.cursor.next() => Happened::Next(next),
            () = sleep_until(self.quiet_until) => Happened::Nothing,
            _ = self.stopping.wait_for(|stopping| *stopping) => Happened::Stopping,
        };
        match happened {
            Happened::Next(next) => {
                if let Err(reason) = self.push_next(next).await {
                    // Without an end the client comes back.
                    error!(job = %self.job.id(), %reason, "a stream broke off");
                    self.stage = Stage::Over;
                }
            }
            Happened::Nothing => {
                self.quiet_until += self.heartbeat;
                self.push_comment(": still here\n\n".into());
            }
            Happened::Stopping => {
                // Clients come back one after the other, to whoever serves them then.
                let retry = 1000 + Uuid::new_v4().as_u128() % 3000;
                self.push_comment(format!(": the server is stopping\nretry: {retry}\n\n"));
                self.stage = Stage::Over;
            }
        }
    }

    /// The next frame or the end, and first of all the job.
    async fn push_next(&mut self, next: Result<Next, StoreError>) -> Result<(), StoreError> {
        let next = next?;
        if matches!(self.stage, Stage::Waiting) {
            self.stage = Stage::Iterations;
            let data = encode::description(&self.job).await?;
            self.push("job", None, None, data);
        }
        match next {
            Next::Frame(frame) => self.take(&frame).await,
            Next::End(status) => self.finish(&status).await,
        }
    }

    /// Sends a frame, if the client wants it.
    async fn take(&mut self, frame: &Arc<Frame>) -> Result<(), StoreError> {
        let Some(milestones) = &mut self.milestones else {
            return self.push_frame(frame, None).await;
        };
        let milestone = milestones.reach(frame.level.error.max);
        if milestones.all_reached() {
            self.cursor.only_end();
        }
        let new = Some(frame.level.iteration) > self.seen;
        match milestone.filter(|_| new) {
            Some(milestone) => self.push_frame(frame, Some(milestone)).await?,
            // Others have their turn, however many frames are left out.
            None => tokio::task::consume_budget().await,
        }
        Ok(())
    }

    async fn push_frame(
        &mut self,
        frame: &Arc<Frame>,
        milestone: Option<f64>,
    ) -> Result<(), StoreError> {
        let k = frame.level.iteration;
        let changes = self.options.changes.as_ref();
        let form = changes
            .filter(|_| self.complete && frame.moved.is_some())
            .unwrap_or(&self.options.form);
        let data = encode::frame(&self.job, frame, form).await?;
        self.push("iteration", Some(&k.to_string()), milestone, data);
        self.seen = Some(k);
        self.complete = true;
        if self.milestones.is_none() {
            let next = (k + 1).next_multiple_of(self.options.every);
            self.cursor.seek(next);
        }
        Ok(())
    }

    /// The last iteration, if it was left out so far, and the end.
    async fn finish(&mut self, status: &Status) -> Result<(), StoreError> {
        self.stage = Stage::Over;
        let last = status.levels.map(|levels| levels.last.iteration);
        if self.options.every > 1
            && let Some(last) = last.filter(|&last| Some(last) > self.seen)
        {
            self.cursor.seek(last);
            if let Next::Frame(frame) = self.cursor.next().await? {
                self.push_frame(&frame, None).await?;
            }
        }
        let data = view::end(&self.job, status);
        self.push("end", Some(END), None, data);
        Ok(())
    }

    /// NDJSON has no comments.
    fn push_comment(&mut self, text: String) {
        if self.framing == Framing::Sse {
            self.pending.push_back(text.into());
        }
    }

    /// A milestone becomes the first field of the data, which stay as all readers share them.
    fn push(&mut self, event: &str, id: Option<&str>, milestone: Option<f64>, mut data: Bytes) {
        self.job.resources().counters.events.inc();
        let (mut before, after) = match self.framing {
            Framing::Sse => {
                let id = id.map_or(String::new(), |id| format!("id: {id}\n"));
                (format!("event: {event}\n{id}data: "), "\n\n")
            }
            Framing::Ndjson => {
                // Numbers stay numbers.
                let id = id.map_or(String::new(), |id| match id {
                    END => format!(r#""id":"{END}","#),
                    number => format!(r#""id":{number},"#),
                });
                (format!(r#"{{"event":"{event}",{id}"data":"#), "}\n")
            }
        };
        if let Some(milestone) = milestone
            && data.starts_with(b"{")
        {
            before.push_str(&format!("{{\"milestone\":{},", json!(milestone)));
            data = data.slice(1..);
        }
        let before = Bytes::from(before);
        let after = Bytes::from_static(after.as_bytes());
        if data.len() > ONE_PIECE {
            self.pending.extend([before, data, after]);
        } else {
            let mut whole = BytesMut::with_capacity(before.len() + data.len() + after.len());
            whole.extend([before, data, after]);
            self.pending.push_back(whole.freeze());
        }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        let gone = !matches!(self.stage, Stage::Over);
        if gone && self.options.cancels {
            self.job.request_cancel();
        }
    }
}
