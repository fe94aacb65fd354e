//! Shared data of the threads of a pass.
//!
//! A pass reads the control points X of one level, n points of R^d, with P and B, and writes those
//! of a later level X' elsewhere. Its threads write to disjoint [parts](super::parts).

use super::buffers::Vectors;
use super::fused::Update;
use crate::data::blocks::Blocks;
use crate::data::points::Points;
use crate::linear::banded::Banded;
use crate::method::relaxation::Step;

/// The most levels that are computed in one pass: from here on arithmetic takes longer than memory.
pub const LEVELS: usize = 8;

/// How far a pass goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// The level is measured, and no next one is written.
    Measure,
    /// One step, to the next level, or to the residual.
    Level,
    /// Several steps of a curve, tile by tile.
    Tiles,
}

/// What all parts of a pass share.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a> {
    /// The collocation matrix of a curve, n × n, or of direction u.
    pub u: &'a Banded,
    /// The collocation matrix of direction v of a surface.
    pub v: Option<&'a Banded>,
    /// The data P.
    pub data: &'a Points,
    /// The level from which the pass starts.
    pub source: &'a Vectors,
    /// The steps from each level to the next, one for each level of the pass.
    pub steps: &'a [Step],
    /// The power of two that residuals are multiplied with before they are squared.
    pub scale: f64,
    /// The blocks in which errors are summed up.
    pub layout: Blocks,
    /// The number of points of a tile.
    pub tile: usize,
    /// How far the pass goes.
    pub way: Way,
}

impl<'a> Pass<'a> {
    /// The update of a level, with the matrix along a line. Behind the last step of the pass
    /// nothing moves: that level is only measured.
    pub(super) fn update(&self, matrix: &'a Banded, level: usize) -> Update<'a> {
        Update {
            matrix,
            step: self.steps.get(level).copied().unwrap_or_default(),
            scale: self.scale,
        }
    }
}
