//! Connections that can be cut and frozen: a proxy for TCP.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream, UnixStream};
use tokio::sync::watch;

/// Where connections lead.
#[derive(Clone)]
pub enum Target {
    /// To one of these addresses after the other; those that are not there are left out.
    Servers(watch::Receiver<Vec<String>>),
    /// To a socket of this machine.
    Socket(PathBuf),
}

/// What becomes of the connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Open,
    /// Nothing comes through.
    Frozen,
}

/// A proxy.
pub struct Wire {
    pub address: String,
    mode: watch::Sender<Mode>,
    /// Connections made before the last cut are closed.
    cuts: watch::Sender<usize>,
}

impl Wire {
    pub async fn to(target: Target) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let (mode, frozen) = watch::channel(Mode::Open);
        let (cuts, cut) = watch::channel(0);
        let turn = Arc::new(AtomicUsize::new(0));
        tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                let (target, frozen, mut cut) = (target.clone(), frozen.clone(), cut.clone());
                let turn = Arc::clone(&turn);
                cut.mark_unchanged();
                tokio::spawn(async move {
                    tokio::select! {
                        () = forward(client, target, frozen, turn) => {}
                        _ = cut.changed() => {}
                    }
                });
            }
        });
        Self {
            address,
            mode,
            cuts,
        }
    }

    /// Closes all connections.
    pub fn cut(&self) {
        self.cuts.send_modify(|count| *count += 1);
    }

    /// Lets nothing through, neither on old nor on new connections.
    pub fn freeze(&self) {
        self.mode.send_replace(Mode::Frozen);
    }

    pub fn thaw(&self) {
        self.mode.send_replace(Mode::Open);
    }
}

async fn forward(
    client: TcpStream,
    target: Target,
    frozen: watch::Receiver<Mode>,
    turn: Arc<AtomicUsize>,
) {
    match target {
        Target::Socket(path) => {
            if let Ok(server) = UnixStream::connect(path).await {
                exchange(client, server, frozen).await;
            }
        }
        Target::Servers(servers) => {
            let servers = servers.borrow().clone();
            for _ in 0..servers.len() {
                let next = turn.fetch_add(1, Ordering::Relaxed) % servers.len();
                if let Ok(server) = TcpStream::connect(&servers[next]).await {
                    return exchange(client, server, frozen).await;
                }
            }
        }
    }
}

async fn exchange<C, S>(client: C, server: S, frozen: watch::Receiver<Mode>)
where
    C: AsyncRead + AsyncWrite,
    S: AsyncRead + AsyncWrite,
{
    let (from_client, to_client) = tokio::io::split(client);
    let (from_server, to_server) = tokio::io::split(server);
    // When one side closes, the other is closed, too.
    tokio::select! {
        () = pass(from_client, to_server, frozen.clone()) => {}
        () = pass(from_server, to_client, frozen) => {}
    }
}

async fn pass(
    mut from: impl AsyncRead + Unpin,
    mut to: impl AsyncWrite + Unpin,
    mut mode: watch::Receiver<Mode>,
) {
    let mut bytes = vec![0; 64 << 10];
    while let Ok(length @ 1..) = from.read(&mut bytes).await {
        if mode.wait_for(|mode| *mode == Mode::Open).await.is_err()
            || to.write_all(&bytes[..length]).await.is_err()
        {
            return;
        }
    }
}
