//! Queues in which peers take turns, so that a peer with much waiting does not delay the others.

use std::collections::{HashMap, VecDeque};

use super::peer::Peer;

/// Waiting items, in the order of arrival, with a queue for each peer. Background work has one, too.
#[derive(Debug)]
pub(super) struct Turns<T> {
    queues: HashMap<Option<Peer>, PeerQueue<T>>,
    /// The peers with waiting items, in the order of their turns.
    order: VecDeque<Option<Peer>>,
}

/// The waiting items of one peer.
#[derive(Debug)]
pub(super) struct PeerQueue<T> {
    pub(super) waiting: VecDeque<T>,
    /// The number of turns of the peer since its queue was last empty.
    pub(super) turns: usize,
}

impl<T> Default for Turns<T> {
    fn default() -> Self {
        Self {
            queues: HashMap::new(),
            order: VecDeque::new(),
        }
    }
}

impl<T> Turns<T> {
    /// Adds an item behind all others of its peer.
    pub(super) fn push(&mut self, peer: Option<Peer>, item: T) {
        let queue = self.queues.entry(peer).or_insert_with(|| {
            self.order.push_back(peer);
            PeerQueue {
                waiting: VecDeque::new(),
                turns: 0,
            }
        });
        queue.waiting.push_back(item);
    }

    /// Gives the peers their turns, until one of them takes an item out of its queue.
    pub(super) fn next<R>(
        &mut self,
        mut take: impl FnMut(Option<Peer>, &mut PeerQueue<T>) -> Option<R>,
    ) -> Option<R> {
        for _ in 0..self.order.len() {
            let peer = self.order.pop_front()?;
            let queue = self.queues.get_mut(&peer)?;
            let taken = take(peer, queue);
            queue.turns += 1;
            if queue.waiting.is_empty() {
                self.queues.remove(&peer);
            } else {
                self.order.push_back(peer);
            }
            if taken.is_some() {
                return taken;
            }
        }
        None
    }

    /// The peers with their waiting items.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Option<Peer>, &VecDeque<T>)> {
        let queues = self.queues.iter();
        queues.map(|(&peer, queue)| (peer, &queue.waiting))
    }

    /// Drops all waiting items.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peers_take_turns() {
        let peer = |last| Some(Peer::at([192, 0, 2, last].into()));
        let mut turns = Turns::default();
        for item in 0..4 {
            turns.push(peer(1), item);
        }
        turns.push(peer(2), 10);
        turns.push(None, 20);
        let mut first = || turns.next(|_, queue| queue.waiting.pop_front());
        assert_eq!([first(), first()], [Some(0), Some(10)]);
        turns.push(peer(2), 11);
        let mut next = || turns.next(|_, queue| queue.waiting.pop_front());
        let rest: Vec<_> = std::iter::from_fn(&mut next).collect();
        assert_eq!(rest, [20, 1, 11, 2, 3]);
        assert!(turns.queues.is_empty() && turns.order.is_empty());

        // A peer that takes nothing keeps its items.
        turns.push(peer(1), 1);
        turns.push(peer(2), 2);
        let even = |_, queue: &mut PeerQueue<i32>| match queue.waiting.front() {
            Some(item) if item % 2 == 0 => queue.waiting.pop_front(),
            _ => None,
        };
        assert_eq!([turns.next(even), turns.next(even)], [Some(2), None]);
        assert_eq!(turns.iter().count(), 1);
    }
}
