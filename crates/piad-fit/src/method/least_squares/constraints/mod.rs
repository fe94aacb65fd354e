//! Conditions of a constrained fit: points to pass through, and derivatives.
//!
//! Constraints are linear conditions `C X = R` on the control points, and every level satisfies them to
//! rounding. With a symmetric positive M, level 0 and every gradient g are projected,
//!
//! ```text
//! S = M Cᵀ (C M Cᵀ)⁻¹,   X⁰ ← X⁰ + S (R − C X⁰),   g ← g − Cᵀ (C M Cᵀ)⁻¹ C M g,   so that C M g = 0
//! ```
//!
//! and a step along M g leaves the conditions as they are. The limit is the solution of the KKT system, as the part of
//! g that is left out is that of the multipliers.
//!
//! - [`conditions`]: from constraints to rows of C and R;
//! - [`dependence`]: conditions that follow from others, or contradict them;
//! - [`tangents`]: the lengths of derivatives of which only the direction is given;
//! - [`projection`]: the projection.

mod conditions;
mod dependence;
mod projection;
mod tangents;

use crate::data::points::Points;
use crate::invalid::{Axis, Side};

pub(super) use conditions::Condition;
pub(super) use dependence::independent;
pub(super) use projection::Projection;
pub(super) use tangents::Tangents;

/// The most conditions of a fit: a constraint along a boundary has one for each control point of it.
pub const MOST_CONDITIONS: usize = 1000;

/// A condition that every level satisfies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraint {
    /// Where.
    pub at: At,
    /// What.
    pub wanted: Wanted,
}

/// Where a constraint holds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum At {
    /// At an end of an open curve.
    Side(Side),
    /// At the parameters of a data point; on surfaces `row · columns + column`.
    Index(usize),
    /// At a parameter of a curve.
    Parameter(f64),
    /// At parameters of a surface.
    Parameters(f64, f64),
    /// Along a boundary of a surface: at one side of an open direction.
    Boundary(Axis, Side),
}

/// What holds there.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Wanted {
    /// It passes through the data point.
    DataPoint,
    /// It, or its partial derivative of these orders in u and v, is this vector.
    Derivative {
        /// The orders; zero of both is the point itself. On curves the second one is zero.
        orders: [usize; 2],
        /// One number for each coordinate.
        vector: Vec<f64>,
    },
    /// The first derivative of a curve is a multiple of this vector that is not negative: the one with which the
    /// curve is nearest to the data.
    Tangent(Vec<f64>),
    /// The derivative across a boundary of this order, or the boundary itself, is the curve with these
    /// control points in the basis of the other direction.
    Across {
        /// The order; zero is the boundary itself.
        order: usize,
        /// One control point for each of the other direction.
        control_points: Points,
    },
}
