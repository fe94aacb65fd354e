//! The events of a job as the body of an answer: as server-sent events, as one JSON object a line, or as
//! length-delimited protobuf messages.
//!
//! The data of an event are encoded once and shared by all streams; only the framing differs.

use std::borrow::Cow;
use std::fmt::Write;
use std::future::poll_fn;
use std::sync::Arc;
use std::task::Poll;

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use bytes::{Buf, BufMut, BytesMut};
use futures_util::{Stream, StreamExt, stream};
use prost::Message;
use prost::encoding::encode_varint;
use serde_json::json;
use uuid::Uuid;

use super::authorize::without_ticket;
use super::negotiate;
use super::path::InPath;
use super::query::StreamQuery;
use crate::api::app::App;
use crate::api::jobs;
use crate::api::media_type::Framing;
use crate::api::problem::Problem;
use crate::api::resume::{END, LastEvent, Start, last_event};
use crate::api::stream::encoded::Encoded;
use crate::api::stream::feed::{Event, Feed};
use crate::api::stream::sending::Outgoing;
use crate::job::Job;
use crate::job::content::Content;
use crate::model::stream::form::Encoding;
use crate::model::stream::options::{self, StreamOptions};

const LAST_EVENT_ID: &str = "last-event-id";
const RESUMED_AFTER: HeaderName = HeaderName::from_static("piad-resumed-after");
/// A field of the `job` event of a stream that restarts.
const RESTARTED: &str = r#""resumed":"restarted""#;

/// `GET /v1/jobs/{id}/events`
pub(super) async fn get(
    State(app): State<App>,
    InPath(id): InPath<String>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let framing = negotiate::framing(&headers)?;
    let query: StreamQuery = negotiate::query(&without_ticket(&uri))?;
    let job = jobs::find(&app, &id).await?;
    let outline = job.outline();
    let (defaults, surface) = (outline.label.stream.as_deref(), outline.surface);
    let spec = query.spec(surface)?;
    let options = StreamOptions::of_reader(&spec, defaults, framing.is_protobuf(), surface)?;
    if options.form.encoding == Encoding::Base64F32 {
        let problem = job.problem().await?;
        options::check_range(&spec, defaults, &problem)?;
    }
    let start = match last_event_id(&job, &headers, query.last_event_id)? {
        None => Start::First,
        // 204 is the only status that keeps an EventSource from reconnecting.
        Some(LastEvent::End) => return Ok(StatusCode::NO_CONTENT.into_response()),
        Some(LastEvent::Iteration(start)) => start,
    };
    let open = app.open_stream()?;
    let held = job.held().await?;
    let mut response = stream(framing, Feed::new(&app, job, options, start, held, open));
    if let Start::After(k) = start {
        let headers = response.headers_mut();
        headers.insert(RESUMED_AFTER, HeaderValue::from(k));
    }
    Ok(response)
}

/// The header overrides the query parameter, which is for clients that cannot set headers.
fn last_event_id(
    job: &Job,
    headers: &HeaderMap,
    parameter: Option<String>,
) -> Result<Option<LastEvent>, Problem> {
    let header = headers
        .get(LAST_EVENT_ID)
        .map(|value| value.to_str().unwrap_or("?"));
    let in_header =
        last_event(job, header).map_err(|why| Problem::at_header("Last-Event-ID", why))?;
    let in_query = last_event(job, parameter.as_deref())
        .map_err(|why| Problem::at_parameter("last_event_id", why))?;
    Ok(in_header.or(in_query))
}

/// The events of a job as the body of an answer.
pub(crate) fn stream(framing: Framing, feed: Feed) -> Response {
    let mut outgoing = Outgoing::new(Arc::clone(feed.job().resources()));
    // Some proxies pass on the head only with the first bytes of the body.
    if framing == Framing::Sse {
        outgoing.text().put_slice(b": piad\nretry: 2000\n\n");
    }
    let events = stream::unfold(feed, |mut feed| async {
        let event = feed.next().await?;
        Some((event, feed))
    });
    let state = (Box::pin(events.fuse()), outgoing);
    let body = stream::unfold(state, move |(mut events, mut outgoing)| async move {
        if outgoing.is_empty() {
            gather(framing, &mut events, &mut outgoing).await;
        }
        let bytes = outgoing.next().await?;
        Some((bytes, (events, outgoing)))
    });
    unstored(framing, Body::from_stream(body))
}

/// A body with this framing, which must not be stored or changed on its way.
pub(super) fn unstored(framing: Framing, body: Body) -> Response {
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_TYPE, framing.media_type()),
        (header::CACHE_CONTROL, "no-store, no-transform"),
        (HeaderName::from_static("x-accel-buffering"), "no"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Waits for an event and takes further ones that are ready, up to a size: many small events go out in
/// one write.
async fn gather(
    framing: Framing,
    events: &mut (impl Stream<Item = Event> + Unpin),
    outgoing: &mut Outgoing,
) {
    poll_fn(|context| {
        loop {
            match events.poll_next_unpin(context) {
                Poll::Ready(Some(event)) => write(framing, event, outgoing),
                Poll::Pending if outgoing.is_empty() => return Poll::Pending,
                Poll::Pending | Poll::Ready(None) => return Poll::Ready(()),
            }
            if outgoing.is_enough() {
                return Poll::Ready(());
            }
        }
    })
    .await;
}

fn write(framing: Framing, event: Event, outgoing: &mut Outgoing) {
    match framing {
        Framing::Sse => write_sse(event, outgoing),
        Framing::Ndjson => write_line(event, outgoing),
        Framing::Protobuf => write_message(event, outgoing),
    }
}

fn write_sse(event: Event, outgoing: &mut Outgoing) {
    let text = outgoing.text();
    let (data, field) = match event {
        Event::Job { data, again } => {
            text.put_slice(b"event: job\n");
            (data, restarted(again))
        }
        Event::Iteration {
            id,
            data,
            milestone,
        } => {
            put(text, format_args!("event: iteration\nid: {id}\n"));
            (data, reached(milestone))
        }
        Event::End(data) => {
            put(text, format_args!("event: end\nid: {END}\n"));
            (data, None)
        }
        Event::Quiet => return text.put_slice(b": still here\n\n"),
        Event::Stopping => {
            // A random delay, so that clients do not all reconnect at the same time.
            let retry = 1000 + Uuid::new_v4().as_u128() % 3000;
            return put(
                text,
                format_args!(": the server is stopping\nretry: {retry}\n\n"),
            );
        }
    };
    text.put_slice(b"data: ");
    push_json(data, field, outgoing);
    outgoing.text().put_slice(b"\n\n");
}

/// Writes an event as a line of JSON. This framing has no comments.
fn write_line(event: Event, outgoing: &mut Outgoing) {
    let text = outgoing.text();
    let (data, field) = match event {
        Event::Job { data, again } => {
            text.put_slice(br#"{"event":"job","data":"#);
            (data, restarted(again))
        }
        Event::Iteration {
            id,
            data,
            milestone,
        } => {
            let mark = if id.kernel.is_some() { "\"" } else { "" };
            put(
                text,
                format_args!(r#"{{"event":"iteration","id":{mark}{id}{mark},"data":"#),
            );
            (data, reached(milestone))
        }
        Event::End(data) => {
            put(
                text,
                format_args!(r#"{{"event":"end","id":"{END}","data":"#),
            );
            (data, None)
        }
        Event::Quiet | Event::Stopping => return,
    };
    push_json(data, field, outgoing);
    outgoing.text().put_slice(b"}\n");
}

/// Writes an event as a length-delimited `WatchJobResponse`. This framing has no comments.
fn write_message(event: Event, outgoing: &mut Outgoing) {
    if let Some(message) = Encoded::event(event) {
        encode_varint(message.encoded_len() as u64, outgoing.text());
        let (head, body) = message.parts();
        outgoing.text().put(head);
        outgoing.push(body);
    }
}

/// The field of a milestone that an iteration reaches for this stream.
fn reached(milestone: Option<f64>) -> Option<Cow<'static, str>> {
    milestone.map(|it| format!("\"milestone\":{}", json!(it)).into())
}

/// The field of a stream that restarts.
fn restarted(again: bool) -> Option<Cow<'static, str>> {
    again.then_some(RESTARTED.into())
}

/// Pushes the shared data of an event, with a field of this stream alone as the first one.
fn push_json(mut data: Content, field: Option<Cow<str>>, outgoing: &mut Outgoing) {
    if let Some(field) = field.filter(|_| data.head.starts_with(b"{")) {
        put(outgoing.text(), format_args!("{{{field},"));
        data.head.advance(1);
    }
    outgoing.push(data);
}

/// Appends formatted text; writing to memory cannot fail.
fn put(text: &mut BytesMut, arguments: std::fmt::Arguments) {
    let _ = text.write_fmt(arguments);
}
