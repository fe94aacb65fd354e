//! Connections that can be cut and frozen: a proxy for TCP.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

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
pub struct FaultProxy {
    pub address: String,
    mode: watch::Sender<Mode>,
    /// Connections made before the last cut are closed.
    cuts: watch::Sender<usize>,
    /// The next one on which much is sent gives no answer any more.
    mutes_next: Arc<AtomicBool>,
}

/// More bytes than statements have without data.
const MUCH: usize = 4000;

impl FaultProxy {
    pub async fn to(target: Target) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let (mode, frozen) = watch::channel(Mode::Open);
        let (cuts, cut) = watch::channel(0);
        let mutes_next = Arc::new(AtomicBool::new(false));
        let mutes = Arc::clone(&mutes_next);
        let turn = Arc::new(AtomicUsize::new(0));
        tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                let (target, mut cut, turn) = (target.clone(), cut.clone(), Arc::clone(&turn));
                let obstacles = Obstacles {
                    mode: frozen.clone(),
                    mutes_next: Arc::clone(&mutes),
                };
                cut.mark_unchanged();
                tokio::spawn(async move {
                    tokio::select! {
                        () = forward(client, target, obstacles, turn) => {}
                        _ = cut.changed() => {}
                    }
                });
            }
        });
        Self {
            address,
            mode,
            cuts,
            mutes_next,
        }
    }

    /// Gives no answer any more on the next connection on which much is sent, which comes through.
    pub fn mute_next(&self) {
        self.mutes_next.store(true, Ordering::Release);
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

/// What keeps bytes from coming through.
#[derive(Clone)]
struct Obstacles {
    mode: watch::Receiver<Mode>,
    mutes_next: Arc<AtomicBool>,
}

async fn forward(client: TcpStream, target: Target, obstacles: Obstacles, turn: Arc<AtomicUsize>) {
    match target {
        Target::Socket(path) => {
            if let Ok(server) = UnixStream::connect(path).await {
                exchange(client, server, obstacles).await;
            }
        }
        Target::Servers(servers) => {
            let servers = servers.borrow().clone();
            for _ in 0..servers.len() {
                let next = turn.fetch_add(1, Ordering::Relaxed) % servers.len();
                if let Ok(server) = TcpStream::connect(&servers[next]).await {
                    return exchange(client, server, obstacles).await;
                }
            }
        }
    }
}

async fn exchange<C, S>(client: C, server: S, obstacles: Obstacles)
where
    C: AsyncRead + AsyncWrite,
    S: AsyncRead + AsyncWrite,
{
    let (from_client, to_client) = tokio::io::split(client);
    let (from_server, to_server) = tokio::io::split(server);
    let (muted, is_muted) = watch::channel(false);
    let note = |length| {
        if length >= MUCH && obstacles.mutes_next.swap(false, Ordering::AcqRel) {
            muted.send_replace(true);
        }
    };
    let hears = |_| {};
    let answers = async {
        let mut is_muted = is_muted.clone();
        tokio::select! {
            biased;
            () = async { let _ = is_muted.wait_for(|muted| *muted).await; } => std::future::pending().await,
            () = pass(from_server, to_client, obstacles.mode.clone(), hears) => {}
        }
    };
    // When one side closes, the other is closed, too.
    tokio::select! {
        () = pass(from_client, to_server, obstacles.mode.clone(), note) => {}
        () = answers => {}
    }
}

async fn pass(
    mut from: impl AsyncRead + Unpin,
    mut to: impl AsyncWrite + Unpin,
    mut mode: watch::Receiver<Mode>,
    note: impl Fn(usize),
) {
    let mut bytes = vec![0; 64 << 10];
    while let Ok(length @ 1..) = from.read(&mut bytes).await {
        note(length);
        if mode.wait_for(|mode| *mode == Mode::Open).await.is_err()
            || to.write_all(&bytes[..length]).await.is_err()
        {
            return;
        }
    }
}
