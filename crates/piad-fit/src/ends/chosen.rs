//! Applies the requested end conditions to a direction.

use super::copies::Copies;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::{CopyRule, Direction};
use crate::basis::end_conditions::{End, Ends, natural_degree};
use crate::basis::knots::Knots;
use crate::invalid::{Axis, Invalid, Place, Side};

/// The chosen ends of a direction, if it can have them: an open B-spline with knots at the data and
/// a control point for each data point.
///
/// # Errors
///
/// Why this direction has no ends to choose.
pub(crate) fn are_chosen(choice: &DirectionChoice, axis: Axis) -> Result<Option<Ends>, Invalid> {
    let Some(ends) = &choice.ends else {
        return Ok(None);
    };
    let natural = [Side::Start, Side::End];
    let natural = natural
        .into_iter()
        .find(|side| *ends.at(*side) == End::Natural);
    let found = match &choice.basis {
        _ if choice.closed => "this direction is closed",
        _ if choice.control_points.is_some() => {
            "least squares has ends of its own; leave these out, name the end_points of the method \"interpolated\" or \"free\", \
             and give derivatives there as constraints of the method, such as {\"at\": \"start\", \"tangent\": [1, 0, 0]}"
        }
        BasisChoice::Polynomial(_) => "polynomial bases have none",
        BasisChoice::BSpline { degree, knots } => match (knots, natural) {
            (_, Some(side)) if *degree != 3 => {
                let degree = *degree;
                return Err(natural_degree(axis, side, degree));
            }
            (Knots::Usual | Knots::Data, _) => return Ok(Some(ends.clone())),
            (Knots::Spread | Knots::Adaptive, _) => "these knots are for least squares",
            (Knots::Averaged, _) => {
                "with averaged knots, which even degrees have, each control point belongs to a data point; use an odd degree, \
                 or knots \"data\""
            }
            (Knots::Explicit(_), _) => {
                "with explicit knots each control point belongs to a data point"
            }
        },
    };
    Err(Invalid::no_ends(axis, found))
}

impl Ends {
    /// The direction with these ends; `boundary` is the number of data points on the boundary and
    /// that of their coordinates.
    pub(crate) fn apply(
        &self,
        direction: Direction,
        axis: Axis,
        boundary: (usize, usize),
    ) -> Result<Direction, Invalid> {
        let degree = direction.basis.degree();
        for side in [Side::Start, Side::End] {
            let copies = direction.copies(side);
            self.at(side)
                .check((axis, side), degree, copies, boundary)?;
        }
        let rule = |side| match self.at(side) {
            End::Repeated => Ok(CopyRule::Equal),
            End::Natural => natural(&direction, axis, side).map(CopyRule::Natural),
            _ => Ok(CopyRule::Constant),
        };
        let mut rules = [rule(Side::Start)?, rule(Side::End)?];
        // Of two points both copies lie between the same two control points, and follow each other.
        if let ([CopyRule::Natural(a), CopyRule::Natural(b)], 2) =
            (&mut rules, direction.parameters.len())
        {
            let all = 1.0 - *a * *b;
            (*a, *b) = (*a * (1.0 - *b) / all, *b * (1.0 - *a) / all);
        }
        Ok(direction.with_copies(rules))
    }
}

/// The part of the next control point in a natural end, which lies between 0 and 1, so that the
/// collocation matrix stays totally positive.
fn natural(direction: &Direction, axis: Axis, side: Side) -> Result<f64, Invalid> {
    let beta = Copies::natural(direction, side);
    if (0.0..=1.0).contains(&beta) {
        Ok(beta)
    } else {
        Err(Invalid::at(
            Place::End(axis, side),
            format!(
                "with these fixed weights the {side} has no natural form, as its control point would leave the segment between its neighbours: use estimated ends",
                side = side.name()
            ),
        ))
    }
}
