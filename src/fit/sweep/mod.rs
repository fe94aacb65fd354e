//! Sweeps: residual, update and errors of a level in one pass over memory.
//!
//! An iteration on long banded data does few operations on many numbers, so that it takes as long
//! as moving these numbers takes. The plain loop moves them three times. A sweep computes for each
//! block of points `Δ = P − B X`, its norms and `X' = X + ω Δ` while they are in the nearest cache,
//! reading `X`, `P` and `B` and writing `X'` once. `X'` is another array than `X`, as the next
//! block still needs the old values; it is the next level's control points, one step *ahead*.
//!
//! Every number is computed by the same operations in the same order as in the plain loop, errors
//! included, so that levels do not depend on the path, on the number of threads, or on how many
//! levels were computed at once. No product is fused with a sum, with whatever instructions.
//!
//! - [`buffers`]: the control points of two levels, and [`pass`]: what all threads of a pass share;
//! - [`parts`]: what a thread writes, and [`room`]: where it works;
//! - [`fused`]: the innermost loop, of all coordinates, over [`vectors`];
//! - [`curve`] and [`surface`]: a level in one pass;
//! - [`tiles`]: several levels of a curve in one pass.

mod buffers;
mod curve;
mod fused;
mod parts;
mod pass;
mod room;
mod surface;
#[cfg(test)]
mod tests;
mod tiles;
mod vectors;

use std::sync::Arc;

use super::blocks::{BLOCK, Block, Blocks};
use super::collocation::Collocation;
use super::method::relaxation::{Relaxation, Step};
use super::norms::{FitError, Norms};
use super::points::Points;
use super::system::System;
use buffers::{Returned, Vectors};
use parts::{LANES, Part};
use pass::{Pass, Way};
use room::Room;

pub use pass::LEVELS;

/// Below so many points more threads cost more than they save.
const PARALLEL: usize = 100_000;

/// Curves of fewer points stay in the caches from level to level.
const TILED: usize = 32_768;

/// How the work is divided; of no influence on any result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Parts that threads can work on at the same time.
    pub parts: usize,
    /// Levels in one pass.
    pub levels: usize,
    /// Points of a tile: whole blocks.
    pub tile: usize,
}

impl Plan {
    /// The plan that suits a problem best.
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

/// The error of a level, and the length of its residual.
pub type Measured = (FitError, f64);

/// An iteration by sweeps.
#[derive(Debug)]
pub struct Sweep {
    relaxation: Relaxation,
    current: Vectors,
    /// The next level if it is `ahead`, or the adjusting vectors where all are transformed together; else
    /// the level that the last pass began with.
    spare: Vectors,
    returned: Returned,
    ahead: bool,
    norms: Norms,
    layout: Blocks,
    /// Of each level of a pass.
    blocks: Vec<Vec<Block>>,
    rooms: Vec<Room>,
    /// Of transforms.
    scratch: Vec<f64>,
    plan: Plan,
}

impl Sweep {
    /// Level 0, from given control points, and its error, if there are sweeps for this problem.
    pub fn start(
        system: &System,
        control_points: Arc<Points>,
    ) -> Result<(Self, Measured), Arc<Points>> {
        Self::with_plan(system, control_points, Plan::of(system))
    }

    /// The same with a plan of one's own. Gives the control points back if there are no sweeps.
    pub fn with_plan(
        system: &System,
        control_points: Arc<Points>,
        plan: Plan,
    ) -> Result<(Self, Measured), Arc<Points>> {
        let problem = system.problem();
        let relaxation = problem.method().scheme().relaxation(system.equations());
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
            rooms: Vec::new(),
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

    /// The control points.
    pub fn control_points(&self) -> &Arc<Points> {
        &self.current.x
    }

    /// Takes back points of an earlier level.
    pub fn take_back(&mut self, points: Arc<Points>) {
        self.returned.add(points);
    }

    /// Levels that are best computed in one pass.
    pub fn levels(&self) -> usize {
        self.plan.levels
    }

    /// Moves on to the next level.
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

    /// Measures the current level and computes the next one, or the residual.
    fn look_ahead(&mut self, system: &System) -> Measured {
        self.run(system, &[self.relaxation.step()], Way::Level);
        self.ahead = true;
        self.measured(0)
    }

    /// Moves on by several levels, at most [`Self::levels`], in one pass; the errors are those of
    /// [`Self::measured`].
    pub fn steps(&mut self, system: &System, count: usize) {
        let mut steps = [Step::default(); LEVELS];
        for step in &mut steps[..count] {
            *step = self.relaxation.step();
            self.relaxation.advance();
        }
        // Nobody reads the levels between: what readers have given back is not needed any more.
        self.returned = Returned::default();
        self.run(system, &steps[..count], Way::Tiles);
        std::mem::swap(&mut self.current, &mut self.spare);
        self.ahead = false;
    }

    /// Goes back to the level in which the last pass, of so many levels, began, and takes fewer.
    pub fn retake(&mut self, system: &System, passed: usize, count: usize) {
        std::mem::swap(&mut self.current, &mut self.spare);
        self.relaxation.go_back(passed);
        self.steps(system, count);
    }

    /// The error of a level of the last pass.
    pub fn measured(&self, index: usize) -> Measured {
        let total = Block::total(&self.blocks[index]);
        (self.norms.error_of(&total), total.squares.sqrt())
    }

    /// A pass from the current level to the spare one.
    fn run(&mut self, system: &System, steps: &[Step], way: Way) {
        let tensor = system.collocation();
        let Collocation::Banded(u) = &tensor.u else {
            return;
        };
        let v = tensor.v.as_ref().and_then(Collocation::as_banded);
        let pass = Pass {
            u,
            v,
            data: system.problem().data(),
            source: &self.current,
            steps,
            scale: self.norms.scale(),
            layout: self.layout,
            tile: self.plan.tile,
            way,
        };
        self.rooms.resize_with(self.plan.parts, Room::default);
        let rooms = self.rooms.iter_mut();
        rooms.for_each(|room| room.prepare(&pass, self.plan.levels));
        let blocks = &mut self.blocks;
        blocks.resize_with(blocks.len().max(steps.len()), || {
            vec![Block::default(); self.layout.count()]
        });
        let part = Part::whole(
            &pass,
            (&mut self.spare, &mut self.returned),
            blocks,
            &mut self.rooms,
        );
        part.divide(&|part: Part| match pass.data.dimension() {
            1 => sweep::<1>(&pass, part),
            2 => sweep::<2>(&pass, part),
            _ => sweep::<LANES>(&pass, part),
        });
    }
}

/// The work of one thread, in D dimensions.
fn sweep<const D: usize>(pass: &Pass<'_>, part: Part<'_>) {
    match pass.v {
        Some(v) => surface::sweep::<D>(pass, v, part),
        None if pass.way == Way::Tiles => tiles::sweep::<D>(pass, part),
        None => curve::sweep::<D>(pass, part),
    }
}

/// Whether all points count alike and all matrices are banded.
fn is_plain(system: &System) -> bool {
    let problem = system.problem();
    let banded = |matrix: &Collocation| {
        matches!(matrix, Collocation::Banded(_)) && matrix.rows() == matrix.columns()
    };
    !problem.is_homogeneous()
        && problem.missing().is_none()
        && problem.data().dimension() <= LANES
        && system.collocation().directions().all(banded)
}
