//! What can be wrong with constraints.

use thiserror::Error;

use crate::fit::invalid::{Axis, Place, Setting};

/// The most conditions of a fit: a constraint along a boundary has one for each control point of it.
pub const MOST_CONDITIONS: usize = 1000;

/// Why constraints are refused. `index` is that of the constraint.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "fields are the values that the messages name")]
pub enum ConstraintsMistake {
    /// End points of a closed curve or of scattered points are to be interpolated.
    #[error(
        "there are no ends to interpolate: closed directions have none, and neither have scattered points"
    )]
    NoEnds,
    /// There is nothing to do as it is asked for.
    #[error("constraint {index} {detail}")]
    Unfit { index: usize, detail: &'static str },
    /// A vector has more or fewer coordinates than the data.
    #[error("constraint {index} has {given} coordinates, the data have {expected}")]
    Coordinates {
        index: usize,
        given: usize,
        expected: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("constraint {index} has the coordinate {value}, which is not a finite number")]
    NotFinite { index: usize, value: f64 },
    /// There is no such data point.
    #[error("constraint {index} is at data point {point}, but there are {count} of them")]
    NoPoint {
        index: usize,
        point: usize,
        count: usize,
    },
    /// The data point is missing.
    #[error("constraint {index} is at data point {point}, which is missing")]
    Missing { index: usize, point: usize },
    /// A parameter is not in the domain.
    #[error(
        "constraint {index} is at the parameter {value} of {axis}, outside of {low} to {high}",
        axis = axis.name()
    )]
    Outside {
        index: usize,
        axis: Axis,
        value: f64,
        low: f64,
        high: f64,
    },
    /// A boundary has another number of control points.
    #[error("constraint {index} has {given} control points along a boundary of {expected}")]
    Boundary {
        index: usize,
        given: usize,
        expected: usize,
    },
    /// A constraint depends on others, and agrees with them.
    #[error("constraint {index} follows from {others} already: leave one of them out")]
    Redundant { index: usize, others: String },
    /// A constraint depends on others, and does not agree with them.
    #[error(
        "constraint {index} cannot be obeyed together with {others}: the control points there have too little freedom"
    )]
    Contradictory { index: usize, others: String },
    /// An end point cannot be interpolated.
    #[error(
        "the data points at the ends cannot be interpolated together with {others}: name the end_points \"free\""
    )]
    EndsContradict { others: String },
    /// There are too many conditions.
    #[error("there are {count} conditions, at most {MOST_CONDITIONS} are accepted")]
    TooMany { count: usize },
}

impl ConstraintsMistake {
    /// The part of the problem that is wrong.
    pub(in crate::fit) fn place(&self) -> Place {
        match *self {
            Self::NoEnds | Self::EndsContradict { .. } => Place::Setting(Setting::EndPoints),
            Self::TooMany { .. } => Place::Setting(Setting::Constraints),
            Self::Unfit { index, .. }
            | Self::Coordinates { index, .. }
            | Self::NotFinite { index, .. }
            | Self::NoPoint { index, .. }
            | Self::Missing { index, .. }
            | Self::Outside { index, .. }
            | Self::Boundary { index, .. }
            | Self::Redundant { index, .. }
            | Self::Contradictory { index, .. } => Place::Constraint(index),
        }
    }
}
