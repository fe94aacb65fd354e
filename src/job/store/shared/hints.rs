//! What replicas tell each other by NOTIFY. It only spares time: whatever is missed is found by polling.

use std::time::Duration;

use sqlx::postgres::{PgListener, PgPoolOptions};
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};
use tracing::debug;
use uuid::Uuid;

use super::Shared;

/// Hints that nobody has read yet; further ones are dropped.
const MOST: usize = 4096;

/// After so long without a hint the connection is made anew: one that was cut off says nothing.
const SILENCE: Duration = Duration::from_secs(60);

/// The pause before a connection that was lost is made anew.
const PAUSE: Duration = Duration::from_secs(1);

/// What has happened at another replica, or at this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hint {
    /// A job waits that has no replica.
    Queued,
    /// A job that has waited runs now.
    Started(Uuid),
    /// A job has ended.
    Ended(Uuid),
    /// A job was deleted.
    Deleted(Uuid),
    /// A job is to be cancelled by the replica that runs it.
    Cancel(Uuid),
}

impl Hint {
    /// The hint of a payload.
    fn of(payload: &str) -> Option<Self> {
        if payload == "queued" {
            return Some(Self::Queued);
        }
        let (what, id) = payload.split_once(' ')?;
        let id = Uuid::try_parse(id).ok()?;
        match what {
            "started" => Some(Self::Started(id)),
            "ended" => Some(Self::Ended(id)),
            "deleted" => Some(Self::Deleted(id)),
            "cancel" => Some(Self::Cancel(id)),
            _ => None,
        }
    }
}

impl Shared {
    /// The hints from now on, until nobody reads them any more.
    pub(crate) fn hints(&self) -> mpsc::Receiver<Hint> {
        let (sender, hints) = mpsc::channel(MOST);
        let pool = PgPoolOptions::new().max_connections(1).min_connections(0);
        let options = self.options.clone();
        tokio::spawn(async move {
            while !sender.is_closed() {
                // A pool for each connection: one that hangs is left behind.
                let pool = pool.clone().connect_lazy_with(options.clone());
                let lost = async {
                    let mut listener = PgListener::connect_with(&pool).await?;
                    listener.listen("piad").await?;
                    while let Ok(told) = timeout(SILENCE, listener.recv()).await {
                        if let Some(hint) = Hint::of(told?.payload()) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_are_read() {
        let id = Uuid::now_v7();
        assert_eq!(Hint::of("queued"), Some(Hint::Queued));
        assert_eq!(Hint::of(&format!("started {id}")), Some(Hint::Started(id)));
        assert_eq!(Hint::of(&format!("ended {id}")), Some(Hint::Ended(id)));
        assert_eq!(Hint::of(&format!("deleted {id}")), Some(Hint::Deleted(id)));
        assert_eq!(Hint::of(&format!("cancel {id}")), Some(Hint::Cancel(id)));
        for other in ["", "ended", "ended x", &format!("begun {id}")] {
            assert_eq!(Hint::of(other), None);
        }
    }
}
