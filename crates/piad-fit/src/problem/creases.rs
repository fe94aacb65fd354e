//! The lines of a grid of points across which a surface may turn.

use super::corners::{check_indices, refused};
use super::request::{Request, Weights};
use crate::basis::choice::{Corners, DirectionChoice};
use crate::invalid::{Axis, Invalid, Place};

/// Refuses creases that are not lines between the first and the last one, and settings that they cannot be combined
/// with. Empty lists become `None`.
pub(super) fn resolve(request: &mut Request) -> Result<(), Invalid> {
    let Some(v) = &request.v else {
        return Ok(());
    };
    let lines = [
        (Axis::U, &request.u, ("row", "the surface")),
        (Axis::V, v, ("column", "the surface")),
    ];
    for (axis, choice, words) in lines {
        check(request, axis, choice, words)?;
    }
    let choices = std::iter::once(&mut request.u).chain(&mut request.v);
    for choice in choices {
        choice.corners = choice.corners.take().filter(|it| !it.indices().is_empty());
    }
    Ok(())
}

fn check(
    request: &Request,
    axis: Axis,
    choice: &DirectionChoice,
    words: (&str, &str),
) -> Result<(), Invalid> {
    let Some(creases) = &choice.corners else {
        return Ok(());
    };
    let found = match creases {
        Corners::Found(_) => Some("creases are indices of rows and columns".to_owned()),
        _ if request.scattered.is_some() => {
            Some("scattered points have no rows and columns, so a surface near them has no creases".to_owned())
        }
        _ if request.method.automatic().is_some() => {
            Some("a surface that chooses the number of its control points has no creases: give the numbers".to_owned())
        }
        _ if matches!(request.weights, Weights::FixedGrid(_)) => {
            Some("with fixed weights there are no creases".to_owned())
        }
        _ => refused(choice, "creases"),
    };
    match found {
        Some(detail) => Err(Invalid::at(Place::Corners(axis), detail)),
        None => check_indices(
            creases.indices(),
            (axis, words),
            request.grid.along(axis),
            choice.closed,
        ),
    }
}
