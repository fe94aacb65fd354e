//! Drags: each ephemeral edit of a session replaces the one before.

use std::collections::HashMap;

use parking_lot::Mutex;
use tokio::sync::oneshot;
use uuid::Uuid;

use crate::job::peer::Peer;

/// The open drags, each with its newest edit: a sender of nothing, which is dropped when a newer edit replaces it.
#[derive(Debug, Default)]
pub(crate) struct Sessions(Mutex<HashMap<Session, oneshot::Sender<()>>>);

/// A drag: of this job, by this client, under the name that the client has chosen.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Session {
    parent: Uuid,
    peer: Option<Peer>,
    name: String,
}

/// The place of an edit in its session, until it is dropped.
#[derive(Debug)]
pub(crate) struct SessionTurn(oneshot::Receiver<()>);

impl Sessions {
    /// A new edit of a session, which replaces the one before.
    pub(crate) fn next(&self, parent: Uuid, peer: Option<Peer>, name: String) -> SessionTurn {
        let (newest, replaced) = oneshot::channel();
        let mut sessions = self.0.lock();
        sessions.retain(|_, newest| !newest.is_closed());
        sessions.insert(Session { parent, peer, name }, newest);
        SessionTurn(replaced)
    }
}

impl SessionTurn {
    /// Completes when a newer edit has replaced this one.
    pub(crate) async fn replaced(&mut self) {
        // Nothing is ever sent: the sender is dropped. After that there is nothing to wait for.
        if !self.0.is_terminated() {
            let _ = (&mut self.0).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    #[test]
    fn an_edit_replaces_the_one_before_of_its_session() {
        let sessions = Sessions::default();
        let (parent, peer) = (Uuid::new_v4(), Peer::at([192, 0, 2, 1].into()));
        let next = |peer, name: &str| sessions.next(parent, Some(peer), name.to_owned());
        let is_replaced = |turn: &mut SessionTurn| turn.replaced().now_or_never().is_some();
        let mut first = next(peer, "a");
        let mut other = next(peer, "b");
        let mut elsewhere = next(Peer::at([192, 0, 2, 2].into()), "a");
        assert!(!is_replaced(&mut first));
        let mut second = next(peer, "a");
        assert!(is_replaced(&mut first) && is_replaced(&mut first));
        // The end of the first one is not that of the second.
        drop(first);
        for turn in [&mut second, &mut other, &mut elsewhere] {
            assert!(!is_replaced(turn));
        }
        drop((second, other, elsewhere));
        let _only = next(peer, "c");
        assert_eq!(sessions.0.lock().len(), 1);
    }
}
