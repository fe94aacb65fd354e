//! Bytes to send: small contents are kept whole, large ones are made piece by piece as they are sent.
//!
//! A frame of a million points is tens of megabytes as text. So of large contents only the closures that make their
//! pieces are kept. A piece is made when a reader needs it, and the last few pieces are cached for the other readers.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use parking_lot::Mutex;
use tokio::sync::OnceCell;

use super::memory::{Cache, Charge, Permit};
use super::scheduler::{Broken, Scheduler, WorkLane};

/// The number of pieces cached for readers that follow, and the number while the cache is full.
const RECENT: usize = 16;
const FEWEST: usize = 4;

/// A body, an event or a file for the wire.
#[derive(Clone, Debug)]
pub(crate) struct Content {
    /// The first bytes; all of them, if there is no rest.
    pub head: Bytes,
    /// What follows the head.
    pub rest: Option<Arc<Pieces>>,
    /// The bytes of the head in the cache.
    charge: Option<Arc<Charge>>,
    /// Memory of another part, held until it is sent.
    permit: Option<Arc<Permit>>,
}

impl From<Bytes> for Content {
    fn from(head: Bytes) -> Self {
        Self::new(head, None)
    }
}

impl Content {
    /// A content of a head and what follows it.
    pub(crate) fn new(head: Bytes, rest: Option<Arc<Pieces>>) -> Self {
        Self {
            head,
            rest,
            charge: None,
            permit: None,
        }
    }

    /// The same content, which holds this memory until it is sent.
    pub(crate) fn with_permit(mut self, permit: Option<Permit>) -> Self {
        self.permit = permit.map(Arc::new);
        self
    }

    /// The same content, of which all pieces together take this many multiplications to make.
    pub(crate) fn costing(mut self, multiplications: usize) -> Self {
        if let Some(rest) = self.rest.as_mut().and_then(Arc::get_mut) {
            rest.multiplications = multiplications / rest.count().max(1);
        }
        self
    }

    /// The same content, counted in the cache from now on.
    pub(crate) fn kept_in(mut self, cache: &Arc<Cache>) -> Self {
        self.charge = Some(Arc::new(cache.charge(self.head.len())));
        if let Some(rest) = &self.rest {
            // If it is in the cache already, it stays counted there.
            let _ = rest.cache.set(Arc::clone(cache));
        }
        self
    }

    /// The number of bytes, if it is known without making them.
    pub(crate) fn length(&self) -> Option<usize> {
        let rest = self.rest.as_ref();
        Some(self.head.len() + rest.map_or(Some(0), |rest| rest.length)?)
    }

    /// All bytes, made on this thread.
    pub(crate) fn whole(self) -> Bytes {
        match self.rest {
            None => self.head,
            Some(rest) => rest.whole(&self.head),
        }
    }
}

/// A part of a large content.
pub(crate) enum Piece {
    /// Its bytes.
    Made(Bytes),
    /// Makes its bytes, as often as they are needed.
    Later(Box<dyn Fn() -> Bytes + Send + Sync>),
}

/// The parts of a large content, shared by all who send it.
pub(crate) struct Pieces {
    pieces: Vec<Piece>,
    /// The number of bytes, if it is known without making them.
    length: Option<usize>,
    /// Making a piece takes about as long as sending it.
    are_quick: bool,
    /// The multiplications that a piece takes.
    multiplications: usize,
    /// The last pieces that were made, in order.
    recent: Mutex<VecDeque<(usize, Making)>>,
    /// The cache in which made pieces are counted.
    cache: OnceLock<Arc<Cache>>,
}

/// A piece that is made by the first reader that needs it.
type Making = Arc<OnceCell<CachedPiece>>;

struct CachedPiece {
    bytes: Bytes,
    _charge: Option<Charge>,
}

impl Pieces {
    /// Nothing is made yet.
    pub(crate) fn new(pieces: Vec<Piece>, length: Option<usize>) -> Self {
        Self {
            pieces,
            length,
            are_quick: false,
            multiplications: 0,
            recent: Mutex::default(),
            cache: OnceLock::new(),
        }
    }

    /// The same pieces, which are made where they are sent if they are quick to make: to hand them over
    /// from another thread would take longer.
    pub(crate) fn quick(self, are_quick: bool) -> Self {
        Self { are_quick, ..self }
    }

    /// Returns true if they are quick to make.
    pub(crate) fn are_quick(&self) -> bool {
        self.are_quick
    }

    /// The number of pieces.
    pub(crate) fn count(&self) -> usize {
        self.pieces.len()
    }

    /// The bytes of a piece, made on the compute pool unless they are cached, or quick to make.
    pub(crate) async fn piece(
        self: &Arc<Self>,
        index: usize,
        pool: &Scheduler,
    ) -> Result<Bytes, Broken> {
        if let Piece::Made(bytes) = &self.pieces[index] {
            return Ok(bytes.clone());
        }
        let make = || async {
            let bytes = match self.are_quick {
                true => self.make(index),
                false => {
                    let pieces = Arc::clone(self);
                    let make = move || pieces.make(index);
                    let lane = WorkLane::of_pieces(self.multiplications);
                    pool.compute_in_turns(lane, make).await?
                }
            };
            let charge = self.cache.get().map(|cache| cache.charge(bytes.len()));
            Ok(CachedPiece {
                bytes,
                _charge: charge,
            })
        };
        let piece = self.cached(index);
        Ok(piece.get_or_try_init(make).await?.bytes.clone())
    }

    /// The head and all pieces.
    fn whole(&self, head: &Bytes) -> Bytes {
        let mut whole = Vec::with_capacity(head.len() + self.length.unwrap_or(0));
        whole.extend_from_slice(head);
        for index in 0..self.count() {
            whole.extend_from_slice(&self.make(index));
        }
        whole.into()
    }

    /// The bytes of a piece, made on this thread.
    pub(crate) fn make(&self, index: usize) -> Bytes {
        match &self.pieces[index] {
            Piece::Made(bytes) => bytes.clone(),
            Piece::Later(make) => make(),
        }
    }

    /// The cached piece, or a new one that is cached unless other readers are ahead: readers that are
    /// far behind make their pieces for themselves.
    fn cached(&self, index: usize) -> Making {
        let mut recent = self.recent.lock();
        if let Some((_, made)) = recent.iter().find(|(known, _)| *known == index) {
            return Arc::clone(made);
        }
        let made = Making::default();
        if recent.back().is_none_or(|(newest, _)| *newest < index) {
            let scarce = self.cache.get().is_some_and(|cache| cache.is_full());
            let most = if scarce { FEWEST } else { RECENT };
            while recent.len() >= most {
                recent.pop_front();
            }
            recent.push_back((index, Arc::clone(&made)));
        }
        made
    }
}

impl std::fmt::Debug for Pieces {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut fields = f.debug_struct("Pieces");
        fields.field("count", &self.count());
        fields.field("length", &self.length).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Readers at the same place share pieces; one that is far behind costs only itself.
    #[tokio::test]
    async fn pieces_are_shared_by_those_who_are_close() {
        let pool = Scheduler::new(1).unwrap();
        let made = Arc::new(AtomicUsize::new(0));
        let piece = |index: u8| {
            let made = Arc::clone(&made);
            Piece::Later(Box::new(move || {
                made.fetch_add(1, Ordering::Relaxed);
                vec![index].into()
            }))
        };
        let count = 2 * RECENT as u8;
        let pieces = Arc::new(Pieces::new(
            (0..count).map(piece).collect(),
            Some(count.into()),
        ));
        for index in 0..pieces.count() {
            let of = pieces.piece(index, &pool);
            let (one, other) = tokio::join!(of, pieces.piece(index, &pool));
            assert_eq!(
                (one.unwrap()[0], other.unwrap()[0]),
                (index as u8, index as u8)
            );
        }
        assert_eq!(made.load(Ordering::Relaxed), pieces.count());
        assert_eq!(pieces.piece(0, &pool).await.unwrap()[0], 0);
        assert_eq!(
            pieces.piece(pieces.count() - 1, &pool).await.unwrap()[0],
            count - 1
        );
        assert_eq!(made.load(Ordering::Relaxed), pieces.count() + 1);
        let (head, count) = (Bytes::from_static(b"!"), pieces.count());
        let rest = Some(pieces);
        assert_eq!(Content::new(head, rest).whole().len(), 1 + count);
    }
}
