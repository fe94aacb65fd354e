//! Signals of the operating system.

#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};
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
