//! The recent frames of a run.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::job::frame::Frame;

/// Frames of consecutive levels.
///
/// A run takes several steps at once while it has no reader, so two frames that are pushed one after the other can
/// be several levels apart. The older ones are dropped then: a level that was skipped is missing here, and another
/// run computes it.
#[derive(Debug, Default)]
pub(super) struct FrameRing(VecDeque<Arc<Frame>>);

impl FrameRing {
    /// The number of frames.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds a frame. Frames before a skipped level are dropped.
    pub(super) fn push(&mut self, frame: Arc<Frame>) {
        let level = frame.level.iteration;
        let newest = self.0.back().map(|newest| newest.level.iteration + 1);
        if newest.is_some_and(|next| next != level) {
            self.clear();
        }
        self.0.push_back(frame);
    }

    /// The frame of this level, if it is here. The level is that which the frame itself carries.
    pub(super) fn get(&self, level: usize) -> Option<&Arc<Frame>> {
        let oldest = self.0.front()?.level.iteration;
        let frame = self.0.get(level.checked_sub(oldest)?)?;
        (frame.level.iteration == level).then_some(frame)
    }

    /// Removes the oldest frame.
    pub(super) fn pop_oldest(&mut self) -> Option<Arc<Frame>> {
        self.0.pop_front()
    }

    /// Drops all frames.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}
