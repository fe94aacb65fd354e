//! What all threads of a pass share.

use super::buffers::Vectors;
use super::fused::Update;
use crate::fit::blocks::Blocks;
use crate::fit::linear::banded::Banded;
use crate::fit::method::relaxation::Step;
use crate::fit::points::Points;

/// Levels that are computed in one pass, at most: more would not be limited by memory any more.
pub const LEVELS: usize = 8;

/// How far a pass goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The level is measured, and nothing written.
    Measure,
    /// To the next level, or to the residual.
    Level,
    /// Through several levels, tile by tile.
    Tiles,
}

/// What all parts of a pass share.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a> {
    /// The collocation matrix of a curve, or of direction u.
    pub u: &'a Banded,
    /// Of direction v.
    pub v: Option<&'a Banded>,
    /// P.
    pub data: &'a Points,
    /// The level that the pass starts from.
    pub source: &'a Vectors,
    /// From each level to the next.
    pub steps: &'a [Step],
    /// What residuals are multiplied with before they are squared.
    pub scale: f64,
    /// The blocks of the errors.
    pub layout: Blocks,
    /// Points of a tile.
    pub tile: usize,
    /// How far it goes.
    pub way: Way,
}

impl<'a> Pass<'a> {
    /// The update of a level, with the matrix along a line; behind the last level nothing moves.
    pub(super) fn update(&self, matrix: &'a Banded, level: usize) -> Update<'a> {
        Update {
            matrix,
            step: self.steps.get(level).copied().unwrap_or_default(),
            scale: self.scale,
        }
    }
}
