//! Several levels of a curve in one pass: tile by tile, each with a margin.
//!
//! After n levels a control point depends on its neighbours up to n times the reach of a row of B,
//! a few points on both sides of a tile of a thousand. So each tile is loaded with a margin on both
//! sides, which shrinks by the reach with every level, and goes through all levels in the nearest
//! caches (overlapped tiling). The levels between are not kept: if one of them is the last of the
//! fit, the pass is taken again with fewer levels, from control points that it has not touched.

use std::ops::Range;

use super::fused::{self, Lane};
use super::parts::Part;
use super::{Pass, Vectors};
use crate::fit::blocks::{BLOCK, Block};
use crate::fit::points::Points;

/// Working space of a part.
#[derive(Debug)]
pub struct Room {
    /// Of tiles: a level and the next one. Of surfaces: lines of `X B_vᵀ`.
    pub front: Points,
    /// The next level.
    pub back: Points,
    /// Steps of methods with momentum.
    pub step: Points,
}

impl Default for Room {
    fn default() -> Self {
        let none = || Points::new(0);
        Self {
            front: none(),
            back: none(),
            step: none(),
        }
    }
}

impl Room {
    /// Makes room for a kind of pass, once.
    pub fn prepare(&mut self, pass: &Pass<'_>, tiled: bool, levels: usize) {
        let (count, is_tile) = match pass.v {
            Some(v) => (super::surface::window(pass.u) * v.columns(), false),
            None if tiled => (pass.tile + 2 * (levels + 1) * pass.u.reach(), true),
            None => return,
        };
        if self.front.len() == count {
            return;
        }
        let zeros = || Points::zeros(pass.data.dimension(), count);
        self.front = zeros();
        if is_tile {
            self.back = zeros();
            if pass.source.step.is_some() {
                self.step = zeros();
            }
        }
    }
}

/// A tile on its way through the levels.
struct Tile<'a, 'b> {
    pass: &'a Pass<'a>,
    room: &'b mut Room,
    /// Its points.
    points: Range<i64>,
    /// The point that the room starts with. On closed curves points before the first one and
    /// behind the last one are those of the turn before and of the next turn.
    base: i64,
}

/// All levels of a part.
#[inline(always)]
pub fn sweep(pass: &Pass<'_>, part: Part<'_>) {
    let Part {
        lines,
        mut x,
        mut step,
        blocks,
        rooms,
        ..
    } = part;
    let [room] = rooms else { return };
    let levels = pass.coefficients.len();
    let margin = ((levels + 1) * pass.u.reach()) as i64;
    for start in lines.clone().step_by(pass.tile) {
        let end = lines.end.min(start + pass.tile);
        let mut tile = Tile {
            pass,
            room: &mut *room,
            points: start as i64..end as i64,
            base: start as i64 - margin,
        };
        tile.load();
        let first = (start - lines.start) / BLOCK;
        let count = (end - start).div_ceil(BLOCK);
        tile.level(0, &mut []);
        for level in 1..=levels {
            tile.level(level, &mut blocks[level - 1][first..first + count]);
        }
        let to = start - lines.start..end - lines.start;
        store(&tile.room.front, margin as usize, &mut x, to.clone());
        store(&tile.room.step, margin as usize, &mut step, to);
    }
}

/// Copies the points of a tile, without its margin, to where they belong.
#[inline(always)]
fn store(from: &Points, margin: usize, to: &mut [&mut [f64]], points: Range<usize>) {
    for (from, to) in from.lanes().iter().zip(to) {
        to[points.clone()].copy_from_slice(&from[margin..margin + points.len()]);
    }
}

impl Tile<'_, '_> {
    /// Copies the tile with its margins.
    #[inline(always)]
    fn load(&mut self) {
        let Vectors { x, step } = self.pass.source;
        let end = self.points.end + self.points.start - self.base;
        let range = self.within(self.base..end);
        let base = self.base;
        for (points, first) in pieces(range, x.len() as i64, i64::MAX) {
            let local = (points.start - base) as usize..(points.end - base) as usize;
            let from = first..first + local.len();
            for (to, x) in self.room.front.lanes_mut().iter_mut().zip(x.lanes()) {
                to[local.clone()].copy_from_slice(&x[from.clone()]);
            }
            let lanes = step.iter().flat_map(|step| step.lanes());
            for (to, step) in self.room.step.lanes_mut().iter_mut().zip(lanes) {
                to[local.clone()].copy_from_slice(&step[from.clone()]);
            }
        }
    }

    /// The points of a range that there are.
    fn within(&self, range: Range<i64>) -> Range<i64> {
        if self.pass.u.is_cyclic() {
            return range;
        }
        range.start.max(0)..range.end.min(self.pass.u.rows() as i64)
    }

    /// The residual of a level, its norms (except of the first level, which are known), and the
    /// next level (except behind the last one).
    #[inline(always)]
    fn level(&mut self, level: usize, blocks: &mut [Block]) {
        let left = self.pass.coefficients.len() - level;
        let margin = (left * self.pass.u.reach()) as i64;
        let range = self.within(self.points.start - margin..self.points.end + margin);
        for (piece, row) in pieces(range, self.pass.u.rows() as i64, BLOCK as i64) {
            let inside = piece.start >= self.points.start && piece.end <= self.points.end;
            let index = (piece.start - self.points.start) / BLOCK as i64;
            let squares = self.piece(level, piece.clone(), row);
            if let Some(block) = blocks.get_mut(index as usize).filter(|_| inside) {
                *block = Block::of(row, &squares[..(piece.end - piece.start) as usize]);
            }
        }
        if left > 0 {
            std::mem::swap(&mut self.room.front, &mut self.room.back);
        }
    }

    /// Points that belong to consecutive rows of B, from `row` on: the squares of their residuals.
    #[inline(always)]
    fn piece(&mut self, level: usize, points: Range<i64>, row: usize) -> [f64; BLOCK] {
        let Self {
            pass, room, base, ..
        } = self;
        let local = (points.start - *base) as usize..(points.end - *base) as usize;
        let rows = row..row + local.len();
        let mut squares = [0.0; BLOCK];
        let Room { front, back, step } = &mut **room;
        // Nobody looks at what comes behind the last level.
        let coefficients = pass.coefficients.get(level).copied();
        let last = coefficients.is_none();
        for (c, (x, data)) in front.lanes().iter().zip(pass.data.lanes()).enumerate() {
            let step = step.lanes_mut().get_mut(c).filter(|_| !last);
            let lane = Lane {
                x,
                base: *base - (points.start - row as i64),
                data: &data[rows.clone()],
                own: &x[local.clone()],
                next: &mut back.lanes_mut()[c][local.clone()],
                step: step.map_or(&mut [], |step| &mut step[local.clone()]),
                squares: &mut squares[..local.len()],
            };
            let coefficients = coefficients.unwrap_or_default();
            fused::relax(pass.u, rows.clone(), coefficients, pass.scale, lane);
        }
        squares
    }
}

/// Cuts a range of points at the multiples of the period and of the length of blocks: each piece and
/// its first point within the period.
#[inline(always)]
fn pieces(
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
