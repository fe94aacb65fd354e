//! The geometry of one level, shared by everyone who reads it.

use std::sync::Arc;

use bytes::Bytes;
use tokio::sync::OnceCell;

use crate::fit::iteration::Level;
use crate::fit::points::Points;

/// One level of a fit.
#[derive(Debug)]
pub struct Frame {
    /// The level and its errors.
    pub level: Level,
    /// The free control points.
    pub control_points: Arc<Points>,
    encoded: OnceCell<Bytes>,
}

impl Frame {
    /// Bytes that a number of a frame takes: itself, and its decimal digits once somebody reads it.
    const BYTES_PER_NUMBER: usize = 8 + 20;

    /// A frame that nobody has read yet.
    pub fn new(level: Level, control_points: Points) -> Self {
        Self {
            level,
            control_points: Arc::new(control_points),
            encoded: OnceCell::new(),
        }
    }

    /// Bytes that a frame of `count` points takes in memory.
    pub fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The frame on the wire: made by `encode` for its first reader and shared by the others.
    pub async fn encoded<F: Future<Output = Bytes>>(&self, encode: impl FnOnce() -> F) -> Bytes {
        self.encoded.get_or_init(encode).await.clone()
    }
}
