//! Drags: each ephemeral edit of a session takes the place of the one before.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::oneshot;
use uuid::Uuid;

use crate::job::peer::Peer;

/// The drags that go on, each with its newest edit.
#[derive(Debug, Default)]
pub struct Sessions {
    newest: Mutex<HashMap<Session, Newest>>,
}

/// A drag: of this job, by this client, under the name that the client has chosen.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Session {
    parent: Uuid,
    peer: Option<Peer>,
    name: String,
}

/// The newest edit of a session. When it is dropped, whoever computes the edit knows that there is a
/// newer one.
#[derive(Debug)]
struct Newest {
    number: Uuid,
    _sender: oneshot::Sender<()>,
}

/// The place of an edit in its session.
#[derive(Debug)]
pub struct SessionTurn {
    sessions: Arc<Sessions>,
    session: Session,
    number: Uuid,
    replaced: oneshot::Receiver<()>,
}

impl Sessions {
    /// A new edit of a session, which replaces the one before.
    pub fn next(self: &Arc<Self>, parent: Uuid, peer: Option<Peer>, name: String) -> SessionTurn {
        let (sender, replaced) = oneshot::channel();
        let session = Session { parent, peer, name };
        let number = Uuid::new_v4();
        let newest = Newest {
            number,
            _sender: sender,
        };
        self.newest.lock().insert(session.clone(), newest);
        SessionTurn {
            sessions: Arc::clone(self),
            session,
            number,
            replaced,
        }
    }
}

impl SessionTurn {
    /// Completes when a newer edit has replaced this one.
    pub async fn replaced(&mut self) {
        // Nothing is ever sent: the sender is dropped.
        let _ = (&mut self.replaced).await;
    }
}

impl Drop for SessionTurn {
    fn drop(&mut self) {
        let mut newest = self.sessions.newest.lock();
        let is_newest = |it: &Newest| it.number == self.number;
        if newest.get(&self.session).is_some_and(is_newest) {
            newest.remove(&self.session);
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    #[test]
    fn an_edit_replaces_the_one_before_of_its_session() {
        let sessions = Arc::new(Sessions::default());
        let (parent, peer) = (Uuid::new_v4(), Peer::at([192, 0, 2, 1].into()));
        let next = |peer, name: &str| sessions.next(parent, Some(peer), name.to_owned());
        let is_replaced = |turn: &mut SessionTurn| turn.replaced().now_or_never().is_some();
        let mut first = next(peer, "a");
        let mut other = next(peer, "b");
        let mut elsewhere = next(Peer::at([192, 0, 2, 2].into()), "a");
        assert!(!is_replaced(&mut first));
        let mut second = next(peer, "a");
        assert!(is_replaced(&mut first));
        // The end of the first one is not that of the second.
        drop(first);
        for turn in [&mut second, &mut other, &mut elsewhere] {
            assert!(!is_replaced(turn));
        }
        drop((second, other, elsewhere));
        assert!(sessions.newest.lock().is_empty());
    }
}
