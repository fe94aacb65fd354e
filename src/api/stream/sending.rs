//! The bytes that are sent on a connection: small contents are joined into one write, large ones are
//! sent piece by piece, while the next pieces are being made.

use std::collections::VecDeque;
use std::sync::Arc;

use bytes::{Bytes, BytesMut};
use tokio::task::JoinHandle;

use crate::job::content::{Content, Pieces};
use crate::job::peer;
use crate::job::resources::Resources;
use crate::job::scheduler::Broken;

/// Contents up to this size are copied together with their surroundings.
const SMALL: usize = 16 * 1024;

/// The number of pieces that are made ahead of the one that is being sent.
const AHEAD: usize = 3;

/// After contents above this size many of the same size are expected.
const FEW: usize = 1024;

/// Contents that are copied together are sent when they reach this size.
pub(crate) const SENT_BYTES: usize = 64 * 1024;

/// Bytes in the order in which they are sent.
pub(crate) struct Outgoing {
    resources: Arc<Resources>,
    unsent: VecDeque<Unsent>,
    /// Small contents that will be sent together, after `unsent`.
    together: BytesMut,
    /// The pieces after the last one sent that are already being made.
    ahead: VecDeque<JoinHandle<Result<Bytes, Broken>>>,
}

enum Unsent {
    Bytes(Bytes),
    /// A content that is cut into parts but kept as a whole, as it holds memory until it is sent.
    Whole(Content),
    /// The pieces of a content from this index on.
    Pieces(Arc<Pieces>, usize),
}

impl Outgoing {
    /// An empty queue; pieces are made on the compute pool.
    pub(crate) fn new(resources: Arc<Resources>) -> Self {
        Self {
            resources,
            unsent: VecDeque::new(),
            together: BytesMut::new(),
            ahead: VecDeque::new(),
        }
    }

    /// Returns true if there is nothing to send.
    pub(crate) fn is_empty(&self) -> bool {
        self.unsent.is_empty() && self.together.is_empty()
    }

    /// Returns true if there is enough to send, so that nothing more should be gathered.
    pub(crate) fn is_enough(&self) -> bool {
        !self.unsent.is_empty() || self.together.len() >= SENT_BYTES
    }

    /// The buffer for small contents.
    pub(crate) fn text(&mut self) -> &mut BytesMut {
        &mut self.together
    }

    /// Adds a content of any size.
    pub(crate) fn push(&mut self, content: Content) {
        if content.rest.is_none() && content.head.len() > SENT_BYTES {
            self.cut();
            return self.unsent.push_back(Unsent::Whole(content));
        }
        self.push_bytes(content.head);
        if let Some(rest) = content.rest {
            self.cut();
            self.unsent.push_back(Unsent::Pieces(rest, 0));
        }
    }

    fn push_bytes(&mut self, bytes: Bytes) {
        if bytes.len() <= SMALL {
            // Room for this one, or for many of the same size.
            if self.together.capacity() < self.together.len() + bytes.len() {
                let many = if bytes.len() > FEW {
                    SENT_BYTES + SMALL
                } else {
                    0
                };
                self.together.reserve(bytes.len().max(many));
            }
            self.together.extend_from_slice(&bytes);
        } else {
            self.cut();
            self.unsent.push_back(Unsent::Bytes(bytes));
        }
    }

    fn cut(&mut self) {
        if !self.together.is_empty() {
            let together = self.together.split().freeze();
            self.unsent.push_back(Unsent::Bytes(together));
        }
    }

    /// The next bytes to send, if there are any.
    pub(crate) async fn next(&mut self) -> Option<Result<Bytes, Broken>> {
        if self.unsent.is_empty() {
            self.cut();
        }
        match self.unsent.pop_front()? {
            Unsent::Bytes(bytes) => Some(Ok(bytes)),
            Unsent::Whole(mut content) => {
                let length = content.head.len().min(SENT_BYTES);
                let part = content.head.split_to(length);
                if !content.head.is_empty() {
                    self.unsent.push_front(Unsent::Whole(content));
                }
                Some(Ok(part))
            }
            Unsent::Pieces(pieces, index) => {
                if index + 1 < pieces.count() {
                    let rest = Unsent::Pieces(Arc::clone(&pieces), index + 1);
                    self.unsent.push_front(rest);
                }
                if pieces.are_quick() {
                    let pool = &self.resources.scheduler;
                    return Some(pieces.piece(index, pool).await);
                }
                let last = pieces.count().min(index + 1 + AHEAD);
                for next in index + self.ahead.len()..last {
                    let made = self.make(&pieces, next);
                    self.ahead.push_back(made);
                }
                let piece = self.ahead.pop_front()?;
                Some(piece.await.unwrap_or(Err(Broken)))
            }
        }
    }

    /// Starts to make a piece.
    fn make(&self, pieces: &Arc<Pieces>, index: usize) -> JoinHandle<Result<Bytes, Broken>> {
        let (resources, pieces) = (Arc::clone(&self.resources), Arc::clone(pieces));
        peer::spawn(async move { pieces.piece(index, &resources.scheduler).await })
    }
}

/// Pieces that will not be read any more are not made.
impl Drop for Outgoing {
    fn drop(&mut self) {
        self.ahead.iter().for_each(JoinHandle::abort);
    }
}
