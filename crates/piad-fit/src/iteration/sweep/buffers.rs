//! The control points of the current level and of the next one.
//!
//! Readers may share the control points of a level (an `Arc`) while the iteration continues. Then
//! the sweep writes the next level into other memory, if possible into memory that a reader has
//! given back.

use std::sync::Arc;

use crate::data::points::Points;

/// What an iteration carries from level to level: n points of R^d each, coordinate by coordinate.
#[derive(Clone, Debug)]
pub(super) struct Vectors {
    /// The control points X, which readers may share.
    pub x: Arc<Points>,
    /// The last step d, of methods with momentum.
    pub step: Option<Points>,
}

impl Vectors {
    /// The control points and the steps, to be overwritten. If readers share the control points,
    /// they keep them, and the sweep takes some that were given back, or new ones.
    pub(super) fn writable(
        &mut self,
        returned: &mut Returned,
    ) -> (&mut Points, Option<&mut Points>) {
        if Arc::get_mut(&mut self.x).is_none() {
            let new = || Points::zeros(self.x.dimension(), self.x.len());
            self.x = Arc::new(returned.take().unwrap_or_else(new));
        }
        (Arc::make_mut(&mut self.x), self.step.as_mut())
    }
}

/// Control points of earlier levels that readers have given back, to be overwritten: memory that
/// has been used before is quicker than what comes from the operating system, which clears every
/// page. Other readers may still share some of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Returned(Vec<Arc<Points>>);

impl Returned {
    /// The most buffers that are kept: about the number that slow readers share at a time.
    const MAX_BUFFERS: usize = 4;

    /// Keeps points for later, unless there are enough.
    pub(super) fn add(&mut self, points: Arc<Points>) {
        if self.0.len() < Self::MAX_BUFFERS {
            self.0.push(points);
        }
    }

    /// Takes points that are no longer shared. If there are several, the others are freed.
    pub(super) fn take(&mut self) -> Option<Points> {
        let mut free = None;
        for points in std::mem::take(&mut self.0) {
            match Arc::try_unwrap(points) {
                Ok(points) => free = Some(points),
                Err(points) => self.0.push(points),
            }
        }
        free
    }
}
