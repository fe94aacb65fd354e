//! Signals of the operating system, and the end of the standard input.

use std::io;
use std::thread;

#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::oneshot;
use tracing::warn;

/// Completes at SIGINT or, on Unix, SIGTERM. They are noticed from this call on.
pub fn interrupted() -> impl Future<Output = ()> + Send + 'static {
    #[cfg(unix)]
    {
        let mut interrupt = Noticed::new("SIGINT", SignalKind::interrupt());
        let mut terminate = Noticed::new("SIGTERM", SignalKind::terminate());
        async move {
            tokio::select! {
                () = interrupt.next() => {}
                () = terminate.next() => {}
            }
        }
    }
    #[cfg(not(unix))]
    async {
        if let Err(reason) = tokio::signal::ctrl_c().await {
            warn!("cannot handle interrupts: {reason}");
            std::future::pending::<()>().await;
        }
    }
}

/// Completes when the standard input has ended or cannot be read. Bytes before its end are ignored.
pub fn stdin_ended() -> impl Future<Output = ()> + Send + 'static {
    let (sender, ended) = oneshot::channel();
    // A read of a pipe cannot be cancelled: the runtime, which waits for its own threads, does not wait for this one.
    let reader = thread::Builder::new().name("stdin".to_owned());
    let started = reader.spawn(move || {
        let copied = io::copy(&mut io::stdin(), &mut io::sink());
        let _ = sender.send(copied);
    });
    async move {
        // Without the thread, which has the sender, this completes at once.
        match (started, ended.await) {
            (Err(reason), _) | (_, Ok(Err(reason))) => {
                warn!("cannot read the standard input: {reason}");
            }
            _ => {}
        }
    }
}

/// Receives SIGHUP. On systems other than Unix it never comes.
pub(crate) fn hangups() -> Noticed {
    #[cfg(unix)]
    return Noticed::new("SIGHUP", SignalKind::hangup());
    #[cfg(not(unix))]
    Noticed {}
}

/// A signal that is noticed.
pub(crate) struct Noticed {
    #[cfg(unix)]
    signal: Option<Signal>,
}

impl Noticed {
    #[cfg(unix)]
    fn new(name: &str, kind: SignalKind) -> Self {
        let signal = signal(kind);
        if let Err(reason) = &signal {
            warn!("cannot handle {name}: {reason}");
        }
        Self {
            signal: signal.ok(),
        }
    }

    /// Completes at the next one.
    pub(crate) async fn next(&mut self) {
        #[cfg(unix)]
        if let Some(signal) = &mut self.signal
            && signal.recv().await.is_some()
        {
            return;
        }
        std::future::pending().await
    }
}
