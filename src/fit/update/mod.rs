//! The updates `X ← X + U Δ`: one file for each way in which a method moves its control points.
//!
//! - [`linear`]: U is a fixed linear map;
//! - [`chebyshev`]: momentum over such steps;
//! - [`selected`]: only some control points move, and only what they touch is computed;
//! - [`convex`]: steps that keep the turns of the control polygon;
//! - [`least_squares`]: fewer control points than data.

pub mod chebyshev;
pub mod convex;
pub mod least_squares;
pub mod linear;
pub mod selected;

use std::fmt::Debug;
use std::sync::Arc;

use super::method::{Method, Start};
use super::missing::Missing;
use super::points::Points;
use super::system::System;

/// Why a fit cannot go on although its tolerance is not reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stall {
    /// Convex: any step would turn the control polygon the other way.
    Convexity,
    /// Extended: the error is zero but for rounding, as nothing is left of the transform's power.
    Nilpotent,
    /// Direct: what is left is rounding.
    Rounding,
    /// Least squares: the residual grows, because the step is too long.
    Diverging,
}

impl Stall {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Convexity => "convexity",
            Self::Nilpotent => "nilpotent",
            Self::Rounding => "rounding",
            Self::Diverging => "diverging",
        }
    }
}

/// What an update has changed.
#[derive(Debug)]
pub enum Change {
    /// Any control point: the residual is to be computed.
    All {
        /// How many control points moved.
        moved: usize,
    },
    /// Any control point; the residual is up to date.
    Residual {
        /// How many control points moved.
        moved: usize,
    },
    /// Some; the residual is up to date, and these points of it have changed.
    Some {
        /// How many control points moved.
        moved: usize,
    },
}

/// What an update works on.
#[derive(Debug)]
pub struct State {
    /// The free control points X.
    pub control_points: Points,
    /// The residual Δ = P − B X.
    pub residual: Points,
    /// Room for one coordinate.
    pub scratch: Vec<f64>,
    /// The points whose residual an update has changed, increasing.
    pub changed: Vec<usize>,
}

/// A way to move control points.
pub trait Update: Debug + Send {
    /// Moves the control points once.
    fn update(&mut self, system: &System, state: &mut State) -> Change;

    /// Told when the residual is known, before the first update and after each.
    fn measured(&mut self, _system: &System, _state: &mut State) {}

    /// The control points that the last update moved, if it moved only some.
    fn moved(&self) -> Option<&[usize]> {
        None
    }

    /// The gradient of a least-squares fit, relative to that of level 0.
    fn gradient(&self) -> Option<f64> {
        None
    }

    /// Whether another update would change nothing, and why.
    fn stalled(&self) -> Option<Stall> {
        None
    }
}

/// The update of a problem's method.
pub fn new(system: &System) -> Box<dyn Update> {
    let problem = system.problem();
    match problem.method() {
        Method::Global
        | Method::Weighted { .. }
        | Method::Extended { .. }
        | Method::Transpose
        | Method::Direct => Box::new(linear::Linear::new(system)),
        Method::Chebyshev => Box::new(chebyshev::Chebyshev::new(system)),
        Method::Local { row_by_row } => Box::new(selected::Selected::local(system, row_by_row)),
        Method::Adaptive { threshold } => Box::new(selected::Selected::adaptive(system, threshold)),
        Method::Convex => Box::new(convex::Convex::new(problem)),
        Method::LeastSquares(least_squares) => Box::new(least_squares::LeastSquaresUpdate::new(
            system,
            least_squares.variant,
        )),
    }
}

/// Which data points count for the error of a fit: the adjusted ones of a local fit, else all that
/// there are.
pub fn counted(system: &System) -> Option<Vec<bool>> {
    let problem = system.problem();
    match problem.method() {
        Method::Local { .. } => {
            let selected = problem.selected();
            let mut adjusted = vec![selected.is_none(); problem.grid().count()];
            for &index in selected.unwrap_or_default() {
                adjusted[index] = true;
            }
            Some(adjusted)
        }
        _ => problem.missing().map(Missing::present),
    }
}

/// The control points of level 0: given ones, or those of the method.
pub fn start(system: &System) -> Arc<Points> {
    let problem = system.problem();
    let data = problem.data();
    if let Some(start) = problem.start() {
        return Arc::clone(start);
    }
    match problem.method() {
        Method::LeastSquares(_) => Arc::new(least_squares::start(problem)),
        Method::Extended {
            start: Start::Transformed,
        } => {
            let mut control_points = Points::clone(data);
            system.transform_all(&mut control_points, &mut vec![0.0; system.scratch()]);
            Arc::new(control_points)
        }
        _ => Arc::clone(data),
    }
}
