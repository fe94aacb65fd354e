//! The output of a pass, divided among threads.
//!
//! A part is consecutive lines of the grid (of a curve, points) with the blocks of their errors.
//! Parts are halved until there is one for each workspace, so that all borrow disjoint slices of the
//! same arrays, without locks. They begin and end with whole blocks, so that sums do not depend on
//! the division:
//!
//! ```text
//! points    |  block  |  block  |  block  |  block  |  block  |
//! 2 parts   |       first       |           second            |
//! ```

use std::ops::Range;

use super::buffers::{Returned, Vectors};
use super::pass::{LEVELS, Pass, Way};
use super::workspace::Workspace;
use crate::data::blocks::Block;
use crate::data::points::Points;

/// The most coordinates d of a point that can be swept.
pub(super) const LANES: usize = 3;

/// Consecutive lines of the next level and the norms of their points. The slices of points are
/// empty if the pass only measures, and so are those of coordinates, steps and levels that do not
/// exist.
pub(super) struct Part<'a> {
    /// The lines, by index: rows of the grid, which of a curve are its points.
    pub lines: Range<usize>,
    /// The control points X' of the next level, one slice for each coordinate.
    pub x: [&'a mut [f64]; LANES],
    /// The steps d that lead there.
    pub step: [&'a mut [f64]; LANES],
    /// The blocks of each level of the pass.
    pub blocks: [&'a mut [Block]; LEVELS],
    /// The working space of each part that this one is to be divided into.
    pub workspaces: &'a mut [Workspace],
    /// The points of a line.
    columns: usize,
    /// The numbers of whole lines that make whole blocks.
    unit: (usize, usize),
}

impl<'a> Part<'a> {
    /// All lines of the grid, to be written to `target`.
    pub(super) fn whole(
        pass: &Pass<'_>,
        (target, returned): (&'a mut Vectors, &mut Returned),
        blocks: &'a mut [Vec<Block>],
        workspaces: &'a mut [Workspace],
    ) -> Self {
        let columns = pass.v.map_or(1, |v| v.columns());
        let mut blocks = blocks.iter_mut();
        let target = (pass.way != Way::Measure).then(|| target.writable(returned));
        let (x, step) = target.unzip();
        let lanes = |points: Option<&'a mut Points>| {
            let lanes = points.map(Points::lanes_mut);
            lanes.unwrap_or_default().iter_mut()
        };
        let (mut x, mut step) = (lanes(x), lanes(step.flatten()));
        Self {
            lines: 0..pass.data.len() / columns,
            x: std::array::from_fn(|_| slice(x.next())),
            step: std::array::from_fn(|_| slice(step.next())),
            blocks: std::array::from_fn(|_| slice(blocks.next())),
            workspaces,
            columns,
            unit: pass.layout.unit(),
        }
    }

    /// Divides the part into one for each workspace, and does the work of all of them, on as many
    /// threads as the pool has.
    pub(super) fn divide(self, work: &(impl Fn(Part<'_>) + Sync)) {
        if self.workspaces.len() <= 1 {
            return work(self);
        }
        let (left, right) = self.halves();
        rayon::join(|| left.divide(work), || right.divide(work));
    }

    /// Two parts of about as many lines, with half of the workspaces each.
    fn halves(self) -> (Self, Self) {
        let (lines, parts) = self.unit;
        let half = self.workspaces.len() / 2;
        let units = self.lines.len().div_ceil(lines) * half / self.workspaces.len();
        let middle = (self.lines.start + units * lines).min(self.lines.end);
        let points = (middle - self.lines.start) * self.columns;
        let (x, other_x) = split(self.x, points);
        let (step, other_step) = split(self.step, points);
        let (blocks, other_blocks) = split(self.blocks, units * parts);
        let (workspaces, other_rooms) = self.workspaces.split_at_mut(half);
        let left = Self {
            lines: self.lines.start..middle,
            x,
            step,
            blocks,
            workspaces,
            ..self
        };
        let right = Self {
            lines: middle..self.lines.end,
            x: other_x,
            step: other_step,
            blocks: other_blocks,
            workspaces: other_rooms,
            ..left
        };
        (left, right)
    }
}

/// The same range of each of the first D coordinates.
pub(super) fn columns<const D: usize>(points: &Points, range: Range<usize>) -> [&[f64]; D] {
    std::array::from_fn(|c| &points.lane(c)[range.clone()])
}

/// The same range of each of the first D coordinates, to be written; empty where there is no such
/// range.
pub(super) fn ranges<const D: usize>(
    lanes: &mut [impl AsMut<[f64]>],
    range: Range<usize>,
) -> [&mut [f64]; D] {
    let mut lanes = lanes.iter_mut();
    std::array::from_fn(|_| {
        let lane = lanes.next().map(AsMut::as_mut);
        lane.and_then(|lane: &mut [f64]| lane.get_mut(range.clone()))
            .unwrap_or_default()
    })
}

/// The values, or an empty slice if there are none.
fn slice<T>(values: Option<&mut (impl AsMut<[T]> + ?Sized)>) -> &mut [T] {
    values.map(AsMut::as_mut).unwrap_or_default()
}

/// Splits all slices at the same place; empty ones give two empty ones.
fn split<T, const N: usize>(slices: [&mut [T]; N], at: usize) -> ([&mut [T]; N], [&mut [T]; N]) {
    let mut behind = slices.map(Some);
    let before = std::array::from_fn(|k| {
        let slice = behind[k].take().unwrap_or_default();
        let (front, back) = slice.split_at_mut(at.min(slice.len()));
        behind[k] = Some(back);
        front
    });
    (before, behind.map(Option::unwrap_or_default))
}
