//! Notifications between replicas by NOTIFY. They only save time: what is missed is found by polling.
//!
//! Transactions with a NOTIFY are committed one after the other, by a lock of the whole database, each with a write to
//! the disk. So hints are sent apart from the changes, many at once, and without waiting for the disk.

use std::sync::Weak;
use std::time::Duration;

use sqlx::postgres::{PgListener, PgPoolOptions};
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};
use tracing::debug;

use super::Shared;
use super::hints::Hint;

/// The most hints that have not been sent or read yet; further ones are dropped.
pub(super) const MAX_HINTS: usize = 4096;

/// After this long without a hint the connection is remade, as a dead one is silent.
const SILENCE: Duration = Duration::from_secs(60);

/// The pause before a lost connection is remade.
const PAUSE: Duration = Duration::from_secs(1);

const NOTIFY: &str = "
SELECT set_config('synchronous_commit', 'off', true), pg_notify('piad', hint) FROM unnest($1::text[]) AS hint";

/// Sends hints until their senders are gone.
pub(super) async fn send_hints(store: Weak<Shared>, mut hints: mpsc::Receiver<Hint>) {
    let mut some = Vec::new();
    while hints.recv_many(&mut some, MAX_HINTS).await > 0 {
        let Some(store) = store.upgrade() else { return };
        let payloads: Vec<String> = some.drain(..).map(|hint| hint.to_string()).collect();
        let notify = || sqlx::query(NOTIFY).bind(&payloads);
        if let Err(error) = store.connections.run(0, notify).await {
            debug!(%error, "hints for other replicas are lost");
        }
    }
}

impl Shared {
    /// Notifies the other replicas, and this one, in a moment.
    pub(super) fn tell(&self, hint: Hint) {
        let _ = self.hint_sender.try_send(hint);
    }

    /// The hints from now on, until the receiver is dropped.
    pub(crate) fn hints(&self) -> mpsc::Receiver<Hint> {
        let (sender, hints) = mpsc::channel(MAX_HINTS);
        let pool = PgPoolOptions::new().max_connections(1).min_connections(0);
        let options = self.options.clone();
        tokio::spawn(async move {
            while !sender.is_closed() {
                // A pool for each connection: one that hangs is left behind.
                let pool = pool.clone().connect_lazy_with(options.clone());
                let lost = async {
                    let mut listener = PgListener::connect_with(&pool).await?;
                    listener.listen("piad").await?;
                    while let Ok(notification) = timeout(SILENCE, listener.recv()).await {
                        if let Some(hint) = Hint::of(notification?.payload()) {
                            let _ = sender.try_send(hint);
                        }
                    }
                    Ok::<(), sqlx::Error>(())
                };
                tokio::select! {
                    () = sender.closed() => {}
                    lost = lost => if let Err(error) = lost {
                        debug!(%error, "hints of other replicas are missed");
                        sleep(PAUSE).await;
                    }
                }
            }
        });
        hints
    }
}
