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
//! - [`relaxation`]: what global, weighted, Chebyshev-accelerated, direct and transpose PIA do with Δ;
//! - [`parts`]: what a thread writes;
//! - [`fused`]: the innermost loop, of all coordinates;
//! - [`vectors`]: what it runs over;
//! - [`curve`] and [`surface`]: a level in one pass;
//! - [`tiles`]: several levels of a curve in one pass.

pub mod curve;
pub mod fused;
pub mod parts;
pub mod relaxation;
pub mod surface;
#[cfg(test)]
mod tests;
pub mod tiles;
pub mod vectors;

use std::sync::Arc;

use super::blocks::{BLOCK, Block, Blocks};
use super::collocation::Collocation;
use super::linear::banded::Banded;
use super::norms::{FitError, Norms};
use super::points::Points;
use super::system::System;
use fused::Update;
use parts::{LANES, Part};
use relaxation::{Relaxation, Step};
use tiles::Room;

/// Levels that are computed in one pass, at most: more would not be limited by memory any more.
pub const LEVELS: usize = 8;

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

/// What an iteration carries from level to level.
#[derive(Debug)]
pub struct Vectors {
    /// The control points, which readers may share.
    pub x: Arc<Points>,
    /// The last step, of methods with momentum.
    pub step: Option<Points>,
}

impl Vectors {
    /// Control points that nobody else sees, to be overwritten, and the steps: if there are readers of
    /// these points, they keep them, and those that were given back are taken, or new ones.
    fn writable(&mut self, returned: &mut Returned) -> (&mut Points, Option<&mut Points>) {
        if Arc::get_mut(&mut self.x).is_none() {
            let new = || Points::zeros(self.x.dimension(), self.x.len());
            self.x = Arc::new(returned.take().unwrap_or_else(new));
        }
        (Arc::make_mut(&mut self.x), self.step.as_mut())
    }
}

/// Points of earlier levels, to be overwritten: memory that has been used before is quicker than what
/// comes from the system. Some may still be on their way to readers.
#[derive(Debug, Default)]
pub struct Returned(Vec<Arc<Points>>);

impl Returned {
    /// As many as slow readers are likely to have.
    const MOST: usize = 4;

    fn add(&mut self, points: Arc<Points>) {
        if self.0.len() < Self::MOST {
            self.0.push(points);
        }
    }

    /// Points that nobody else has any more. If there are several, only one is kept.
    fn take(&mut self) -> Option<Points> {
        let mut free = None;
        for points in std::mem::take(&mut self.0) {
            match Arc::try_unwrap(points) {
                Ok(points) => free = Some(points),
                Err(points) => self.0.push(points),
            }
        }
        free
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

/// How far a pass goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The level is measured, and nothing written.
    Measure,
    /// To the next level, or to the residual.
    Level,
    /// Through several levels, tile by tile.
    Tiles,
}

/// What all parts of a pass share.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
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
        let relaxation = Relaxation::new(system);
        let (Some(relaxation), true) = (relaxation, is_plain(system)) else {
            return Err(control_points);
        };
        let (data, grid) = (problem.data(), problem.grid());
        let zeros = || Points::zeros(data.dimension(), data.len());
        let step = || relaxation.has_momentum().then(zeros);
        let layout = Blocks::new(grid);
        let (lines, _) = layout.unit();
        let transformed = relaxation.is_transformed();
        let scratch = if transformed { system.scratch() } else { 0 };
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
            system.transform_onto(residual, &self.current.x, &mut self.scratch);
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
            1 => pass.sweep::<1>(part),
            2 => pass.sweep::<2>(part),
            _ => pass.sweep::<LANES>(part),
        });
    }
}

impl<'a> Pass<'a> {
    /// The work of one thread, in D dimensions.
    fn sweep<const D: usize>(&self, part: Part<'_>) {
        match self.v {
            Some(v) => surface::sweep::<D>(self, v, part),
            None if self.way == Way::Tiles => tiles::sweep::<D>(self, part),
            None => curve::sweep::<D>(self, part),
        }
    }

    /// The update of a level, with the matrix along a line; behind the last level nothing moves.
    fn update(&self, matrix: &'a Banded, level: usize) -> Update<'a> {
        Update {
            matrix,
            step: self.steps.get(level).copied().unwrap_or_default(),
            scale: self.scale,
        }
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
