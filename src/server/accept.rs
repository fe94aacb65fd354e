//! Takes in connections, each of which has a task of its own.

use std::future::poll_fn;
use std::io;
use std::net::SocketAddr;
use std::task::Poll;
use std::time::Instant;

use axum::Router;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{JoinError, JoinSet};
use tokio::time::{Duration, sleep};
use tracing::{error, warn};

use super::activity::Times;
use super::connection;
use super::rarely::Rarely;
use crate::job::peer::Peer;

/// How long to wait when connections cannot be taken in, as when there are no descriptors left.
const PAUSE: Duration = Duration::from_millis(100);

/// How often to tell about what keeps happening.
pub(super) const TELLING: Duration = Duration::from_secs(10);

/// Takes in connections until `stopping` becomes true; returns when all of them have ended.
pub(super) async fn serve(
    listeners: Vec<TcpListener>,
    router: Router,
    times: Times,
    mut stopping: watch::Receiver<bool>,
) {
    let mut connections = JoinSet::new();
    let mut failures = Rarely::new(TELLING);
    let stopped = stopping.clone();
    loop {
        let accepted = tokio::select! {
            accepted = next(&listeners) => accepted,
            Some(ended) = connections.join_next() => {
                tell(ended);
                continue;
            }
            _ = stopping.wait_for(|stopping| *stopping) => break,
        };
        match accepted {
            Ok((stream, address)) => {
                prepare(&stream);
                let peer = Peer::at(address.ip());
                let (router, stopped) = (router.clone(), stopped.clone());
                connections.spawn(connection::serve(stream, peer, router, times, stopped));
            }
            Err(reason) if is_of_the_connection(&reason) => {}
            Err(reason) => {
                if let Some(times) = failures.happened(Instant::now()) {
                    error!(times, "connections cannot be taken in: {reason}");
                }
                sleep(PAUSE).await;
            }
        }
    }
    drop(listeners);
    while let Some(ended) = connections.join_next().await {
        tell(ended);
    }
}

/// The next connection at any of the addresses.
async fn next(listeners: &[TcpListener]) -> io::Result<(TcpStream, SocketAddr)> {
    poll_fn(|context| {
        for listener in listeners {
            if let Poll::Ready(accepted) = listener.poll_accept(context) {
                return Poll::Ready(accepted);
            }
        }
        Poll::Pending
    })
    .await
}

/// Events are small and must leave at once.
fn prepare(stream: &TcpStream) {
    if let Err(reason) = stream.set_nodelay(true) {
        warn!("TCP_NODELAY: {reason}");
    }
}

/// The client has gone before it was let in.
fn is_of_the_connection(reason: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(
        reason.kind(),
        ConnectionAborted | ConnectionRefused | ConnectionReset
    )
}

fn tell(ended: Result<(), JoinError>) {
    if let Err(reason) = ended {
        error!("the task of a connection has failed: {reason}");
    }
}
