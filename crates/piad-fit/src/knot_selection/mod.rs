//! The fewest control points for a tolerance.
//!
//! This is what users of CAD systems mean by fitting: the fewest control points with which the largest distance is
//! within a tolerance. No rule gives them at once, so the fit gets there by *levels*, each of which is a whole B-spline
//! through the ends of the data:
//!
//! 1. **Growth.** From p + 1 control points on: steps of conjugate gradients towards the least-squares fit ([`steps`]);
//!    then a knot in the middle of every span whose largest distance is above the tolerance ([`growth`]). Insertion is
//!    exact ([`insertion`]): the fit continues from the same curve, until it is within the tolerance.
//! 2. **Redistribution and removal.** The distances of the spans are a density of knots ([`monitor`]). Knots at equal
//!    shares of it make these distances equal, so that far fewer suffice: the number of control points falls as long as
//!    some round of redistribution stays within the tolerance ([`schedule`]).
//! 3. **The last control point.** Least squares make the sum of squares small and not the largest distance. Where one
//!    control point fewer comes close to the tolerance, weights that grow with the distances (Lawson) often reach it
//!    ([`minimax`]).
//! 4. **Single knots.** Where there are hardly more data than control points, distances do not show where knots are
//!    needed. There the knots whose removal changes the curve least are removed one by one, as long as the fit without
//!    them is within the tolerance ([`pruning`]).
//! 5. **Positions of knots.** Where there are few knots, two neighbours become one if the knots, after moving to better
//!    positions ([`knot_step`]), keep the tolerance ([`merging`]).
//!
//! A fit that is within the tolerance but deviates from its data between neighbours continues with points there
//! ([`guide`]).
//!
//! Of polylines the points along their edges are data, too ([`edges`]). Between corners pieces of a curve do this by themselves ([`clamped_breaks`]).
//!
//! Parameters stay where they are, or move to the foot points of the data if requested (Hoschek; [`correction`]).
//!
//! Surfaces do the same with whole knot lines ([`surface`]), and have the same [`levels`]. For a given number of control
//! points the knots converge to the best ones ([`adaptive`]).
//!
//! The minimization is behind [`equations::Minimum`]: it handles constraints and fairness, and the schedule handles
//! knots.
//!
//! # Guarantees
//!
//! - Levels are pure functions of data, parameters and options, the same to the last bit.
//! - The first level has p + 1 control points (of fewer data than that one for each datum raised to
//!   the degree), and the last one is within the tolerance if any was, with the fewest control
//!   points found.
//! - Insertion does not change the curve, but for rounding. The largest distance never rises while the knots stay, nor
//!   in redistribution while their number stays.
//! - A level costs O(n p²) for n data, and their number does not grow with n.
//!
//! Sources: de Boor, *Good approximation by splines with variable knots* (1973); Deng, Lin,
//! *Progressive and iterative approximation for least squares B-spline curve and surface fitting*,
//! CAD 47 (2014), section 4; Hoschek, *Intrinsic parametrization for approximation*, CAGD 5 (1988);
//! Lawson, *Contributions to the theory of linear least maximum approximation* (1961); Cohen, Lyche,
//! Riesenfeld, *Discrete B-splines and subdivision techniques* (1980); Lyche, Mørken, *Knot removal for
//! parametric B-spline curves and surfaces*, CAGD 4 (1987); Golub, Pereyra, *The differentiation of
//! pseudo-inverses and nonlinear least squares problems whose variables separate* (1973).

pub(crate) mod adaptive;
mod attempt;
pub(crate) mod breaks;
pub(crate) mod clamped_breaks;
pub(crate) mod correction;
pub(crate) mod edges;
pub(crate) mod equations;
mod gram;
pub(crate) mod growth;
pub(crate) mod guide;
pub(crate) mod insertion;
pub(super) mod knot_conversion;
mod knot_step;
pub(crate) mod levels;
mod merging;
pub(crate) mod minimax;
pub(crate) mod monitor;
pub(crate) mod placement;
mod pruning;
pub(crate) mod schedule;
pub(crate) mod steps;
pub(crate) mod surface;
#[cfg(test)]
mod tests;
pub(crate) mod values;

use std::sync::Arc;

use self::breaks::Breaks;
use crate::data::points::Points;

/// Options of a fit that chooses its knots, of `D` directions.
#[derive(Clone, Debug)]
pub(crate) struct Options<const D: usize> {
    /// The knots with which it begins.
    pub lines: [Breaks; D],
    /// The control points over them with which it begins; `None` means those near the data.
    pub first: Option<Points>,
    /// The parameters of the data in each direction.
    pub parameters: [Arc<Vec<f64>>; D],
    /// The largest distance that is accepted, in data units.
    pub tolerance: f64,
    /// The most control points of each direction; never more than data.
    pub max_control_points: [usize; D],
    /// True if parameters move to the foot points of their data: of curves and of scattered points.
    pub correct_parameters: bool,
}
