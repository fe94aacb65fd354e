//! The geometry of one level, shared by everyone who reads it.

use std::sync::Arc;

use bytes::Bytes;
use parking_lot::Mutex;
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
    /// What was made of it, by the name of the view.
    encoded: Mutex<Vec<(String, Arc<OnceCell<Bytes>>)>>,
}

impl Frame {
    /// Bytes that a number of a frame takes: itself, and its decimal digits once somebody reads it.
    const BYTES_PER_NUMBER: usize = 8 + 20;

    /// A frame that nobody has read yet.
    pub fn new(level: Level, control_points: Points) -> Self {
        Self::last(level, Arc::new(control_points))
    }

    /// The frame of control points that are kept elsewhere: the last ones.
    pub fn last(level: Level, control_points: Arc<Points>) -> Self {
        Self {
            level,
            control_points,
            encoded: Mutex::default(),
        }
    }

    /// Bytes that a frame of `count` points takes in memory.
    pub fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The place for a view of the frame on the wire: made by its first reader and shared by the others.
    pub fn encoded(&self, view: &str) -> Arc<OnceCell<Bytes>> {
        let mut encoded = self.encoded.lock();
        if let Some((_, cell)) = encoded.iter().find(|(name, _)| name == view) {
            return Arc::clone(cell);
        }
        let cell = Arc::new(OnceCell::new());
        encoded.push((view.to_owned(), Arc::clone(&cell)));
        cell
    }
}
