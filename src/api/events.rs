//! The events of a job as the body of an answer: as server-sent events, a JSON object a line, or
//! protobuf messages with their lengths in front.
//!
//! The data of an event are shared by all streams; only what stands around them differs.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::{BufMut, Bytes, BytesMut};
use futures_util::stream;
use prost::encoding::encode_varint;
use serde_json::json;
use uuid::Uuid;

use super::feed::{Event, Feed};
use super::negotiate::{self, Framing};
use super::options::form::Encoding;
use super::options::object::StreamObject;
use super::options::{StreamOptions, StreamParameters};
use super::path::Named;
use super::problem::Problem;
use super::rpc::encoded::Encoded;
use super::{App, jobs};
use crate::job::Job;

const LAST_EVENT_ID: &str = "last-event-id";
const RESUMED_AFTER: HeaderName = HeaderName::from_static("piad-resumed-after");
const END: &str = "end";

/// Events up to this size are sent in one piece.
const ONE_PIECE: usize = 16 * 1024;

/// `GET /v1/jobs/{id}/events`
pub async fn get(
    State(app): State<App>,
    Named(id): Named<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let framing = negotiate::framing(&headers)?;
    let parameters: StreamParameters = negotiate::query(&uri)?;
    let job = jobs::find(&app, &id).await?;
    let defaults = StreamObject::of(&job.outline().label)?;
    let options = parameters.framed(framing, defaults.as_ref(), job.outline().surface)?;
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
        .map(|value| value.to_str().unwrap_or("?"));
    let in_header = event_of(header).map_err(|why| Problem::at_header("Last-Event-ID", why))?;
    let in_query = event_of(parameter.as_deref())
        .map_err(|why| Problem::at_parameter("last_event_id", why))?;
    Ok(in_header.or(in_query))
}

/// The event of an id; an empty one is none. Or what is wrong with it.
fn event_of(id: Option<&str>) -> Result<Option<LastEvent>, String> {
    match id {
        None | Some("") => Ok(None),
        Some(END) => Ok(Some(LastEvent::End)),
        Some(id) => negotiate::plain_number(id)
            .map(|k| Some(LastEvent::Iteration(k)))
            .ok_or_else(|| format!("{id:?} is no event id: ids are iteration numbers and \"end\"")),
    }
}

/// The events of a job after iteration `seen`.
pub fn stream(
    app: &App,
    job: Arc<Job>,
    framing: Framing,
    options: StreamOptions,
    seen: Option<usize>,
) -> Response {
    let feed = Feed::new(app, job, options, seen);
    let mut pending = VecDeque::new();
    // Proxies hold the answer back until there is something to pass on.
    if framing == Framing::Sse {
        pending.push_back(Bytes::from_static(b": piad\nretry: 2000\n\n"));
    }
    let body = stream::unfold((feed, pending), move |(mut feed, mut pending)| async move {
        while pending.is_empty() {
            write(framing, feed.next().await?, &mut pending);
        }
        let piece = pending.pop_front()?;
        Some((Ok::<_, Infallible>(piece), (feed, pending)))
    });
    let mut response = Response::new(Body::from_stream(body));
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_TYPE, framing.media_type()),
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

/// Writes an event in as few pieces as its size makes sensible.
fn write(framing: Framing, event: Event, pieces: &mut VecDeque<Bytes>) {
    match framing {
        Framing::Sse => write_sse(event, pieces),
        Framing::Ndjson => write_line(event, pieces),
        Framing::Protobuf => write_message(event, pieces),
    }
}

fn write_sse(event: Event, pieces: &mut VecDeque<Bytes>) {
    let (head, data, milestone) = match event {
        Event::Job(data) => ("event: job\n".to_owned(), data, None),
        Event::Iteration { k, milestone, data } => {
            (format!("event: iteration\nid: {k}\n"), data, milestone)
        }
        Event::End(data) => (format!("event: end\nid: {END}\n"), data, None),
        Event::Quiet => return pieces.push_back(Bytes::from_static(b": still here\n\n")),
        Event::Stopping => {
            // Clients come back one after the other, to whoever serves them then.
            let retry = 1000 + Uuid::new_v4().as_u128() % 3000;
            let comment = format!(": the server is stopping\nretry: {retry}\n\n");
            return pieces.push_back(comment.into());
        }
    };
    let (start, data) = with_milestone(milestone, data);
    push(format!("{head}data: {start}"), data, "\n\n", pieces);
}

/// A JSON object a line; there are no comments.
fn write_line(event: Event, pieces: &mut VecDeque<Bytes>) {
    let (head, data, milestone) = match event {
        Event::Job(data) => (r#"{"event":"job","data":"#.to_owned(), data, None),
        Event::Iteration { k, milestone, data } => {
            let head = format!(r#"{{"event":"iteration","id":{k},"data":"#);
            (head, data, milestone)
        }
        Event::End(data) => {
            let head = format!(r#"{{"event":"end","id":"{END}","data":"#);
            (head, data, None)
        }
        Event::Quiet | Event::Stopping => return,
    };
    let (start, data) = with_milestone(milestone, data);
    push(format!("{head}{start}"), data, "}\n", pieces);
}

/// A `WatchJobResponse` after its length; there are no comments.
fn write_message(event: Event, pieces: &mut VecDeque<Bytes>) {
    let Some(message) = Encoded::event(event) else {
        return;
    };
    let (head, body) = message.parts();
    let mut before = BytesMut::with_capacity(10 + head.len());
    encode_varint((head.len() + body.len()) as u64, &mut before);
    before.put(head);
    push(before, body, "", pieces);
}

/// A milestone becomes the first field of the data, which stay as all readers share them.
fn with_milestone(milestone: Option<f64>, data: Bytes) -> (String, Bytes) {
    match milestone {
        Some(milestone) if data.starts_with(b"{") => {
            let start = format!("{{\"milestone\":{},", json!(milestone));
            (start, data.slice(1..))
        }
        _ => (String::new(), data),
    }
}

/// Large data are passed on as they are, small ones in one piece with what stands around them.
fn push(before: impl Into<Bytes>, data: Bytes, after: &'static str, pieces: &mut VecDeque<Bytes>) {
    let before: Bytes = before.into();
    let after = Bytes::from_static(after.as_bytes());
    if data.len() > ONE_PIECE {
        let all = [before, data, after].into_iter();
        pieces.extend(all.filter(|piece| !piece.is_empty()));
    } else {
        let mut whole = BytesMut::with_capacity(before.len() + data.len() + after.len());
        whole.extend([before, data, after]);
        pieces.push_back(whole.freeze());
    }
}
