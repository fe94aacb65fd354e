//! Sweeps: residual, update and errors of a level in one pass over memory.
//!
//! An iteration on long banded data does few operations on many numbers: a curve of n points in R^d
//! with B-splines of degree p takes about `2 d (p + 1) n` operations on `3 d n + (p + 1) n`
//! numbers, so that it takes as long as moving these numbers takes. The plain loop moves them three
//! times. A sweep computes for each block of points
//!
//! ```text
//! Δ = P − B X,   ‖Δ_i‖²,   X' = X + ω Δ
//! ```
//!
//! while they are in the nearest cache, reading `X`, `P` and `B` and writing `X'` once. `X'` is
//! another array than `X`, as the next block still needs the old values; it is the control points
//! of the next level, so that the loop is one step *ahead* of the level that is reported.
//!
//! # Bit for bit
//!
//! Every number is computed by the same operations in the same order as in the plain loop, errors
//! included, so that levels do not depend on the path, on the number of threads, on the instruction
//! set, or on how many levels were computed at once. No product is fused with a sum (no FMA),
//! whatever the instructions. The tests hold every sweep to the plain loop, to the last bit.
//!
//! # What can be swept
//!
//! Square banded matrices in all directions, at most three coordinates, no missing points and no
//! homogeneous coordinates; and a method whose step is a relaxation or a transform (`Relaxation`):
//! global, weighted, Chebyshev, transpose, direct.
//!
//! # Parts
//!
//! - `buffers`: the control points of two levels, and `pass`: what all threads of a pass share;
//! - `parts`: what a thread writes, and `workspace`: where it works;
//! - `fused`: the innermost loop, of all coordinates, over `vectors`;
//! - `curve` and `surface`: a level in one pass;
//! - `tiles`: several levels of a curve in one pass.

mod buffers;
mod curve;
mod fused;
mod parts;
mod pass;
mod surface;
#[cfg(test)]
mod tests;
mod tiles;
mod vectors;
mod workspace;

use std::sync::Arc;

use super::system::System;
use crate::data::blocks::{BLOCK, Block, Blocks};
use crate::data::points::Points;
use crate::geometry::norms::{FitError, Norms};
use crate::matrix::collocation::Collocation;
use crate::matrix::tensor::Tensor;
use crate::method::relaxation::{Relaxation, Step};
use buffers::{Returned, Vectors};
use parts::{LANES, Part};
use pass::{Pass, Way};
use workspace::Workspace;

pub use pass::LEVELS;

/// Fits of fewer points are swept by one thread: starting others would take longer than it saves.
const PARALLEL: usize = 100_000;

/// Curves of fewer points stay in the caches from level to level, so that several levels in a pass
/// gain nothing.
const TILED: usize = 32_768;

/// How the work of a pass is divided. It has no influence on any result, not even on the last bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The number of parts that threads can work on at the same time, at least 1.
    pub parts: usize,
    /// The number of levels computed in one pass: 1 to [`LEVELS`], of surfaces always 1.
    pub levels: usize,
    /// The number of points of a tile of `tiles`, a multiple of `BLOCK`.
    pub tile: usize,
}

impl Plan {
    /// The plan that is fastest, by what was measured: two parts for each thread, so that none
    /// waits long for the others, and several levels in a pass for curves that are longer than the
    /// caches.
    pub fn of(system: &System) -> Self {
        let problem = system.problem();
        let (points, is_curve) = (problem.grid().count(), problem.v().is_none());
        let threads = || rayon::current_num_threads();
        let tiled = is_curve && points >= TILED;
        Self {
            parts: if points >= PARALLEL { 2 * threads() } else { 1 },
            levels: if tiled { LEVELS } else { 1 },
            tile: 2 * BLOCK,
        }
    }
}

/// The error of a level in data units, and the length of its residual, up to a factor that is the
/// same for all levels.
pub type Measured = (FitError, f64);

/// An iteration by sweeps. It holds two sets of control points, n × d numbers each (and two steps
/// for methods with momentum), between which passes go to and fro.
#[derive(Clone, Debug)]
pub struct Sweep {
    relaxation: Relaxation,
    current: Vectors,
    /// The control points of the next level if the sweep is `ahead`, or their adjusting vectors if
    /// the method transforms all of them together; else the level from which the last pass began.
    spare: Vectors,
    returned: Returned,
    /// True if `spare` holds what the next step needs.
    ahead: bool,
    norms: Norms,
    layout: Blocks,
    /// The norms of the blocks of each level of a pass.
    blocks: Vec<Vec<Block>>,
    /// Working space of each part.
    workspaces: Vec<Workspace>,
    /// Scratch space of transforms.
    scratch: Vec<f64>,
    plan: Plan,
}

impl Sweep {
    /// Level 0, from given control points, and its error.
    ///
    /// # Errors
    ///
    /// The control points, if the problem or its method cannot be swept.
    pub fn start(
        system: &System,
        control_points: Arc<Points>,
    ) -> Result<(Self, Measured), Arc<Points>> {
        Self::with_plan(system, control_points, Plan::of(system))
    }

    /// Like [`Self::start`] with another plan than the fastest one, for tests and benches.
    ///
    /// # Errors
    ///
    /// The control points, if the problem or its method cannot be swept.
    pub fn with_plan(
        system: &System,
        control_points: Arc<Points>,
        plan: Plan,
    ) -> Result<(Self, Measured), Arc<Points>> {
        let problem = system.problem();
        let relaxation = problem.method().algorithm().relaxation(system.equations());
        let (Some(relaxation), true) = (relaxation, is_plain(system)) else {
            return Err(control_points);
        };
        let (data, grid) = (problem.data(), problem.grid());
        let zeros = || Points::zeros(data.dimension(), data.len());
        let step = || relaxation.has_momentum().then(zeros);
        let layout = Blocks::new(grid);
        let (lines, _) = layout.unit();
        let transformed = relaxation.is_transformed();
        let scratch = if transformed {
            system.equations().scratch()
        } else {
            0
        };
        let mut sweep = Self {
            relaxation,
            spare: Vectors {
                x: Arc::new(zeros()),
                step: step(),
            },
            current: Vectors {
                x: control_points,
                step: step(),
            },
            returned: Returned::default(),
            ahead: false,
            norms: Norms::new(problem, None),
            layout,
            blocks: vec![vec![Block::default(); layout.count()]],
            workspaces: Vec::new(),
            scratch: vec![0.0; scratch],
            plan: Plan {
                parts: plan.parts.clamp(1, grid.rows.div_ceil(lines)),
                levels: if transformed {
                    1
                } else {
                    plan.levels.clamp(1, LEVELS)
                },
                tile: plan.tile,
            },
        };
        let measured = sweep.look_ahead(system);
        Ok((sweep, measured))
    }

    /// The free control points of the current level.
    pub fn control_points(&self) -> &Arc<Points> {
        &self.current.x
    }

    /// Takes back control points of an earlier level that a reader has finished with, so that their
    /// memory is used again.
    pub fn take_back(&mut self, points: Arc<Points>) {
        self.returned.add(points);
    }

    /// The best number of levels for one pass.
    pub fn levels(&self) -> usize {
        self.plan.levels
    }

    /// Moves on to the next level and measures it. Usually this is one pass, which also computes
    /// the level after it.
    pub fn step(&mut self, system: &System) -> Measured {
        if !self.ahead {
            self.look_ahead(system);
        }
        if self.relaxation.is_transformed() {
            let residual = Arc::make_mut(&mut self.spare.x);
            system
                .equations()
                .transform_onto(residual, &self.current.x, &mut self.scratch);
        }
        std::mem::swap(&mut self.current, &mut self.spare);
        self.relaxation.advance();
        if self.relaxation.is_done_at_once() {
            self.run(system, &[Step::Keep], Way::Measure);
            self.ahead = false;
            self.measured(0)
        } else {
            self.look_ahead(system)
        }
    }

    /// Measures the current level, and writes the next one, or the residual that the method will
    /// transform, into `spare`.
    fn look_ahead(&mut self, system: &System) -> Measured {
        self.run(system, &[self.relaxation.step()], Way::Level);
        self.ahead = true;
        self.measured(0)
    }

    /// Moves on by `count` levels, at most [`Self::levels`], in one pass; [`Self::measured`] has
    /// their errors. The control points of the levels between are not kept.
    pub fn steps(&mut self, system: &System, count: usize) {
        let mut steps = [Step::default(); LEVELS];
        for step in &mut steps[..count] {
            *step = self.relaxation.step();
            self.relaxation.advance();
        }
        // The levels between are not read: buffers that readers have given back can be freed.
        self.returned = Returned::default();
        self.run(system, &steps[..count], Way::Tiles);
        std::mem::swap(&mut self.current, &mut self.spare);
        self.ahead = false;
    }

    /// Goes back to the level from which the last pass of `passed` levels began, and takes `count`
    /// of them instead: the fit has ended between.
    pub fn retake(&mut self, system: &System, passed: usize, count: usize) {
        std::mem::swap(&mut self.current, &mut self.spare);
        self.relaxation.go_back(passed);
        self.steps(system, count);
    }

    /// The error of a level of the last pass, where index 0 is its first one.
    pub fn measured(&self, index: usize) -> Measured {
        let total = Block::total(&self.blocks[index]);
        (self.norms.error_of(&total), total.squares.sqrt())
    }

    /// A pass from the current level to the spare one, divided among the threads.
    fn run(&mut self, system: &System, steps: &[Step], way: Way) {
        let Some(tensor) = system.collocation().tensor() else {
            return;
        };
        let Collocation::Banded(u) = &tensor.u else {
            return;
        };
        let v = tensor.v.as_ref().and_then(Collocation::as_banded);
        let pass = Pass {
            u,
            v,
            data: system.problem().target(),
            source: &self.current,
            steps,
            scale: self.norms.scale(),
            layout: self.layout,
            tile: self.plan.tile,
            way,
        };
        self.workspaces
            .resize_with(self.plan.parts, Workspace::default);
        let workspaces = self.workspaces.iter_mut();
        workspaces.for_each(|workspace| workspace.prepare(&pass, self.plan.levels));
        let blocks = &mut self.blocks;
        blocks.resize_with(blocks.len().max(steps.len()), || {
            vec![Block::default(); self.layout.count()]
        });
        let part = Part::whole(
            &pass,
            (&mut self.spare, &mut self.returned),
            blocks,
            &mut self.workspaces,
        );
        part.divide(&|part: Part| match pass.data.dimension() {
            1 => sweep::<1>(&pass, part),
            2 => sweep::<2>(&pass, part),
            _ => sweep::<LANES>(&pass, part),
        });
    }
}

/// The work of one thread, for points with D coordinates.
fn sweep<const D: usize>(pass: &Pass<'_>, part: Part<'_>) {
    match pass.v {
        Some(v) => surface::sweep::<D>(pass, v, part),
        None if pass.way == Way::Tiles => tiles::sweep::<D>(pass, part),
        None => curve::sweep::<D>(pass, part),
    }
}

/// Returns true if all points count alike, residuals are distances, and all matrices are square and
/// banded.
fn is_plain(system: &System) -> bool {
    let problem = system.problem();
    let banded = |matrix: &Collocation| {
        matches!(matrix, Collocation::Banded(_)) && matrix.rows() == matrix.columns()
    };
    let square = |tensor: &Tensor| tensor.directions().all(banded);
    !problem.is_homogeneous()
        && problem.missing().is_none()
        && problem.data().dimension() <= LANES
        && system.collocation().tensor().is_some_and(square)
}
