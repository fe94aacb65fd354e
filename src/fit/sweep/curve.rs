//! One level of a curve in one pass.

use super::fused::{self, Lane};
use super::parts::Part;
use super::{Pass, Vectors};
use crate::fit::blocks::{BLOCK, Block};

/// For each block: `Δ = P − B X`, its norms, and the next level.
#[inline(always)]
pub fn sweep(pass: &Pass<'_>, part: Part<'_>) {
    let Vectors { x, step } = pass.source;
    let [coefficients] = *pass.coefficients else {
        return;
    };
    let first = part.lines.start;
    let mut start = first;
    for block in part.blocks[0].iter_mut() {
        let end = part.lines.end.min(start + BLOCK);
        let (from, to) = (start..end, start - first..end - first);
        let mut squares = [0.0; BLOCK];
        let squares = &mut squares[..end - start];
        for (c, (x, data)) in x.lanes().iter().zip(pass.data.lanes()).enumerate() {
            let next_step = part.step[c].get_mut(to.clone()).unwrap_or_default();
            if let Some(step) = step {
                next_step.copy_from_slice(&step.lanes()[c][from.clone()]);
            }
            let lane = Lane {
                x,
                base: 0,
                data: &data[from.clone()],
                own: &x[from.clone()],
                next: &mut part.x[c][to.clone()],
                step: next_step,
                squares,
            };
            fused::relax(pass.u, from.clone(), coefficients, pass.scale, lane);
        }
        *block = Block::of(start, squares);
        start = end;
    }
}
