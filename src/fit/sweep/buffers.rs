//! The control points of the current level and of the next one.

use std::sync::Arc;

use crate::fit::points::Points;

/// What an iteration carries from level to level.
#[derive(Debug)]
pub(super) struct Vectors {
    /// The control points, which readers may share.
    pub x: Arc<Points>,
    /// The last step, of methods with momentum.
    pub step: Option<Points>,
}

impl Vectors {
    /// Control points that nobody else sees, to be overwritten, and the steps: if there are readers of
    /// these points, they keep them, and those that were given back are taken, or new ones.
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

/// Points of earlier levels, to be overwritten: memory that has been used before is quicker than what
/// comes from the system. Some may still be on their way to readers.
#[derive(Debug, Default)]
pub(super) struct Returned(Vec<Arc<Points>>);

impl Returned {
    /// As many as slow readers are likely to have.
    const MOST: usize = 4;

    pub(super) fn add(&mut self, points: Arc<Points>) {
        if self.0.len() < Self::MOST {
            self.0.push(points);
        }
    }

    /// Points that nobody else has any more. If there are several, only one is kept.
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
