//! Limits of the number of connections, in all and of each peer, and of the requests of a peer where
//! connections do not limit them: over HTTP/2, and through a trusted proxy.
//!
//! Every connection takes a file descriptor. Without free ones, not even health checks would be
//! answered. So some descriptors are reserved for connections beyond the limits, on which only health
//! and metrics are answered; when these are taken, too, the oldest is closed for the next.

use std::collections::VecDeque;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

use crate::api::http::overload::LimitExceeded;
use crate::config::Config;
use crate::job::peer::Peer;
use crate::job::slots::{NoSlot, PerPeer, Slot, Slots};

/// The most connections beyond the limits that are open at a time.
const BEYOND: usize = 32;

/// File descriptors for everything but connections: files, listeners, the runtime.
const OTHERS: usize = 32;

/// The assumed number of file descriptors if the system does not report it.
const USUAL_DESCRIPTORS: usize = 1024;

/// The most connections.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConnectionLimits {
    /// In all.
    pub(super) all: usize,
    /// Of one peer.
    pub(super) per_peer: usize,
    /// Requests of one peer.
    pub(super) requests: usize,
}

impl ConnectionLimits {
    /// As set, or what the descriptors of the process allow.
    pub(super) fn of(config: &Config) -> Self {
        let descriptors = descriptors().unwrap_or(USUAL_DESCRIPTORS);
        let kept_back = (BEYOND + OTHERS).min(descriptors / 2);
        let all = descriptors - kept_back;
        let all = config.max_connections.map_or(all, |most| most.min(all));
        let per_peer = config.max_connections_per_peer;
        Self {
            all,
            per_peer: per_peer.unwrap_or(all.div_ceil(2)),
            requests: config.max_requests_per_peer,
        }
    }
}

/// The number of connections that are accepted before those that make room for them have been
/// closed.
const ON_THEIR_WAY: usize = 8;

/// The connections of a server.
#[derive(Debug)]
pub(super) struct Connections {
    /// For those within the limits.
    slots: Arc<Slots>,
    requests: Arc<Slots>,
    /// For all that have a descriptor.
    room: Arc<Semaphore>,
    /// Those beyond the limits, the oldest first; dropping one of these ends its connection.
    beyond: Mutex<VecDeque<oneshot::Sender<()>>>,
}

/// The admission of a connection.
#[derive(Debug)]
pub(super) enum Admission {
    /// Within the limits, until the slot is dropped.
    Within(Slot),
    /// Beyond the limits, until the receiver completes.
    Beyond(LimitExceeded, oneshot::Receiver<()>),
}

impl Connections {
    pub(super) fn new(limits: ConnectionLimits) -> Self {
        let room = (limits.all + BEYOND + ON_THEIR_WAY).min(Semaphore::MAX_PERMITS);
        Self {
            slots: Slots::new(limits.all, PerPeer::Fixed(limits.per_peer)),
            requests: Slots::new(usize::MAX, PerPeer::Fixed(limits.requests)),
            room: Arc::new(Semaphore::new(room)),
            beyond: Mutex::default(),
        }
    }

    /// Waits until there is a descriptor for one more connection, which does not take long.
    pub(super) async fn room(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.room).acquire_owned().await.ok()
    }

    /// Admits a connection of a peer, or of a proxy with many peers behind it.
    pub(super) fn admit(&self, peer: Option<Peer>) -> Admission {
        let exceeded = match self.slots.take(peer) {
            Ok(slot) => return Admission::Within(slot),
            Err(no_slot) => LimitExceeded::Connections(no_slot),
        };
        let mut beyond = self.beyond.lock();
        beyond.retain(|connection| !connection.is_closed());
        if beyond.len() >= BEYOND {
            beyond.pop_front();
        }
        let (end, ended) = oneshot::channel();
        beyond.push_back(end);
        Admission::Beyond(exceeded, ended)
    }

    /// Admits a request of a peer.
    pub(super) fn admit_request(&self, peer: Peer) -> Result<Slot, LimitExceeded> {
        self.requests
            .take(Some(peer))
            .map_err(|no_slot| match no_slot {
                NoSlot::All(most) | NoSlot::PerPeer(most) => LimitExceeded::Requests(most),
            })
    }
}

/// The number of file descriptors of the process, after its soft limit was raised to the hard
/// limit.
#[cfg(unix)]
fn descriptors() -> Option<usize> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limit.maximum,
        maximum: limit.maximum,
    };
    // Soft limits are low for the sake of programs that use `select`, which cannot handle more.
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
        let connections = Connections::new(ConnectionLimits {
            all: 3,
            per_peer: 2,
            requests: 1,
        });
        let admit = |last| match connections.admit(Some(peer(last))) {
            Admission::Within(place) => Ok(place),
            Admission::Beyond(exceeded, _) => Err(exceeded),
        };
        let first = admit(1).unwrap();
        let second = admit(1).unwrap();
        assert_eq!(
            admit(1).unwrap_err(),
            LimitExceeded::Connections(NoSlot::PerPeer(2))
        );
        let third = admit(2).unwrap();
        assert_eq!(
            admit(2).unwrap_err(),
            LimitExceeded::Connections(NoSlot::All(3))
        );
        drop(first);
        let again = admit(1).unwrap();
        drop((second, third, again));
        assert_eq!(connections.slots.taken(), 0);
    }

    #[test]
    fn beyond_the_limits_the_oldest_makes_room() {
        let connections = Connections::new(ConnectionLimits {
            all: 0,
            per_peer: 0,
            requests: 0,
        });
        let admit = || match connections.admit(Some(peer(1))) {
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
