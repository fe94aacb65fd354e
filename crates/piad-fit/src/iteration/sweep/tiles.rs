//! Several levels of a curve in one pass: tile by tile, each with a margin (overlapped tiling).
//!
//! After k levels a control point depends on its neighbours up to k times the reach of a row of B,
//! a few points on both sides of a tile of two thousand. So each tile is loaded with a margin on
//! both sides, which shrinks by the reach with every level, and goes through all levels in the
//! nearest caches:
//!
//! ```text
//! level 0   ├──margin──┼────────────── tile ──────────────┼──margin──┤
//! level 1      ├───────┼──────────────────────────────────┼───────┤
//! level 2         ├────┼──────────────────────────────────┼────┤
//! level 3            ├─┼──────────────────────────────────┼─┤
//! ```
//!
//! Memory is moved once for up to eight levels; the margins are computed by both neighbours, about
//! one point in a hundred. On closed curves margins go around the end.
//!
//! The levels between are not kept: if one of them is the last of the fit, the pass is repeated with fewer levels, from
//! control points that it has not touched.

use std::ops::Range;

use super::buffers::Vectors;
use super::fused::Rows;
use super::parts::{Part, columns, ranges};
use super::pass::Pass;
use super::workspace::{Workspace, margin, pieces};
use crate::data::blocks::{BLOCK, Block, Squares, Sums};

/// A tile on its way through the levels.
struct Tile<'a, 'b> {
    pass: &'a Pass<'a>,
    workspace: &'b mut Workspace,
    /// The points that it is to compute, without its margins.
    points: Range<i64>,
    /// The point that is first in the workspace. On closed curves points before the first one are those at the end, and
    /// points behind the last one those at the start.
    base: i64,
    /// True if the control points of the first level have been copied to the workspace, rather than read
    /// from where they are.
    loaded: bool,
}

/// Takes all tiles of the part through all levels of the pass. Level 0 of a pass has been measured
/// before; the norms of the others are written to their blocks.
pub(super) fn sweep<const D: usize>(pass: &Pass<'_>, part: Part<'_>) {
    let Part {
        lines,
        mut x,
        mut step,
        blocks,
        workspaces,
        ..
    } = part;
    let [workspace] = workspaces else { return };
    let levels = pass.steps.len();
    let margin = margin(pass, levels);
    for start in lines.clone().step_by(pass.tile) {
        let end = lines.end.min(start + pass.tile);
        let mut tile = Tile {
            pass,
            workspace: &mut *workspace,
            points: start as i64..end as i64,
            base: start as i64 - margin as i64,
            loaded: false,
        };
        tile.load();
        let first = (start - lines.start) / BLOCK;
        let count = (end - start).div_ceil(BLOCK);
        tile.level::<D>(0, &mut []);
        for level in 1..levels {
            let blocks = &mut blocks[level - 1][first..first + count];
            tile.level::<D>(level, blocks);
        }
        let to = start - lines.start..end - lines.start;
        let blocks = &mut blocks[levels - 1][first..first + count];
        tile.last_level(ranges::<D>(&mut x, to.clone()), blocks);
        let steps = tile.workspace.step.lanes().iter().zip(&mut step);
        for (from, step) in steps {
            step[to.clone()].copy_from_slice(&from[margin..margin + to.len()]);
        }
    }
}

impl Tile<'_, '_> {
    /// Copies the steps of the tile with its margins, and its control points if these go around the
    /// end.
    fn load(&mut self) {
        let Vectors { x, step } = self.pass.source;
        let count = x.len() as i64;
        let end = self.points.end + self.points.start - self.base;
        let range = self.within(self.base..end);
        self.loaded = range.start < 0 || range.end > count;
        let base = self.base;
        for (points, first) in pieces(range, count, i64::MAX) {
            let local = (points.start - base) as usize..(points.end - base) as usize;
            let from = first..first + local.len();
            if self.loaded {
                for (to, x) in self.workspace.front.lanes_mut().iter_mut().zip(x.lanes()) {
                    to[local.clone()].copy_from_slice(&x[from.clone()]);
                }
            }
            let lanes = step.iter().flat_map(|step| step.lanes());
            for (to, step) in self.workspace.step.lanes_mut().iter_mut().zip(lanes) {
                to[local.clone()].copy_from_slice(&step[from.clone()]);
            }
        }
    }

    /// The points of a range that exist: all of them on closed curves.
    fn within(&self, range: Range<i64>) -> Range<i64> {
        if self.pass.u.is_cyclic() {
            return range;
        }
        range.start.max(0)..range.end.min(self.pass.u.rows() as i64)
    }

    /// The pieces of a level that later levels need, cut at blocks and at the ends of closed
    /// curves: their points, and the row of B of the first one.
    fn pieces(&self, level: usize) -> impl Iterator<Item = (Range<i64>, usize)> + use<> {
        let left = self.pass.steps.len() - level;
        let margin = (left * self.pass.u.reach()) as i64;
        let range = self.within(self.points.start - margin..self.points.end + margin);
        pieces(range, self.pass.u.rows() as i64, BLOCK as i64)
    }

    /// Computes the next level from a level, and the norms of that level for the blocks of the
    /// tile; without `blocks` they are known already.
    fn level<const D: usize>(&mut self, level: usize, blocks: &mut [Block]) {
        let mut squares = Squares::new();
        for (points, row) in self.pieces(level) {
            let inside = points.start >= self.points.start && points.end <= self.points.end;
            let index = (points.start - self.points.start) / BLOCK as i64;
            let squares = squares.first((points.end - points.start) as usize);
            let sums = self.piece::<D>(level, points, row, squares);
            if let Some(block) = blocks.get_mut(index as usize).filter(|_| inside) {
                *block = Block::new(row, squares, &sums);
            }
        }
        std::mem::swap(&mut self.workspace.front, &mut self.workspace.back);
    }

    /// Computes the next level at points that belong to consecutive rows of B, from `row` on.
    /// Writes the squares of their residuals, and returns what these add up to.
    fn piece<const D: usize>(
        &mut self,
        level: usize,
        points: Range<i64>,
        row: usize,
        squares: &mut [f64],
    ) -> Sums {
        let Self {
            pass,
            workspace,
            base,
            ..
        } = self;
        let local = (points.start - *base) as usize..(points.end - *base) as usize;
        let rows = row..row + local.len();
        let Workspace { front, back, step } = &mut **workspace;
        let (x, base, own) = if level > 0 || self.loaded {
            let base = *base - (points.start - row as i64);
            (&*front, base, local.clone())
        } else {
            (&*pass.source.x, 0, rows.clone())
        };
        let mut given = Rows::<D> {
            x: columns(x, 0..x.len()),
            base,
            data: columns(pass.data, rows.clone()),
            own: columns(x, own),
            next: ranges(back.lanes_mut(), local.clone()),
            step: ranges(step.lanes_mut(), local),
            squares,
            place: 0,
        };
        pass.update(pass.u, level).apply(rows, &mut given)
    }

    /// Computes the norms of the last level, and copies its control points to where they belong.
    fn last_level<const D: usize>(&mut self, mut to: [&mut [f64]; D], blocks: &mut [Block]) {
        let Self {
            pass,
            workspace,
            base,
            ..
        } = self;
        let level = pass.steps.len();
        let first = self.points.start;
        let mut squares = Squares::new();
        for (block, start) in blocks.iter_mut().zip((first..).step_by(BLOCK)) {
            let end = self.points.end.min(start + BLOCK as i64);
            let rows = start as usize..end as usize;
            let local = (start - *base) as usize..(end - *base) as usize;
            let own = (start - first) as usize..(end - first) as usize;
            let squares = squares.first(rows.len());
            let mut given = Rows::<D> {
                x: columns(&workspace.front, 0..workspace.front.len()),
                base: *base,
                data: columns(pass.data, rows.clone()),
                own: columns(&workspace.front, local),
                next: ranges(&mut to, own),
                step: [(); D].map(|()| &mut [][..]),
                squares,
                place: 0,
            };
            let sums = pass.update(pass.u, level).apply(rows, &mut given);
            *block = Block::new(start as usize, squares, &sums);
        }
    }
}
