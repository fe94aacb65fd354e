//! Serves one connection with HTTP/1.1 or HTTP/2.

use std::convert::Infallible;
use std::pin::pin;
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderValue, Request, Version, header};
use hyper::body::Incoming;
use hyper::rt::Executor;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use hyper_util::server::conn::auto::Builder;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::watch;
use tokio::time::Duration;
use tower::Service;
use tracing::debug;

use super::activity::{Activity, Overdue, Times};
use super::answer::AnswerBody;
use super::arriving::Arriving;
use super::limits::Crowded;
use super::stalled::unless_stalled;
use super::watched::Watched;
use crate::job::peer::Peer;

/// How long a connection that is being shut down may be silent before it is cut off.
const LINGER: Duration = Duration::from_secs(2);

/// Where a connection comes from.
#[derive(Clone, Copy)]
pub(super) struct Caller {
    pub(super) peer: Peer,
    /// It is beyond the limits.
    pub(super) crowded: Option<Crowded>,
}

/// Serves a connection until it ends, is told to stop, or does nothing for too long.
pub(super) async fn serve<S>(
    stream: S,
    caller: Caller,
    router: Router,
    times: Times,
    stopping: watch::Receiver<bool>,
) where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let served = converse(stream, caller, router, times, stopping);
    Peer::scope(Some(caller.peer), served).await;
}

async fn converse<S>(
    stream: S,
    caller: Caller,
    router: Router,
    times: Times,
    mut stopping: watch::Receiver<bool>,
) where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let activity = Arc::new(Activity::new());
    let io = Watched::new(stream, Arc::clone(&activity), times.write);
    let requests = Arc::clone(&activity);
    let service = service_fn(move |mut request: Request<Incoming>| {
        if let Some(crowded) = caller.crowded {
            request.extensions_mut().insert(crowded);
        }
        answer(router.clone(), Arc::clone(&requests), request)
    });
    let peer = caller.peer;
    let mut builder = Builder::new(Streams {
        peer,
        write: times.write,
    });
    // The time for heads is checked with the other timeouts: see `activity`.
    builder.http1().header_read_timeout(None);
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
    mut router: Router,
    activity: Arc<Activity>,
    request: Request<Incoming>,
) -> Result<hyper::Response<AnswerBody>, Infallible> {
    let multiplexed = request.version() == Version::HTTP_2;
    let open = activity.open(multiplexed);
    let expects = request.headers().contains_key(header::EXPECT);
    let (head, body) = request.into_parts();
    let (body, unread) = Arriving::new(body);
    let request = Request::from_parts(head, Body::new(body));
    let mut response = router.call(request).await?;
    // In HTTP/2 an unread body does not block other streams.
    if !multiplexed && !(unread.is_out_of_the_way(expects).await) {
        let close = HeaderValue::from_static("close");
        response.headers_mut().insert(header::CONNECTION, close);
        activity.cut_short();
    }
    Ok(response.map(|body| AnswerBody::new(body, open, multiplexed)))
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
