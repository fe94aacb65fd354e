//! Accepts connections; each is served by a task of its own.

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
use super::connection::{self, Caller};
use super::limits::{Admission, Connections};
use super::rarely::Rarely;
use crate::job::counters::Counters;
use crate::job::peer::Peer;

/// How long to wait when connections cannot be accepted, for example without free file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// The shortest time between two log lines about the same repeated event.
const TELLING: Duration = Duration::from_secs(10);

/// Times of connections beyond the limits, which are there for short health checks.
const BEYOND: Times = Times {
    head: Duration::from_secs(2),
    idle: Duration::from_millis(100),
    write: Duration::from_secs(2),
};

/// What it takes to accept and serve connections.
pub(super) struct Doors {
    /// Where requests go.
    pub(super) router: Router,
    /// How long connections may do nothing.
    pub(super) times: Times,
    pub(super) connections: Connections,
    pub(super) counters: Counters,
    /// Becomes true when no more are taken in.
    pub(super) stopping: watch::Receiver<bool>,
}

impl Doors {
    /// Accepts connections until the server stops; returns when all of them have ended.
    pub(super) async fn serve(mut self, listeners: Vec<TcpListener>) {
        let mut tasks = JoinSet::new();
        let (mut failures, mut crowds) = (Rarely::new(TELLING), Rarely::new(TELLING));
        loop {
            let (accepted, room) = tokio::select! {
                next = async {
                    let room = self.connections.room().await;
                    (next(&listeners).await, room)
                } => next,
                Some(ended) = tasks.join_next() => {
                    tell(ended);
                    continue;
                }
                _ = self.stopping.wait_for(|stopping| *stopping) => break,
            };
            match accepted {
                Ok((stream, address)) => {
                    prepare(&stream);
                    let peer = Peer::at(address.ip());
                    let task = self.take_in(stream, peer, &mut crowds);
                    tasks.spawn(async move {
                        task.await;
                        drop(room);
                    });
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
        while let Some(ended) = tasks.join_next().await {
            tell(ended);
        }
    }

    /// The task of a connection.
    fn take_in(
        &self,
        stream: TcpStream,
        peer: Peer,
        crowds: &mut Rarely,
    ) -> impl Future<Output = ()> + use<> {
        let open = self.counters.open_connection();
        let admission = self.connections.admit(peer);
        let (crowded, times) = match &admission {
            Admission::Within(_) => (None, self.times),
            Admission::Beyond(crowded, _) => (Some(*crowded), BEYOND),
        };
        if let Some(crowded) = crowded
            && let Some(times) = crowds.happened(Instant::now())
        {
            warn!(%peer, times, "{crowded}: only /livez, /readyz and /metrics are answered");
        }
        let caller = Caller { peer, crowded };
        let (router, stopping) = (self.router.clone(), self.stopping.clone());
        let served = connection::serve(stream, caller, router, times, stopping);
        async move {
            let _open = open;
            match admission {
                Admission::Within(_slot) => served.await,
                Admission::Beyond(_, ended) => tokio::select! {
                    () = served => {}
                    // It makes room for another one.
                    _ = ended => {}
                },
            }
        }
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

/// Whether the client has disconnected before it was accepted, which is no fault of the server.
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
