//! Bytes for the wire: small ones whole, large ones made piece by piece as they are sent.
//!
//! A frame of a million points is tens of megabytes as text. So only a description of its pieces is
//! kept; each is made when a reader comes to it, and the last few are at hand for the others.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use parking_lot::Mutex;
use tokio::sync::OnceCell;

use super::memory::{Cache, Charge, Permit};
use super::scheduler::{Broken, Lane, Scheduler};

/// So many pieces are kept for readers that follow; where memory is scarce, those that are being made.
const RECENT: usize = 16;
const FEWEST: usize = 4;

/// Something on the wire.
#[derive(Clone, Debug)]
pub struct Content {
    /// What it begins with; all of it, if there is no rest.
    pub head: Bytes,
    /// What follows.
    pub rest: Option<Arc<Pieces>>,
    /// What the head takes while it is kept.
    charge: Option<Arc<Charge>>,
    /// What it takes of another part of the memory until it is sent.
    permit: Option<Arc<Permit>>,
}

impl From<Bytes> for Content {
    fn from(head: Bytes) -> Self {
        Self::new(head, None)
    }
}

impl Content {
    /// What it begins with, and what follows.
    pub fn new(head: Bytes, rest: Option<Arc<Pieces>>) -> Self {
        Self {
            head,
            rest,
            charge: None,
            permit: None,
        }
    }

    /// The same, which takes some memory until it is sent.
    pub fn with_permit(mut self, permit: Option<Permit>) -> Self {
        self.permit = permit.map(Arc::new);
        self
    }

    /// The same, which is kept in a cache from now on.
    pub(super) fn kept_in(mut self, cache: &Arc<Cache>) -> Self {
        self.charge = Some(Arc::new(cache.charge(self.head.len())));
        if let Some(rest) = &self.rest {
            // Who kept it before does so still.
            let _ = rest.cache.set(Arc::clone(cache));
        }
        self
    }

    /// The number of all bytes, if it is known without making them.
    pub fn length(&self) -> Option<usize> {
        let rest = self.rest.as_ref();
        Some(self.head.len() + rest.map_or(Some(0), |rest| rest.length)?)
    }

    /// Everything, made on this thread.
    pub fn whole(self) -> Bytes {
        match self.rest {
            None => self.head,
            Some(rest) => rest.whole(&self.head),
        }
    }
}

/// A part of something large.
pub enum Piece {
    /// Here it is.
    Made(Bytes),
    /// It can be made, as often as needed.
    Later(Box<dyn Fn() -> Bytes + Send + Sync>),
}

/// The parts of something large, shared by all who send it.
pub struct Pieces {
    pieces: Vec<Piece>,
    /// All bytes, where that is known without making them.
    length: Option<usize>,
    /// The last pieces that were made, in order.
    recent: Mutex<VecDeque<(usize, Made)>>,
    /// Where they are kept.
    cache: OnceLock<Arc<Cache>>,
}

type Made = Arc<OnceCell<Kept>>;

/// A piece that was made.
struct Kept {
    bytes: Bytes,
    _charge: Option<Charge>,
}

impl Pieces {
    /// Nothing is made yet.
    pub fn new(pieces: Vec<Piece>, length: Option<usize>) -> Self {
        Self {
            pieces,
            length,
            recent: Mutex::default(),
            cache: OnceLock::new(),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.pieces.len()
    }

    /// A piece, made in the compute pool unless it is at hand.
    pub async fn piece(self: &Arc<Self>, index: usize, pool: &Scheduler) -> Result<Bytes, Broken> {
        if let Piece::Made(bytes) = &self.pieces[index] {
            return Ok(bytes.clone());
        }
        let make = || async {
            let pieces = Arc::clone(self);
            let bytes = pool.compute(Lane::Wire, move || pieces.make(index)).await?;
            let charge = self.cache.get().map(|cache| cache.charge(bytes.len()));
            Ok(Kept {
                bytes,
                _charge: charge,
            })
        };
        let place = self.place(index);
        let kept = place.get_or_try_init(make).await?;
        Ok(kept.bytes.clone())
    }

    /// All bytes behind the head.
    fn whole(&self, head: &Bytes) -> Bytes {
        let mut whole = Vec::with_capacity(head.len() + self.length.unwrap_or(0));
        whole.extend_from_slice(head);
        for index in 0..self.count() {
            whole.extend_from_slice(&self.make(index));
        }
        whole.into()
    }

    /// A piece, made on this thread.
    pub fn make(&self, index: usize) -> Bytes {
        match &self.pieces[index] {
            Piece::Made(bytes) => bytes.clone(),
            Piece::Later(make) => make(),
        }
    }

    /// Where a piece is or will be. Readers far behind the first one make theirs for themselves.
    fn place(&self, index: usize) -> Made {
        let mut recent = self.recent.lock();
        if let Some((_, made)) = recent.iter().find(|(known, _)| *known == index) {
            return Arc::clone(made);
        }
        let made = Made::default();
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

    /// Readers that go together share what is made; one that is far behind costs only itself.
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
