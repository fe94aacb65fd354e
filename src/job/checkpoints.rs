//! Saved levels of an iteration, so that reading a level far back does not restart from level 0 each time.
//!
//! They are evenly spaced, and their number is limited by the cache: when there are more, every second one is dropped.
//! Taking one costs as much as a few levels.

use std::collections::BTreeMap;
use std::sync::Arc;

use parking_lot::Mutex;

use super::memory::{Cache, Charge};
use piad_fit::engine::Iteration;

/// The most checkpoints of an iteration.
const MAX_CHECKPOINTS: usize = 8;

/// The initial distance of checkpoints, in levels.
const CHECKPOINT_LEVELS: usize = 256;

/// The checkpoints of one problem.
#[derive(Debug, Default)]
pub(super) struct Checkpoints(Mutex<Kept>);

#[derive(Debug)]
struct Kept {
    /// Levels that are multiples of this are kept.
    distance: usize,
    levels: BTreeMap<usize, Checkpoint>,
}

#[derive(Debug)]
struct Checkpoint {
    iteration: Iteration,
    _charge: Charge,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            distance: CHECKPOINT_LEVELS,
            levels: BTreeMap::new(),
        }
    }
}

impl Checkpoints {
    /// Keeps the level that an iteration has reached, if it is at the spacing and there is room for this many bytes.
    pub(super) fn pass(&self, iteration: &Iteration, bytes: usize, cache: &Arc<Cache>) {
        let level = iteration.level().iteration;
        if level == 0 || !level.is_multiple_of(CHECKPOINT_LEVELS) || iteration.outcome().is_some() {
            return;
        }
        let mut kept = self.0.lock();
        if cache.is_full() {
            return kept.levels.clear();
        }
        let wanted = level.is_multiple_of(kept.distance) && !kept.levels.contains_key(&level);
        if !wanted || cache.is_half_full() {
            return;
        }
        let Some(iteration) = iteration.copy() else {
            return;
        };
        let checkpoint = Checkpoint {
            iteration,
            _charge: cache.charge(bytes),
        };
        kept.levels.insert(level, checkpoint);
        if kept.levels.len() > MAX_CHECKPOINTS {
            kept.distance *= 2;
            let distance = kept.distance;
            kept.levels
                .retain(|level, _| level.is_multiple_of(distance));
        }
    }

    /// The number of levels that may be computed at once from this one without skipping a checkpoint.
    pub(super) fn at_once(level: usize) -> usize {
        CHECKPOINT_LEVELS - level % CHECKPOINT_LEVELS
    }

    /// Returns true if the way from this level to another one is shorter from a checkpoint.
    pub(super) fn shorten(&self, from: usize, to: usize) -> bool {
        let kept = self.0.lock();
        let last = kept.levels.range(..=to).next_back();
        last.is_some_and(|(&level, _)| level > from + 2 * CHECKPOINT_LEVELS)
    }

    /// The last checkpoint that is not beyond this level.
    pub(super) fn before(&self, level: usize) -> Option<Iteration> {
        let kept = self.0.lock();
        let (_, checkpoint) = kept.levels.range(..=level).next_back()?;
        checkpoint.iteration.copy()
    }
}
