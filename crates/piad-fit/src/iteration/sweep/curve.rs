//! One level of a curve in one pass.
//!
//! Block by block of 1024 points: the rows of B that belong to a block read `X` in the block and a
//! few points on both sides of it, so that each number comes from memory once. Output is not read
//! again in the pass.

use super::buffers::Vectors;
use super::fused::Rows;
use super::parts::{Part, columns, ranges};
use super::pass::{Pass, Way};
use crate::data::blocks::{BLOCK, Block, Squares};

/// For each block of the part: `Δ = P − B X`, its norms, and the points X' of the next level. With
/// momentum the last steps are copied first, as the innermost loop overwrites them by the next
/// ones.
pub(super) fn sweep<const D: usize>(pass: &Pass<'_>, mut part: Part<'_>) {
    let Vectors { x, step } = pass.source;
    let [workspace] = part.workspaces else { return };
    let first = part.lines.start;
    let mut start = first;
    let mut squares = Squares::new();
    for block in part.blocks[0].iter_mut() {
        let end = part.lines.end.min(start + BLOCK);
        let (from, to) = (start..end, start - first..end - first);
        let squares = squares.first(end - start);
        let mut next_step = ranges::<D>(&mut part.step, to.clone());
        if let Some(step) = step {
            let last = columns::<D>(step, from.clone());
            let steps = next_step.iter_mut().zip(last);
            steps.for_each(|(next, last)| next.copy_from_slice(last));
        }
        let next = match pass.way {
            Way::Measure => ranges(workspace.back.lanes_mut(), 0..end - start),
            _ => ranges(&mut part.x, to),
        };
        let mut rows = Rows {
            x: columns(x, 0..x.len()),
            base: 0,
            data: columns(pass.data, from.clone()),
            own: columns(x, from.clone()),
            next,
            step: next_step,
            squares,
            place: 0,
        };
        let sums = pass.update(pass.u, 0).apply(from, &mut rows);
        *block = Block::new(start, squares, &sums);
        start = end;
    }
}
