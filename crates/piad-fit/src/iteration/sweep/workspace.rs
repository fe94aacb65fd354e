//! The workspace of a thread: points that are written and read again within a pass, and forgotten after it.

use std::ops::Range;

use super::pass::{Pass, Way};
use crate::data::blocks::{BLOCK, LANES};
use crate::data::points::Points;
use crate::linear::banded::Banded;

/// The working space of a part, d arrays each.
#[derive(Clone, Debug)]
pub(super) struct Workspace {
    /// Tiles: the control points of a tile at some level, with its margins. Surfaces: a part of a
    /// line of `B_u X`.
    pub front: Points,
    /// Tiles: the control points of the next level. If the level is only measured: a scratch block, as the innermost
    /// loop always writes.
    pub back: Points,
    /// Tiles: the steps d of methods with momentum.
    pub step: Points,
}

impl Default for Workspace {
    fn default() -> Self {
        let none = || Points::new(0);
        Self {
            front: none(),
            back: none(),
            step: none(),
        }
    }
}

impl Workspace {
    /// Makes workspace for a pass, unless there is enough from an earlier one. `levels` is the most
    /// levels that a pass has.
    pub(super) fn prepare(&mut self, pass: &Pass<'_>, levels: usize) {
        let tile = pass.tile + 2 * margin(pass, levels);
        let tile = if pass.way == Way::Tiles { tile } else { 0 };
        let back = if pass.way == Way::Measure {
            BLOCK
        } else {
            tile
        };
        let step = pass.source.step.as_ref().map_or(0, |_| tile);
        let make = |points: &mut Points, count: usize| {
            if points.len() < count {
                *points = Points::zeros(pass.data.dimension(), count);
            }
        };
        make(&mut self.front, pass.v.map_or(tile, line));
        make(&mut self.back, back);
        make(&mut self.step, step);
    }
}

/// The number of points on either side of a tile that it needs for `levels` levels: `levels + 1` times the reach of a
/// row of B, rounded up to whole cache lines so that the tile starts at one.
pub(super) fn margin(pass: &Pass<'_>, levels: usize) -> usize {
    ((levels + 1) * pass.u.reach()).next_multiple_of(LANES)
}

/// The workspace for a part of a line of `B_u X`: a block, and the columns that its rows of `B_v` reach
/// on both sides.
fn line(v: &Banded) -> usize {
    BLOCK + 2 * v.reach()
}

/// Cuts a range of points at the multiples of `period` and of `length`, the length of blocks. Gives
/// each piece, and its first point within the period: on closed curves point −1 is point
/// `period − 1`.
pub(super) fn pieces(
    range: Range<i64>,
    period: i64,
    length: i64,
) -> impl Iterator<Item = (Range<i64>, usize)> {
    let mut start = range.start;
    std::iter::from_fn(move || {
        if start >= range.end {
            return None;
        }
        let first = start.rem_euclid(period);
        let turn = start + period - first;
        let block = start.saturating_add(length - start.rem_euclid(length));
        let piece = start..range.end.min(turn).min(block);
        start = piece.end;
        Some((piece, first as usize))
    })
}
