//! The geometry of one level, shared by everyone who reads it.

use std::sync::Arc;

use super::forms::{Forms, Place};
use crate::fit::iteration::{Iteration, Level};
use crate::fit::points::Points;

/// One level of a fit.
#[derive(Debug)]
pub struct Frame {
    /// The level and its errors.
    pub level: Level,
    /// The free control points.
    pub control_points: Arc<Points>,
    /// Those that have moved since the level before; `None` if all may have.
    pub moved: Option<Arc<[usize]>>,
    /// The fit has ended at this level.
    pub is_last: bool,
    /// What was made of it.
    encoded: Forms,
}

impl Frame {
    /// Bytes that a number of a frame takes: itself, and its decimal digits once somebody reads it.
    const BYTES_PER_NUMBER: usize = 8 + 28;

    /// The current level of a fit.
    pub fn of(iteration: &Iteration) -> Self {
        Self {
            moved: iteration.moved().map(Arc::from),
            is_last: iteration.outcome().is_some(),
            ..Self::last(iteration.level(), iteration.shared_control_points())
        }
    }

    /// The level at which a fit has ended, with control points that may be kept elsewhere.
    pub fn last(level: Level, control_points: Arc<Points>) -> Self {
        Self {
            level,
            control_points,
            moved: None,
            is_last: true,
            encoded: Forms::default(),
        }
    }

    /// Bytes that a frame of `count` points takes in memory.
    pub fn weight(dimension: usize, count: usize) -> usize {
        dimension * count * Self::BYTES_PER_NUMBER + size_of::<Self>()
    }

    /// The place for a form of the frame on the wire: made by its first reader and shared by the others.
    pub fn encoded(&self, form: &Arc<str>) -> Place {
        self.encoded.of(form)
    }
}
