//! Surfaces: knot lines are inserted in the direction that gains more.
//!
//! The levels are those of curves: growth from p + 1 × q + 1 control points, then redistribution and removal. A knot of
//! one direction is a line of control points of the other one, so both share the tolerance, and each has its own
//! density of knots.
//!
//! - [`schedule`]: the choice of the next level; [`search`]: its numbers of control points; [`attempt`]:
//!   redistributions of a number of them.
//! - [`Data`]: the interface of the schedule to the data. [`grid`]: a grid of points, which is fitted one direction
//!   after the other; [`scattered`]: points without order, whose matrix is that of [`rows`], by conjugate [`gradients`]
//!   of the [`normal`] equations.
//! - [`sections`]: points between those of sections.
//! - [`correction`]: parameters of scattered points that follow a surface near them.
//! - [`lines`]: the lines of grids as curves in many dimensions; [`transfer`]: the start of a surface over other knots.
//!
//! # Guarantees
//!
//! - Levels are pure functions of data and options, the same to the last bit, and are computed on demand.
//! - No level has more control points in a direction than allowed (but p + 1 at least), nor more
//!   than data.
//! - The last level is within the tolerance if any was, with the fewest control points found.

mod attempt;
mod correction;
mod gradients;
pub(crate) mod grid;
mod lines;
mod normal;
mod rows;
pub(crate) mod scattered;
pub(crate) mod schedule;
mod search;
pub(crate) mod sections;
mod transfer;

use std::fmt::Debug;
use std::sync::Arc;

use super::Options;
use super::breaks::Breaks;
use super::levels::Level;
use super::monitor::{Monitor, needed, span_maxima};
use crate::data::distances::Distances;
use crate::data::points::Points;

pub(crate) use grid::GridData;
pub(crate) use normal::MOST_FACTOR;
pub(crate) use scattered::ScatteredData;
pub(crate) use schedule::SurfaceSchedule;

/// The parameters of the data in u and in v.
pub(crate) type Parameters = [Arc<Vec<f64>>; 2];

/// The interface of the schedule to the data.
pub(crate) trait Data: Debug + Send + Sync {
    /// The parameters of a direction, each once, increasing.
    fn parameters(&self, axis: usize) -> &[f64];

    /// The part of the tolerance that each direction may leave.
    fn share(&self) -> f64;

    /// Returns true if there are enough data for this many control points.
    fn allows(&self, counts: [usize; 2]) -> bool;

    /// The control points nearest to the data by the sum of squares, if the data determine them, and the residual of
    /// each direction. They may depend on the initial surface.
    fn nearest(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest>;

    /// The same without a limit of time, where as many control points as data must lead to all of them.
    fn nearest_of_all(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest> {
        self.nearest(lines, from)
    }

    /// The distances of the surface of some control points from the data.
    fn distances(&self, lines: &[Breaks; 2], control_points: &Points) -> Distances;

    /// The direction in which more knots gain more, for these new knots of each.
    fn prefers(&self, fit: &Fit, finer: &[Breaks; 2]) -> usize;

    /// The same data with parameters that follow a surface over the same knots, if they can, and these in the order of the
    /// data.
    fn corrected(&self, _level: &Level<2>) -> Option<(Box<dyn Data>, Parameters)> {
        None
    }

    /// Returns true if something other than the data keeps the surface away from them, whatever the number of control
    /// points.
    fn has_floor(&self) -> bool {
        false
    }

    /// The number of fits with fewer knot lines that are tried after all others.
    fn prunings(&self) -> usize {
        0
    }

    /// The same data for surfaces that need not be determined, if even that of the fewest control points is not.
    fn undetermined(&self, _options: &Options<2>) -> Option<Box<dyn Data>> {
        None
    }
}

/// A least-squares surface.
#[derive(Debug)]
pub(crate) struct Nearest {
    /// The control points, row by row.
    pub control_points: Points,
    /// The distances from the data, in their order.
    pub distances: Distances,
    /// For each direction, the largest residual at each of its parameters.
    pub left: [Vec<f64>; 2],
}

/// A least-squares surface with its distances.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// The surface.
    pub level: Arc<Level<2>>,
    /// For each direction, the largest residual at each of its parameters.
    pub left: Arc<[Vec<f64>; 2]>,
}

impl Fit {
    /// A least-squares surface over some knots, if its distances are finite.
    fn of(lines: [Breaks; 2], parameters: &Parameters, nearest: Nearest) -> Option<Self> {
        let is_finite = nearest.distances.max.is_finite();
        is_finite.then(|| Self {
            level: Arc::new(Level {
                lines,
                control_points: nearest.control_points,
                distances: nearest.distances,
                parameters: parameters.clone(),
            }),
            left: Arc::new(nearest.left),
        })
    }

    /// The knot density of each direction.
    fn monitors(&self, data: &dyn Data, damping: f64) -> [Monitor; 2] {
        [0, 1].map(|axis| {
            let line = &self.level.lines[axis];
            let starts = line.starts(data.parameters(axis));
            Monitor::new(line, &starts, &self.left[axis], damping)
        })
    }

    /// The number of control points that would suffice if each span of a direction were divided by itself.
    fn asked(&self, data: &dyn Data, tolerance: f64) -> [usize; 2] {
        [0, 1].map(|axis| {
            let line = &self.level.lines[axis];
            let starts = line.starts(data.parameters(axis));
            let maxima = span_maxima(&starts, &self.left[axis]);
            needed(line, &maxima, data.share() * tolerance)
        })
    }
}
