//! Serves one connection with HTTP/1.1 or HTTP/2.

use std::convert::Infallible;
use std::pin::pin;
use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderValue, Request, Version, header};
use hyper::body::Incoming;
use hyper::rt::Executor;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use hyper_util::server::conn::auto::Builder;
use tokio::time::Duration;
use tower::Service;
use tracing::debug;

use super::accept::Doors;
use super::activity::{Activity, Overdue, Times};
use super::limits::Crowded;
use super::listener::Stream;
use super::proxy;
use super::request_body::RequestBody;
use super::response_body::{ResponseBody, Served};
use super::stream_timeout::unless_stalled;
use super::write_timeout::TimedStream;
use crate::job::peer::Peer;

/// How long a connection that is being shut down may be silent before it is cut off.
const LINGER: Duration = Duration::from_secs(2);

/// The most requests at a time on an HTTP/2 connection.
const STREAMS: u32 = 100;

/// How much an HTTP/2 client may send of a request before the server takes it, and of all requests of a
/// connection: what waits there is counted nowhere else.
const STREAM_WINDOW: u32 = 64 << 10;
const CONNECTION_WINDOW: u32 = 256 << 10;

/// Where a connection comes from.
#[derive(Clone, Copy)]
pub(super) struct Caller {
    pub(super) peer: Peer,
    /// It is a trusted proxy, whose requests tell whose they are.
    is_proxy: bool,
    /// It is beyond the limits.
    pub(super) crowded: Option<Crowded>,
}

impl Caller {
    /// A client.
    pub(super) fn direct(peer: Peer) -> Self {
        Self {
            peer,
            is_proxy: false,
            crowded: None,
        }
    }

    /// A trusted proxy with clients behind it.
    pub(super) fn proxy(peer: Peer) -> Self {
        Self {
            is_proxy: true,
            ..Self::direct(peer)
        }
    }

    /// The peer whose connections are limited; none for a proxy.
    pub(super) fn limited(self) -> Option<Peer> {
        (!self.is_proxy).then_some(self.peer)
    }
}

/// Serves a connection until it ends, is told to stop, or does nothing for too long.
pub(super) async fn serve(stream: Stream, caller: Caller, doors: Arc<Doors>, times: Times) {
    let served = converse(stream, caller, doors, times);
    Peer::scope(Some(caller.peer), served).await;
}

async fn converse(stream: Stream, caller: Caller, doors: Arc<Doors>, times: Times) {
    let mut stopping = doors.stopping.clone();
    let activity = Arc::new(Activity::new());
    let io = TimedStream::new(stream, Arc::clone(&activity), times.write);
    let requests = Arc::clone(&activity);
    let service = service_fn(move |request: Request<Incoming>| {
        let (doors, activity) = (Arc::clone(&doors), Arc::clone(&requests));
        answer(doors, activity, caller, request)
    });
    let peer = caller.peer;
    let mut builder = Builder::new(Streams {
        peer,
        write: times.write,
    });
    // The time for heads is checked with the other timeouts: see `activity`.
    builder.http1().header_read_timeout(None);
    builder
        .http2()
        .max_concurrent_streams(STREAMS)
        .initial_stream_window_size(STREAM_WINDOW)
        .initial_connection_window_size(CONNECTION_WINDOW);
    let mut connection = pin!(builder.serve_connection(TokioIo::new(io), service));
    tokio::select! {
        ended = connection.as_mut() => return told(ended),
        overdue = activity.overdue(times) => {
            debug!(%peer, "a connection is closed: {overdue:?}");
            if overdue == Overdue::Half {
                return;
            }
        }
        _ = stopping.wait_for(|stopping| *stopping) => {}
    }
    connection.as_mut().graceful_shutdown();
    tokio::select! {
        ended = connection => told(ended),
        () = activity.silence(LINGER) => {}
    }
}

fn told<E: std::fmt::Display>(ended: Result<(), E>) {
    if let Err(reason) = ended {
        debug!("a connection has ended: {reason}");
    }
}

async fn answer(
    doors: Arc<Doors>,
    activity: Arc<Activity>,
    caller: Caller,
    request: Request<Incoming>,
) -> Result<hyper::Response<ResponseBody>, Infallible> {
    let multiplexed = request.version() == Version::HTTP_2;
    let open = activity.open(multiplexed);
    let (mut head, body) = request.into_parts();
    let expects = head.headers.contains_key(header::EXPECT);
    let client = (caller.is_proxy).then(|| proxy::client(&head.headers, &doors.proxies));
    let peer = client.flatten().map_or(caller.peer, Peer::at);
    let mut crowded = caller.crowded;
    // Connections limit the other requests of a peer.
    let slot = (multiplexed || caller.is_proxy).then(|| doors.connections.admit_request(peer));
    let slot = slot.and_then(|slot| slot.map_err(|reason| crowded = Some(reason)).ok());
    if let Some(reason) = crowded {
        head.extensions.insert(reason);
    }
    let (body, unread) = RequestBody::new(body);
    let request = Request::from_parts(head, Body::new(body));
    let routed = doors.router.clone().call(request);
    let mut response = Peer::scope(Some(peer), routed).await?;
    // In HTTP/2 an unread body does not block other streams.
    if !multiplexed && !(unread.is_out_of_the_way(expects).await) {
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
        activity.cut_short();
    }
    // The tenant, if the request had a token.
    let peer = response.extensions_mut().remove().unwrap_or(peer);
    let served = Served {
        peer,
        _open: open,
        _slot: slot,
    };
    Ok(response.map(|body| ResponseBody::new(body, served, multiplexed)))
}

/// Spawns the tasks of HTTP/2 streams.
#[derive(Clone, Copy)]
struct Streams {
    peer: Peer,
    write: Duration,
}

impl<F> Executor<F> for Streams
where
    F: Future<Output = ()> + Send + 'static,
{
    fn execute(&self, task: F) {
        let task = unless_stalled(self.write, task);
        tokio::spawn(Peer::scope(Some(self.peer), task));
    }
}
