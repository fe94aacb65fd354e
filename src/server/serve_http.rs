//! HTTP on a connection, in the version of the client.
//!
//! Two buffers of 8 KiB and what else hyper has for HTTP/1.1 are most of the memory of a connection. So an idle
//! connection is taken back from hyper, which gets it again with the next request.

use std::pin::Pin;
use std::sync::Arc;

use axum::http::Request;
use bytes::Bytes;
use hyper::body::Incoming;
use hyper::rt::Executor;
use hyper::server::conn::{http1, http2};
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use hyper_util::server::graceful::GracefulConnection;
use tokio::io::AsyncWriteExt;
use tokio::sync::watch;
use tokio::time::{Duration, timeout};
use tracing::debug;

use super::connection::{self, Caller};
use super::context::ServerContext;
use super::gathered_writes::GatheredWrites;
use super::idle_tracking::{Activity, Overdue, Times};
use super::listener::Stream;
use super::stream_timeout::unless_stalled;
use super::write_timeout::TimedStream;
use crate::job::peer::Peer;
use crate::trim;

/// How long a connection may be idle before it is taken back.
const QUIET: Duration = Duration::from_secs(5);

/// How long a connection that is being shut down may be silent before it is cut off.
const LINGER: Duration = Duration::from_secs(2);

/// The preface of each HTTP/2 connection (RFC 9113, 3.4).
const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// The most requests at a time on an HTTP/2 connection.
const STREAMS: u32 = 100;

/// How much an HTTP/2 client may send of a request before the server reads it, and of all requests of a connection:
/// these bytes are outside the memory accounting.
const STREAM_WINDOW: u32 = 64 << 10;
const CONNECTION_WINDOW: u32 = 256 << 10;

/// Serves a connection until it ends, is stopped, or is idle for too long.
pub(super) async fn serve(
    stream: Stream,
    caller: Caller,
    context: Arc<ServerContext>,
    times: Times,
) {
    let served = serve_connection(stream, caller, context, times);
    Peer::scope(Some(caller.peer), served).await;
}

async fn serve_connection(
    stream: Stream,
    caller: Caller,
    context: Arc<ServerContext>,
    times: Times,
) {
    let activity = Arc::new(Activity::new());
    let mut watch = Watch {
        peer: caller.peer,
        activity: Arc::clone(&activity),
        times,
        stopping: context.stopping.clone(),
    };
    let mut io = TimedStream::new(stream, Arc::clone(&activity), times.write);
    let service = service_fn(move |request: Request<Incoming>| {
        connection::answer(Arc::clone(&context), Arc::clone(&activity), caller, request)
    });
    loop {
        let begins = tokio::select! {
            begins = io.begins_with(PREFACE) => begins,
            _ = watch.end() => None,
        };
        match begins {
            // A client that does not read the end of the connection gets none.
            None => return drop(timeout(LINGER, io.shutdown()).await),
            Some(true) => {
                let streams = Streams {
                    peer: caller.peer,
                    write: times.write,
                };
                let connection = http2::Builder::new(streams)
                    .max_concurrent_streams(STREAMS)
                    .initial_stream_window_size(STREAM_WINDOW)
                    .initial_connection_window_size(CONNECTION_WINDOW)
                    .serve_connection(TokioIo::new(GatheredWrites::new(io)), service);
                // Boxed: connections with HTTP/1.1 would have room for it, too.
                watch.serve(Box::pin(connection).as_mut()).await;
                return;
            }
            Some(false) => {
                // The time for heads is checked with the other timeouts: see `idle_tracking`.
                let connection = http1::Builder::new()
                    .header_read_timeout(None)
                    .serve_connection(TokioIo::new(io), service.clone());
                let mut connection = Box::new(connection);
                if watch.serve(Pin::new(&mut *connection)).await == Served::ToItsEnd {
                    return;
                }
                let parts = connection.into_parts();
                io = parts.io.into_inner();
                // A copy: even nothing would keep the buffer that it is a part of.
                io.unread(Bytes::copy_from_slice(&parts.read_buf));
                trim::soon();
            }
        }
    }
}

/// The events that end a connection.
struct Watch {
    peer: Peer,
    activity: Arc<Activity>,
    times: Times,
    stopping: watch::Receiver<bool>,
}

/// The result of serving a connection.
#[derive(PartialEq, Eq)]
enum Served {
    ToItsEnd,
    UntilQuiet,
}

impl Watch {
    /// Completes when the connection has timed out, or the server stops.
    async fn end(&mut self) -> Option<Overdue> {
        tokio::select! {
            overdue = self.activity.overdue(self.times) => {
                debug!(peer = %self.peer, "a connection is closed: {overdue:?}");
                Some(overdue)
            }
            _ = self.stopping.wait_for(|stopping| *stopping) => None,
        }
    }

    /// Serves requests until the connection ends, or is idle for some time.
    async fn serve<C>(&mut self, mut connection: Pin<&mut C>) -> Served
    where
        C: GracefulConnection<Error = hyper::Error>,
    {
        let activity = Arc::clone(&self.activity);
        tokio::select! {
            ended = connection.as_mut() => {
                log_end(ended);
                return Served::ToItsEnd;
            }
            () = activity.quiet(QUIET) => return Served::UntilQuiet,
            end = self.end() => {
                if end == Some(Overdue::Half) {
                    return Served::ToItsEnd;
                }
            }
        }
        connection.as_mut().graceful_shutdown();
        tokio::select! {
            ended = connection => log_end(ended),
            () = activity.silence(LINGER) => {}
        }
        Served::ToItsEnd
    }
}

fn log_end(ended: Result<(), hyper::Error>) {
    if let Err(reason) = ended {
        debug!("a connection has ended: {reason}");
    }
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
