//! Accepts connections; each is served by a task of its own.

use std::future::poll_fn;
use std::io::{self, Cursor};
use std::sync::Arc;
use std::task::Poll;
use std::time::Instant;

use parking_lot::Mutex;
use tokio::io::{AsyncReadExt, join, split};
use tokio::task::{JoinError, JoinSet};
use tokio::time::{Duration, sleep, timeout};
use tracing::{debug, error, warn};

use super::connection::Caller;
use super::context::ServerContext;
use super::idle_tracking::Times;
use super::limits::Admission;
use super::listener::{Incoming, Listener, Stream};
use super::proxy;
use super::serve_http;
use super::tls::Tls;
use crate::job::peer::Peer;
use crate::log_throttle::LogThrottle;

/// How long to wait when connections cannot be accepted, for example without free file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// The shortest time between two log lines about the same repeated event.
const LOG_INTERVAL: Duration = Duration::from_secs(10);

/// Timeouts of connections beyond the limits, which are for short health checks.
const BEYOND: Times = Times {
    head: Duration::from_secs(2),
    idle: Duration::from_millis(100),
    write: Duration::from_secs(2),
};

impl ServerContext {
    /// Accepts connections until the server stops; returns when all of them have ended.
    pub(super) async fn serve(self, mut listeners: Vec<Listener>) {
        let mut tasks = JoinSet::new();
        let mut failures = LogThrottle::new(LOG_INTERVAL);
        let mut stopping = self.stopping.clone();
        let context = Arc::new(self);
        loop {
            let (accepted, room) = tokio::select! {
                next = async {
                    let room = context.connections.room().await;
                    (next(&mut listeners).await, room)
                } => next,
                Some(ended) = tasks.join_next() => {
                    tell(ended);
                    continue;
                }
                _ = stopping.wait_for(|stopping| *stopping) => break,
            };
            match accepted {
                Ok(incoming) => {
                    let context = Arc::clone(&context);
                    tasks.spawn(async move {
                        context.take_in(incoming).await;
                        drop(room);
                    });
                }
                Err(reason) if is_of_the_connection(&reason) => {}
                Err(reason) => {
                    if let Some(times) = failures.record(Instant::now()) {
                        error!(times, "cannot accept connections: {reason}");
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

    /// Serves a connection; a trusted proxy may first send the address of its client.
    async fn take_in(self: Arc<Self>, mut incoming: Incoming) {
        let _open = self.counters.open_connection();
        let proxy = Peer::at(incoming.address);
        if !proxy::is_trusted(&self.proxies, incoming.address) {
            return self.admit(incoming, Caller::direct(proxy)).await;
        }
        let stream = &mut incoming.stream;
        let begun = timeout(self.times.head, proxy::read(stream)).await;
        let begun = begun.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()));
        let proxy::Beginning { origin, rest } = match begun {
            Ok(begun) => begun,
            Err(reason) => return debug!(%proxy, "a connection is closed: {reason}"),
        };
        let caller = match origin {
            // Headers of requests are then those of the client.
            Some(origin) => Caller::direct(origin.peer(proxy)),
            None => Caller::proxy(proxy),
        };
        let (input, output) = split(incoming.stream);
        incoming.stream = Box::new(join(Cursor::new(rest).chain(input), output));
        self.admit(incoming, caller).await;
    }

    async fn admit(self: &Arc<Self>, incoming: Incoming, mut caller: Caller) {
        let admission = self.connections.admit(caller.limited());
        match admission {
            Admission::Within(_slot) => self.serve_connection(incoming, caller, self.times).await,
            Admission::Beyond(exceeded, ended) => {
                if let Some(times) = self.overloads.lock().record(Instant::now()) {
                    let peer = caller.peer;
                    warn!(%peer, times, "{exceeded}: only /livez, /readyz and /metrics are answered");
                }
                caller.exceeded = Some(exceeded);
                tokio::select! {
                    () = self.serve_connection(incoming, caller, BEYOND) => {}
                    // It makes room for another one.
                    _ = ended => {}
                }
            }
        }
    }

    /// Serves a connection, from the network with TLS if there is any.
    async fn serve_connection(self: &Arc<Self>, incoming: Incoming, caller: Caller, times: Times) {
        let stream = match &self.tls {
            // In a box: else the task would keep room for the handshake as long as the connection is open.
            Some(tls) if incoming.is_network => {
                Box::pin(self.encrypted(tls, incoming.stream, times)).await
            }
            _ => Ok(incoming.stream),
        };
        match stream {
            Ok(stream) => serve_http::serve(stream, caller, Arc::clone(self), times).await,
            Err(reason) => {
                self.counters.handshakes_failed.inc();
                debug!(peer = %caller.peer, "a connection is closed: {reason}");
            }
        }
    }

    /// A connection with TLS, whose handshake takes at most as long as the head of a request.
    async fn encrypted(&self, tls: &Tls, stream: Stream, times: Times) -> io::Result<Stream> {
        let mut stopping = self.stopping.clone();
        tokio::select! {
            stream = timeout(times.head, tls.accept(stream)) => {
                stream.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
            }
            _ = stopping.wait_for(|stopping| *stopping) => {
                Err(io::Error::other("the server stops"))
            }
        }
    }
}

/// Log lines about connections beyond the limits.
pub(super) fn overloads() -> Mutex<LogThrottle> {
    Mutex::new(LogThrottle::new(LOG_INTERVAL))
}

/// The next connection at any of the addresses, which take turns.
async fn next(listeners: &mut [Listener]) -> io::Result<Incoming> {
    let (place, accepted) = poll_fn(|context| {
        for (place, listener) in listeners.iter().enumerate() {
            if let Poll::Ready(accepted) = listener.poll_accept(context) {
                return Poll::Ready((place, accepted));
            }
        }
        Poll::Pending
    })
    .await;
    listeners.rotate_left(place + 1);
    accepted
}

/// Returns true if the client has disconnected before it was accepted, which is not an error of the server.
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

#[cfg(test)]
mod tests {
    use tokio::net::{TcpListener, TcpStream};

    use super::*;

    #[tokio::test]
    async fn addresses_take_turns() {
        let bind = || TcpListener::bind("127.0.0.1:0");
        let sockets = [bind().await.unwrap(), bind().await.unwrap()];
        let addresses = sockets.each_ref().map(|it| it.local_addr().unwrap());
        let mut listeners = sockets.map(Listener::Tcp);
        let mut clients = Vec::new();
        for place in [0, 0, 0, 1, 1] {
            clients.push(TcpStream::connect(addresses[place]).await.unwrap());
        }
        let mut at = Vec::new();
        for _ in &clients {
            next(&mut listeners).await.unwrap();
            // The last one served goes to the end.
            let last = listeners[1].to_string();
            at.push(addresses.iter().position(|it| it.to_string() == last));
        }
        assert_eq!(at, [0, 1, 0, 1, 0].map(Some));
    }
}
