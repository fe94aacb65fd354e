//! Places for jobs that have not ended: so many in all, and so many for each peer.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;

use super::peer::Peer;

/// The places of a server.
#[derive(Debug)]
pub(super) struct Places {
    /// The most places that are taken.
    all: usize,
    /// The most that one peer takes.
    of_a_peer: usize,
    taken: Mutex<Taken>,
}

#[derive(Debug, Default)]
struct Taken {
    all: usize,
    peers: HashMap<Peer, usize>,
}

/// A place, until it is dropped.
#[derive(Debug)]
#[must_use]
pub(super) struct Place {
    places: Arc<Places>,
    peer: Option<Peer>,
}

/// Why there is no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Occupied {
    /// All of them are taken.
    All(usize),
    /// The peer has as many as it may have.
    ByPeer(usize),
}

impl Places {
    /// So many places, of which one peer may have so many.
    pub(super) fn new(all: usize, of_a_peer: usize) -> Arc<Self> {
        Arc::new(Self {
            all,
            of_a_peer,
            taken: Mutex::default(),
        })
    }

    /// A place beyond all limits, for nobody in particular.
    pub(super) fn occupy(self: &Arc<Self>) -> Place {
        self.taken.lock().all += 1;
        self.place(None)
    }

    /// A place for a peer, if there is one.
    pub(super) fn take(self: &Arc<Self>, peer: Option<Peer>) -> Result<Place, Occupied> {
        let mut taken = self.taken.lock();
        if taken.all >= self.all {
            return Err(Occupied::All(self.all));
        }
        if let Some(peer) = peer {
            let its = taken.peers.get(&peer).copied().unwrap_or(0);
            if its >= self.of_a_peer {
                return Err(Occupied::ByPeer(self.of_a_peer));
            }
            taken.peers.insert(peer, its + 1);
        }
        taken.all += 1;
        Ok(self.place(peer))
    }

    /// How many are taken.
    pub fn taken(&self) -> usize {
        self.taken.lock().all
    }

    fn place(self: &Arc<Self>, peer: Option<Peer>) -> Place {
        let places = Arc::clone(self);
        Place { places, peer }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = self.places.taken.lock();
        taken.all -= 1;
        let Some(peer) = self.peer else { return };
        if let Some(its) = taken.peers.get_mut(&peer) {
            *its -= 1;
            if *its == 0 {
                taken.peers.remove(&peer);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peer_takes_its_own_places_only() {
        let places = Places::new(3, 2);
        let peer = |last| Some(Peer::at([192, 0, 2, last].into()));
        let first = places.take(peer(1)).unwrap();
        let second = places.take(peer(1)).unwrap();
        assert_eq!(places.take(peer(1)).unwrap_err(), Occupied::ByPeer(2));
        let third = places.take(peer(2)).unwrap();
        assert_eq!(places.take(peer(2)).unwrap_err(), Occupied::All(3));
        let recovered = places.occupy();
        assert_eq!(places.taken(), 4);
        drop((first, recovered));
        let again = places.take(peer(1)).unwrap();
        drop((second, third, again));
        assert_eq!(places.taken(), 0);
        assert!(places.taken.lock().peers.is_empty());
    }
}
