//! Slots limit the number of unfinished jobs, and that of connections, in all and for each peer.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;

use super::peer::Peer;

/// A number of slots, with a limit for each peer.
#[derive(Debug)]
pub(crate) struct Slots {
    all: usize,
    per_peer: PerPeer,
    taken: Mutex<Taken>,
}

/// The number of slots of one peer.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PerPeer {
    /// This number.
    Fixed(usize),
    /// Half of those that the others leave, so that there is one for later peers.
    Fair,
}

#[derive(Debug, Default)]
struct Taken {
    all: usize,
    peers: HashMap<Peer, usize>,
}

/// A slot that is taken until this is dropped.
#[derive(Debug)]
#[must_use]
pub(crate) struct Slot {
    slots: Arc<Slots>,
    peer: Option<Peer>,
}

/// Why there is no slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoSlot {
    /// All slots are taken; this is their number.
    All(usize),
    /// The peer has reached its limit, which is this number.
    PerPeer(usize),
}

impl Slots {
    /// Nothing is taken yet.
    pub(crate) fn new(all: usize, per_peer: PerPeer) -> Arc<Self> {
        Arc::new(Self {
            all,
            per_peer,
            taken: Mutex::default(),
        })
    }

    /// A slot beyond all limits, which counts for no peer.
    pub(super) fn occupy(self: &Arc<Self>) -> Slot {
        self.taken.lock().all += 1;
        self.slot(None)
    }

    /// A slot for a peer, if there is one left.
    pub(crate) fn take(self: &Arc<Self>, peer: Option<Peer>) -> Result<Slot, NoSlot> {
        let mut taken = self.taken.lock();
        if taken.all >= self.all {
            return Err(NoSlot::All(self.all));
        }
        if let Some(peer) = peer {
            let its = taken.peers.get(&peer).copied().unwrap_or(0);
            let most = match self.per_peer {
                PerPeer::Fixed(most) => most,
                PerPeer::Fair => (self.all + its - taken.all).div_ceil(2),
            };
            if its >= most {
                return Err(NoSlot::PerPeer(most));
            }
            taken.peers.insert(peer, its + 1);
        }
        taken.all += 1;
        Ok(self.slot(peer))
    }

    /// The number of slots taken.
    pub(crate) fn taken(&self) -> usize {
        self.taken.lock().all
    }

    fn slot(self: &Arc<Self>, peer: Option<Peer>) -> Slot {
        let slots = Arc::clone(self);
        Slot { slots, peer }
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut taken = self.slots.taken.lock();
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
    fn a_peer_takes_its_own_slots_only() {
        let slots = Slots::new(3, PerPeer::Fixed(2));
        let peer = |last| Some(Peer::at([192, 0, 2, last].into()));
        let first = slots.take(peer(1)).unwrap();
        let second = slots.take(peer(1)).unwrap();
        assert_eq!(slots.take(peer(1)).unwrap_err(), NoSlot::PerPeer(2));
        let third = slots.take(peer(2)).unwrap();
        assert_eq!(slots.take(peer(2)).unwrap_err(), NoSlot::All(3));
        let recovered = slots.occupy();
        assert_eq!(slots.taken(), 4);
        drop((first, recovered));
        let again = slots.take(peer(1)).unwrap();
        drop((second, third, again));
        assert_eq!(slots.taken(), 0);
        assert!(slots.taken.lock().peers.is_empty());
    }

    #[test]
    fn a_peer_takes_half_of_what_the_others_leave() {
        let slots = Slots::new(16, PerPeer::Fair);
        let take = |last| slots.take(Some(Peer::at([192, 0, 2, last].into())));
        let many = |last| -> Vec<Slot> { std::iter::from_fn(|| take(last).ok()).collect() };
        let taken: Vec<_> = (1..=5).map(many).collect();
        let counts: Vec<_> = taken.iter().map(Vec::len).collect();
        assert_eq!(counts, [8, 4, 2, 1, 1]);
        assert_eq!(take(6).unwrap_err(), NoSlot::All(16));
    }
}
