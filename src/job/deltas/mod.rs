//! Iterations as differences from a reader's state, to save bytes.
//!
//! After a complete iteration, each further one gives the number of steps by which every number moves. A step is a
//! power of two not above a 64th of the largest error, so a reader that adds them has the same numbers as the server,
//! to the bit, and nothing drifts: they are within half a step of those of the iteration.
//!
//! - `lanes`: an array of numbers that follows another one; `packed`: whole numbers in few bits.

mod lanes;
mod packed;

use std::sync::{Arc, Weak};

use super::content::Content;
use super::memory::{Cache, Charge};
use lanes::{Lanes, step};

pub(crate) use lanes::{Change, Target};
pub(crate) use packed::Malformed;

/// The state of a reader: the points of an iteration, and weights where these change.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    iteration: usize,
    arrays: Vec<Lanes>,
    charge: Charge,
}

/// A step from a state to the next iteration, made once for all readers with that state.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// The event.
    pub content: Content,
    /// Its contents.
    pub changes: Arc<[Change]>,
    /// The state after it, while a reader has it.
    pub after: Weak<Numbers>,
    _charge: Option<Arc<Charge>>,
}

impl Step {
    /// A step that is not kept yet.
    pub(crate) fn new(content: Content, changes: Vec<Change>, after: Weak<Numbers>) -> Self {
        Self {
            content,
            changes: changes.into(),
            after,
            _charge: None,
        }
    }

    /// The same, counted in the cache from now on.
    pub(super) fn kept_in(self, cache: &Arc<Cache>) -> Self {
        let bytes = self.changes.iter().map(|change| change.numbers.len());
        Self {
            _charge: Some(Arc::new(cache.charge(bytes.sum()))),
            content: self.content.kept_in(cache),
            ..self
        }
    }
}

impl Numbers {
    /// Bytes of memory for the numbers in these arrays.
    fn bytes(arrays: &[Lanes]) -> usize {
        arrays.iter().map(|array| 8 * array.count()).sum()
    }

    /// All numbers of an iteration, counted in this part of the memory, if they are finite.
    pub(crate) fn of(iteration: usize, targets: &[Target], cache: &Arc<Cache>) -> Option<Self> {
        let arrays: Option<Vec<Lanes>> = targets.iter().map(Lanes::of).collect();
        let arrays = arrays?;
        Some(Self {
            iteration,
            charge: cache.charge(Self::bytes(&arrays)),
            arrays,
        })
    }

    /// A private copy, if others hold the state too; there may be no memory for it.
    pub(crate) fn alone(held: &mut Arc<Self>) -> Option<&mut Self> {
        let is_alone = Arc::strong_count(held) == 1;
        (is_alone || held.charge.has_room()).then(|| Arc::make_mut(held))
    }

    /// The iteration that they approximate.
    pub(crate) fn iteration(&self) -> usize {
        self.iteration
    }

    /// The steps of each array for an error of the points. Weights have steps that move points about as far.
    fn steps(&self, error: f64) -> Vec<f64> {
        let points = self.arrays.first().map_or(0.0, Lanes::largest);
        let of_array = |(index, array): (usize, &Lanes)| match index {
            0 => step(error, array.largest()),
            _ if points == 0.0 => step(0.0, array.largest()),
            _ => step(error * (array.largest() / points), array.largest()),
        };
        self.arrays.iter().enumerate().map(of_array).collect()
    }

    /// True if numbers of 32 bits are as near as steps for this error.
    pub(crate) fn have_room_in_32_bits(&self, error: f64) -> bool {
        let mut steps = self.arrays.iter().zip(self.steps(error));
        error.is_finite() && steps.all(|(array, step)| array.has_room_in_32_bits(step))
    }

    /// Rounds all to 32 bits.
    pub(crate) fn round_to_32_bits(&mut self) {
        self.arrays.iter_mut().for_each(Lanes::round_to_32_bits);
    }

    /// Moves to an iteration with this error; `None` if it is too far away, after which the numbers are invalid.
    pub(crate) fn follow(
        &mut self,
        iteration: usize,
        error: f64,
        targets: &[Target],
    ) -> Option<Vec<Change>> {
        if !error.is_finite() || targets.len() != self.arrays.len() {
            return None;
        }
        self.iteration = iteration;
        let steps = self.steps(error);
        let arrays = self.arrays.iter_mut().zip(targets).zip(steps);
        arrays
            .map(|((array, target), step)| array.follow(target, step))
            .collect()
    }

    /// Applies the step of another reader with the same state.
    pub(crate) fn apply(&mut self, iteration: usize, changes: &[Change]) -> Result<(), Malformed> {
        self.iteration = iteration;
        let mut arrays = self.arrays.iter_mut().zip(changes);
        arrays.try_for_each(|(array, change)| array.apply(change))
    }
}
