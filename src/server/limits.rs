//! How many connections there are: in all, and of each peer.
//!
//! Every connection takes a file descriptor. Where they end nobody gets in any more, not even whoever
//! asks whether the server is alive. So some are kept back: a connection beyond the limits gets one of
//! them, is answered only that, and makes room for the next one when they are all taken.

use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use crate::config::Config;
use crate::job::peer::Peer;

/// The most connections beyond the limits that are open at a time.
const BEYOND: usize = 32;

/// Descriptors that are taken by something else than connections: files, listeners, the runtime.
const OTHERS: usize = 32;

/// What a server takes for the number of descriptors where the system does not tell.
const USUAL_DESCRIPTORS: usize = 1024;

/// How many connections there may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Most {
    /// In all.
    pub(super) all: usize,
    /// Of one peer.
    pub(super) of_a_peer: usize,
}

impl Most {
    /// As set, or what the descriptors of the process allow.
    pub(super) fn of(config: &Config) -> Self {
        let descriptors = descriptors().unwrap_or(USUAL_DESCRIPTORS);
        let kept_back = (BEYOND + OTHERS).min(descriptors / 2);
        let all = descriptors - kept_back;
        let all = config.max_connections.map_or(all, |most| most.min(all));
        let of_a_peer = config.max_connections_per_peer;
        Self {
            all,
            of_a_peer: of_a_peer.unwrap_or(all.div_ceil(2)),
        }
    }
}

/// How many connections are taken in before those that are to make room for them have gone.
const ON_THEIR_WAY: usize = 8;

/// The connections of a server.
#[derive(Debug)]
pub(super) struct Connections {
    most: Most,
    /// For all that have a descriptor.
    room: Arc<Semaphore>,
    open: Mutex<Open>,
}

#[derive(Debug, Default)]
struct Open {
    all: usize,
    peers: HashMap<Peer, usize>,
    /// Those beyond the limits, the oldest first.
    beyond: VecDeque<oneshot::Sender<()>>,
}

/// How a connection is let in.
#[derive(Debug)]
pub(super) enum Admission {
    /// As one of those that the limits allow, until this is dropped.
    Within(Place),
    /// Beyond them, until this completes.
    Beyond(Crowded, oneshot::Receiver<()>),
}

/// Why a connection is beyond the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crowded {
    /// There are as many as there may be.
    All(usize),
    /// Its peer has as many as one may have.
    ByPeer(usize),
}

impl fmt::Display for Crowded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All(most) => write!(f, "{most} connections are open, the limit of this server"),
            Self::ByPeer(most) => write!(
                f,
                "{most} connections from one address are open, the limit of this server for each"
            ),
        }
    }
}

/// The place of a connection.
#[derive(Debug)]
#[must_use]
pub(super) struct Place {
    connections: Arc<Connections>,
    peer: Peer,
}

impl Connections {
    pub(super) fn new(most: Most) -> Arc<Self> {
        let room = (most.all + BEYOND + ON_THEIR_WAY).min(Semaphore::MAX_PERMITS);
        Arc::new(Self {
            most,
            room: Arc::new(Semaphore::new(room)),
            open: Mutex::default(),
        })
    }

    /// Waits until there is a descriptor for one more connection, which is soon.
    pub(super) async fn room(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.room).acquire_owned().await.ok()
    }

    /// Lets in a connection of a peer.
    pub(super) fn admit(self: &Arc<Self>, peer: Peer) -> Admission {
        let mut open = self.open.lock();
        let its = open.peers.get(&peer).copied().unwrap_or(0);
        let crowded = match self.most {
            Most { all, .. } if open.all >= all => Crowded::All(all),
            Most { of_a_peer, .. } if its >= of_a_peer => Crowded::ByPeer(of_a_peer),
            _ => {
                open.all += 1;
                open.peers.insert(peer, its + 1);
                let connections = Arc::clone(self);
                return Admission::Within(Place { connections, peer });
            }
        };
        open.beyond.retain(|connection| !connection.is_closed());
        if open.beyond.len() >= BEYOND {
            // Dropping it ends the connection.
            open.beyond.pop_front();
        }
        let (end, ended) = oneshot::channel();
        open.beyond.push_back(end);
        Admission::Beyond(crowded, ended)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut open = self.connections.open.lock();
        open.all -= 1;
        if let Some(its) = open.peers.get_mut(&self.peer) {
            *its -= 1;
            if *its == 0 {
                open.peers.remove(&self.peer);
            }
        }
    }
}

/// How many file descriptors the process may have: as many as it can get.
#[cfg(unix)]
fn descriptors() -> Option<usize> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limit.maximum,
        maximum: limit.maximum,
    };
    // Low limits are for programs that use `select`, which cannot have more.
    let current = match setrlimit(Resource::Nofile, raised) {
        Ok(()) => raised.current,
        Err(_) => limit.current,
    };
    current.and_then(|current| usize::try_from(current).ok())
}

#[cfg(not(unix))]
fn descriptors() -> Option<usize> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(last: u8) -> Peer {
        Peer::at([192, 0, 2, last].into())
    }

    #[test]
    fn a_peer_has_its_part_of_the_connections() {
        let connections = Connections::new(Most {
            all: 3,
            of_a_peer: 2,
        });
        let admit = |last| match connections.admit(peer(last)) {
            Admission::Within(place) => Ok(place),
            Admission::Beyond(crowded, _) => Err(crowded),
        };
        let first = admit(1).unwrap();
        let second = admit(1).unwrap();
        assert_eq!(admit(1).unwrap_err(), Crowded::ByPeer(2));
        let third = admit(2).unwrap();
        assert_eq!(admit(2).unwrap_err(), Crowded::All(3));
        drop(first);
        let again = admit(1).unwrap();
        drop((second, third, again));
        assert!(connections.open.lock().peers.is_empty());
        assert_eq!(connections.open.lock().all, 0);
    }

    #[test]
    fn beyond_the_limits_the_oldest_makes_room() {
        let connections = Connections::new(Most {
            all: 0,
            of_a_peer: 0,
        });
        let admit = || match connections.admit(peer(1)) {
            Admission::Within(_) => panic!("there are no places"),
            Admission::Beyond(_, ended) => ended,
        };
        let mut beyond: Vec<_> = (0..BEYOND).map(|_| admit()).collect();
        let is_open = |ended: &mut oneshot::Receiver<()>| {
            ended.try_recv() == Err(oneshot::error::TryRecvError::Empty)
        };
        assert!(beyond.iter_mut().all(is_open));
        beyond.push(admit());
        assert!(!is_open(&mut beyond[0]));
        assert!(beyond[1..].iter_mut().all(is_open));
        // One that has ended by itself leaves its room.
        beyond.pop();
        beyond.push(admit());
        assert!(beyond[1..].iter_mut().all(is_open));
    }
}
