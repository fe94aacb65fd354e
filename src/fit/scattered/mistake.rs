//! What can be wrong with scattered points.

use thiserror::Error;

use crate::fit::place::{Axis, Place};

/// Why scattered points cannot be fitted.
#[allow(missing_docs, reason = "fields are the values that the messages name")]
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ScatteredMistake {
    /// Scattered points are to be fitted by a method that needs an order of them.
    #[error(
        "scattered points have no order, and {method} needs one: only least_squares fits them, and only surfaces"
    )]
    Method { method: &'static str },
    /// There are weights of scattered points.
    #[error(
        "scattered points have no weights of a rational surface; data_weights of the method says how much each of them counts"
    )]
    Weights,
    /// There are fewer scattered points than control points.
    #[error("{rows} × {columns} control points need at least as many points, {count} given")]
    Points {
        count: usize,
        rows: usize,
        columns: usize,
    },
    /// Scattered points are all at the same parameter.
    #[error("all points have the same parameter in this direction: they are no surface")]
    Equal { axis: Axis },
    /// Knots are to be spread over fewer parameters than there are control points.
    #[error(
        "{free} control points for {count} different parameters: give the knots as numbers, or fewer control points"
    )]
    Few {
        axis: Axis,
        free: usize,
        count: usize,
    },
    /// Knots of points in an order are asked for.
    #[error("the knots of scattered points are \"spread\" over their parameters, or numbers")]
    Knots { axis: Axis },
    /// Scattered points are to be fitted by a closed surface.
    #[error("scattered points are fitted by open surfaces only")]
    Closed { axis: Axis },
    /// Points of one coordinate have no plane.
    #[error(
        "points of one coordinate have no plane for their parameters: give u and v of each point"
    )]
    NoPlane,
    /// All points lie on a line.
    #[error(
        "all points lie on a line (or are equal), so that there is no plane nearest to them: give u and v of each point"
    )]
    OnLine,
}

impl ScatteredMistake {
    /// The part of the problem that is wrong.
    pub(in crate::fit) fn place(&self) -> Place {
        match *self {
            Self::Method { .. } => Place::Method,
            Self::Weights => Place::Weights,
            Self::Points { .. } => Place::Points,
            Self::Equal { axis } => Place::Parameters(axis),
            Self::Few { axis, .. } => Place::ControlPoints(axis),
            Self::Knots { axis } => Place::Knots(axis),
            Self::Closed { axis } => Place::Closed(axis),
            Self::NoPlane | Self::OnLine => Place::Parameters(Axis::U),
        }
    }
}
