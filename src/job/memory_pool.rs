//! A part of the memory, divided among waiting tasks.
//!
//! A task that needs memory waits in the queue of its peer, and the peers take turns. A peer gets at most half of what
//! the others leave, or a single piece of any size. So there is room for later peers, whatever the first one requests.
//!
//! A piece that takes more than is free lets smaller ones of other peers pass. When it has waited for long, only peers
//! that have next to nothing pass, so that it gets its room; if it takes nearly all of the share, none passes.
//!
//! A growing piece holds memory while it waits for more. To prevent deadlocks between such pieces, the first of them is
//! favoured: it gets all that it requests from then on at once; the next one when the first has given everything back.
//! So a share can be exceeded by one growing piece.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use tokio::sync::oneshot;

use super::fair_queue::Turns;
use super::peer::Peer;

/// The unit in which memory is handed out.
const PAGE: usize = 4096;

/// How long a piece waits before room is made for it.
const ROOM_WAIT: Duration = Duration::from_secs(10);

/// A peer with at most this part of the share has next to nothing.
const LITTLE: u32 = 32;

/// A part of the memory.
#[derive(Debug)]
pub(crate) struct Share {
    pages: u32,
    state: Arc<Mutex<ShareState>>,
}

#[derive(Debug)]
struct ShareState {
    usage: Usage,
    waiting: Turns<Waiter>,
    /// A piece that grows is favoured.
    has_favourite: bool,
}

/// The usage of the share.
#[derive(Debug)]
struct Usage {
    /// All pages of the share.
    pages: u32,
    used: u32,
    /// Peers that have nothing have no entry.
    peers: HashMap<Option<Peer>, u32>,
}

#[derive(Debug)]
struct Waiter {
    piece: Piece,
    since: Instant,
    granted: oneshot::Sender<Permit>,
}

/// A request for memory.
#[derive(Clone, Copy, Debug)]
struct Piece {
    peer: Option<Peer>,
    pages: u32,
    /// Pages that are held already, which belong to the same piece.
    held: u32,
    /// It gets all that it requests, whatever others have.
    favoured: bool,
}

/// A piece that has waited for long.
#[derive(Clone, Copy, Debug)]
struct Overdue {
    peer: Option<Peer>,
    /// The most pages that another peer may have meanwhile.
    others: u32,
}

/// Memory that was taken; given back when it is dropped.
#[derive(Debug)]
pub(crate) struct Permit {
    share: Arc<Mutex<ShareState>>,
    peer: Option<Peer>,
    pages: u32,
    /// Another piece that grows is favoured when this one is given back.
    favoured: bool,
}

impl Share {
    /// All of it is free.
    pub(super) fn new(bytes: usize) -> Self {
        let pages = u32::try_from(bytes / PAGE).unwrap_or(u32::MAX).max(1);
        let state = ShareState {
            usage: Usage {
                pages,
                used: 0,
                peers: HashMap::new(),
            },
            waiting: Turns::default(),
            has_favourite: false,
        };
        Self {
            pages,
            state: Arc::new(Mutex::new(state)),
        }
    }

    /// All of it, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.pages as usize * PAGE
    }

    /// The bytes that are taken.
    pub(super) fn used(&self) -> usize {
        self.state.lock().usage.used as usize * PAGE
    }

    /// A request for more than the whole share is for all of it, and so runs alone.
    fn piece(&self, peer: Option<Peer>, bytes: usize) -> Piece {
        let pages = u32::try_from(bytes.div_ceil(PAGE)).unwrap_or(u32::MAX);
        Piece {
            peer,
            pages: pages.min(self.pages),
            held: 0,
            favoured: false,
        }
    }

    /// Takes this many bytes for a peer if it can have them now.
    pub(crate) fn take_at_once(&self, peer: Option<Peer>, bytes: usize) -> Option<Permit> {
        self.try_take(self.piece(peer, bytes))
    }

    /// Waits until a peer gets this many bytes.
    pub(crate) async fn take(&self, peer: Option<Peer>, bytes: usize) -> Option<Permit> {
        self.wait(self.piece(peer, bytes)).await
    }

    /// Waits until a permit has this many more bytes, or all of the share.
    pub(crate) async fn extend(&self, permit: &mut Permit, bytes: usize) {
        let more = self.piece(permit.peer, bytes);
        let piece = Piece {
            pages: more.pages.min(self.pages - permit.pages),
            held: permit.pages,
            favoured: permit.favoured,
            ..more
        };
        if let Some(mut more) = self.wait(piece).await {
            permit.pages += std::mem::take(&mut more.pages);
            permit.favoured |= std::mem::take(&mut more.favoured);
        }
    }

    fn try_take(&self, piece: Piece) -> Option<Permit> {
        let mut state = self.state.lock();
        let queued = state.waiting.iter().any(|(peer, _)| peer == piece.peer);
        let overdue = state.overdue(Instant::now());
        let admitted = piece.favoured || (!queued && state.usage.admits(piece, overdue));
        admitted.then(|| {
            state.usage.add(piece);
            permit(&self.state, piece)
        })
    }

    async fn wait(&self, piece: Piece) -> Option<Permit> {
        if let Some(permit) = self.try_take(piece) {
            return Some(permit);
        }
        let (granted, permit) = oneshot::channel();
        let waiter = Waiter {
            piece,
            since: Instant::now(),
            granted,
        };
        self.state.lock().waiting.push(piece.peer, waiter);
        // Something may have been given back since the attempt.
        grant(&self.state);
        permit.await.ok()
    }
}

fn permit(share: &Arc<Mutex<ShareState>>, piece: Piece) -> Permit {
    Permit {
        share: Arc::clone(share),
        peer: piece.peer,
        pages: piece.pages,
        favoured: piece.favoured,
    }
}

/// Gives waiting tasks what they can have now.
fn grant(share: &Arc<Mutex<ShareState>>) {
    loop {
        let next = share.lock().next();
        let Some(Waiter { piece, granted, .. }) = next else {
            return;
        };
        // A task that does not wait any more gives it back.
        let _ = granted.send(permit(share, piece));
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        let mut share = self.share.lock();
        share.usage.remove(self.peer, self.pages);
        share.has_favourite &= !self.favoured;
        drop(share);
        grant(&self.share);
    }
}

impl ShareState {
    /// The next waiting piece that can be given, which is counted as given.
    fn next(&mut self) -> Option<Waiter> {
        let next = self.next_with_room().or_else(|| self.next_favourite())?;
        self.usage.add(next.piece);
        Some(next)
    }

    /// The first piece that grows of several that wait, if no other one is favoured.
    fn next_favourite(&mut self) -> Option<Waiter> {
        if self.has_favourite {
            return None;
        }
        let grows = |waiter: &&Waiter| waiter.piece.held > 0 && !waiter.granted.is_closed();
        let waiting = || self.waiting.iter().flat_map(|(_, queue)| queue);
        let growing = || waiting().filter(grows);
        let first = growing().map(|it| it.since).min()?;
        // A single one waits for pieces that do not wait themselves.
        growing().nth(1)?;
        let mut next = self.waiting.next(|_, queue| {
            let waiting = &mut queue.waiting;
            let place = waiting
                .iter()
                .position(|it| grows(&it) && it.since == first)?;
            waiting.remove(place)
        })?;
        next.piece.favoured = true;
        self.has_favourite = true;
        Some(next)
    }

    fn next_with_room(&mut self) -> Option<Waiter> {
        let overdue = self.overdue(Instant::now());
        let usage = &self.usage;
        self.waiting.next(|_, queue| {
            while queue
                .waiting
                .front()
                .is_some_and(|it| it.granted.is_closed())
            {
                queue.waiting.pop_front();
            }
            let first = queue.waiting.front()?;
            match usage.admits(first.piece, overdue) {
                true => queue.waiting.pop_front(),
                false => None,
            }
        })
    }

    /// The piece that has waited for the longest, too long, and only for room.
    fn overdue(&self, now: Instant) -> Option<Overdue> {
        let first = self.waiting.iter().filter_map(|(_, queue)| {
            let first = queue.iter().find(|it| !it.granted.is_closed())?;
            let waited = now.saturating_duration_since(first.since);
            (waited > ROOM_WAIT && self.usage.is_due(first.piece)).then_some(first)
        });
        let Waiter { piece, .. } = first.min_by_key(|it| it.since)?;
        let pages = self.usage.pages;
        let little = pages / LITTLE;
        let leaves_little = piece.held + piece.pages <= pages - little;
        Some(Overdue {
            peer: piece.peer,
            others: if leaves_little { little } else { 0 },
        })
    }
}

impl Usage {
    fn of(&self, peer: Option<Peer>) -> u32 {
        self.peers.get(&peer).copied().unwrap_or(0)
    }

    /// Returns true if a peer does not have more than its part with this piece.
    fn is_due(&self, piece: Piece) -> bool {
        let has = self.of(piece.peer);
        let left_by_others = self.pages.saturating_sub(self.used - has);
        let with_it = u64::from(has) + u64::from(piece.pages);
        has == piece.held || 2 * with_it <= u64::from(left_by_others)
    }

    /// Returns true if a peer can have this piece now.
    fn admits(&self, piece: Piece, overdue: Option<Overdue>) -> bool {
        let passes = overdue.is_none_or(|overdue| {
            overdue.peer == piece.peer || self.of(piece.peer) + piece.pages <= overdue.others
        });
        piece.pages <= self.pages.saturating_sub(self.used) && passes && self.is_due(piece)
    }

    fn add(&mut self, piece: Piece) {
        self.used += piece.pages;
        *self.peers.entry(piece.peer).or_insert(0) += piece.pages;
    }

    fn remove(&mut self, peer: Option<Peer>, pages: u32) {
        self.used -= pages;
        if let Some(has) = self.peers.get_mut(&peer) {
            *has -= pages;
            if *has == 0 {
                self.peers.remove(&peer);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    fn peer(last: u8) -> Option<Peer> {
        Some(Peer::at([192, 0, 2, last].into()))
    }

    /// A share of 64 pages, and its usage in pages.
    fn share() -> Share {
        Share::new(64 * PAGE)
    }

    fn take(share: &Share, last: u8, pages: usize) -> Option<Permit> {
        share.take_at_once(peer(last), pages * PAGE)
    }

    #[tokio::test]
    async fn memory_is_returned() {
        let share = share();
        let most = take(&share, 1, 60).unwrap();
        assert!(take(&share, 1, 1).is_none() && take(&share, 2, 5).is_none());
        assert_eq!(share.used(), 60 * PAGE);
        drop(most);
        // A request for more than the total waits for the total.
        let all = share.take(peer(1), usize::MAX).await.unwrap();
        assert!(take(&share, 2, 1).is_none());
        drop(all);
        assert_eq!(share.used(), 0);
        assert!(share.state.lock().usage.peers.is_empty());
    }

    #[test]
    fn a_peer_gets_half_of_what_the_others_leave() {
        let share = share();
        let many = |last| -> Vec<Permit> { std::iter::from_fn(|| take(&share, last, 1)).collect() };
        let taken = [many(1), many(2), many(3)];
        assert_eq!(taken.each_ref().map(Vec::len), [32, 16, 8]);
        let [first, ..] = taken;
        drop(first);
        assert_eq!(many(1).len(), 20);
    }

    #[tokio::test]
    async fn a_permit_grows_into_a_piece_of_any_size() {
        let share = share();
        let mut permit = take(&share, 1, 1).unwrap();
        share.extend(&mut permit, 50 * PAGE).await;
        share.extend(&mut permit, usize::MAX).await;
        assert_eq!(share.used(), 64 * PAGE);
        // One of two gets at most a half.
        drop(permit);
        let mut permit = take(&share, 1, 1).unwrap();
        let _other = take(&share, 1, 1).unwrap();
        assert!(
            share
                .extend(&mut permit, 50 * PAGE)
                .now_or_never()
                .is_none()
        );
        assert!(
            share
                .extend(&mut permit, 30 * PAGE)
                .now_or_never()
                .is_some()
        );
    }

    #[tokio::test]
    async fn pieces_that_grow_do_not_wait_for_each_other() {
        let share = share();
        let mut permits: Vec<Permit> = (1..=3).map(|k| take(&share, k, 16).unwrap()).collect();
        let [first, second, third] = &mut permits[..] else {
            unreachable!();
        };
        {
            let mut one = Box::pin(share.extend(first, 40 * PAGE));
            assert!(one.as_mut().now_or_never().is_none(), "the others continue");
            let mut other = Box::pin(share.extend(third, 40 * PAGE));
            assert!(other.as_mut().now_or_never().is_none());
            assert!(one.now_or_never().is_some(), "it came first");
            assert!(other.now_or_never().is_none());
        }
        // Only for the favoured piece, however often it requests more.
        assert!(share.extend(first, PAGE).now_or_never().is_some());
        assert_eq!(share.used(), (57 + 16 + 16) * PAGE);
        let mut one = Box::pin(share.extend(second, 30 * PAGE));
        let mut other = Box::pin(share.extend(third, 40 * PAGE));
        assert!(one.as_mut().now_or_never().is_none());
        assert!(other.as_mut().now_or_never().is_none());
        assert!(share.take_at_once(peer(4), PAGE).is_none());
        drop((one, other));
        // The next one, when that one has given everything back.
        let [first, mut second, mut third] = <[Permit; 3]>::try_from(permits).unwrap();
        let mut one = Box::pin(share.extend(&mut second, 60 * PAGE));
        let mut other = Box::pin(share.extend(&mut third, 60 * PAGE));
        assert!(one.as_mut().now_or_never().is_none());
        assert!(other.as_mut().now_or_never().is_none());
        drop(first);
        assert!(one.now_or_never().is_some());
        assert!(other.as_mut().now_or_never().is_none());
        drop(second);
        assert!(other.now_or_never().is_some());
        drop(third);
        assert_eq!(share.used(), 0);
        assert!(!share.state.lock().has_favourite);
    }

    #[tokio::test]
    async fn waiting_tasks_take_turns() {
        let share = share();
        let first = take(&share, 1, 30).unwrap();
        let mut own = Box::pin(share.take(peer(1), 30 * PAGE));
        let mut given_up = Box::pin(share.take(peer(2), 40 * PAGE));
        let mut large = Box::pin(share.take(peer(3), 40 * PAGE));
        assert!(own.as_mut().now_or_never().is_none());
        assert!(given_up.as_mut().now_or_never().is_none());
        assert!(large.as_mut().now_or_never().is_none());
        drop(given_up);
        // Others pass while there is room for them.
        let small = take(&share, 4, 3).unwrap();
        drop(first);
        // Room for one of the two, whose turn comes first.
        let own = own.now_or_never().flatten().unwrap();
        assert!(large.as_mut().now_or_never().is_none());
        drop(own);
        let large = large.now_or_never().flatten().unwrap();
        drop((small, large));
        assert_eq!(share.used(), 0);
    }

    #[tokio::test]
    async fn a_piece_that_has_waited_for_long_gets_its_room() {
        let share = share();
        let _first = take(&share, 1, 30).unwrap();
        let mut large = Box::pin(share.take(peer(2), 40 * PAGE));
        assert!(large.as_mut().now_or_never().is_none());
        let now = Instant::now();
        let state = || share.state.lock();
        assert!(state().overdue(now).is_none());
        let overdue = state().overdue(now + 2 * ROOM_WAIT);
        let piece = |last, pages| share.piece(peer(last), pages * PAGE);
        let passes = |last, pages| state().usage.admits(piece(last, pages), overdue);
        assert!(passes(3, 2) && !passes(3, 3) && !passes(1, 1));
        assert!(passes(2, 34), "it does not wait for itself");
        // A piece beyond the part of its peer does not block others.
        drop(large);
        let mut own = Box::pin(share.take(peer(1), 10 * PAGE));
        assert!(own.as_mut().now_or_never().is_none());
        assert!(state().overdue(now + 2 * ROOM_WAIT).is_none());
    }
}
