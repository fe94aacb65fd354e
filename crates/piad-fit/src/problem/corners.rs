//! The corners of a curve: how they are found, and which fits support them.

use std::sync::Arc;

use super::request::{Request, Weights};
use super::robust::Inliers;
use crate::basis::choice::{BasisChoice, Corners, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::corners;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};
use crate::method::{At, Constraint, EndPoints, Method, Wanted};

/// Finds the corners of a curve if they are not given, and removes the setting if there are none; least squares passes
/// through them.
pub(super) fn resolve(request: &mut Request, inliers: Option<&Inliers>) -> Result<(), Invalid> {
    let Some(corners) = request.u.corners.clone() else {
        return Ok(());
    };
    check(request)?;
    let indices = match corners {
        Corners::At(indices) => {
            let words = (Axis::U, ("point", "the curve"));
            check_indices(&indices, words, request.grid.rows, request.u.closed)?;
            indices
        }
        Corners::Found(degrees) => {
            let angle = radians(degrees)?;
            if request.points.dimension() == 1 {
                let detail =
                    "points of one coordinate have no angles: give the indices of the corners";
                return Err(wrong(detail.to_owned()));
            }
            let find = |points: &Points| corners::find(points, request.u.closed, angle);
            match inliers {
                None => find(&request.points).into(),
                Some(Inliers {
                    points, indices, ..
                }) => find(points).into_iter().map(|it| indices[it]).collect(),
            }
        }
    };
    request.u.corners = (!indices.is_empty()).then(|| Corners::At(Arc::clone(&indices)));
    pass_through(request, &indices)
}

/// Returns true if a curve chooses its knots and could have corners, but has no setting for them.
pub(super) fn rounds(request: &Request) -> bool {
    request.method.is_automatic()
        && request.u.corners.is_none()
        && request.points.dimension() > 1
        && check(request).is_ok()
}

/// The angle beyond which a curve may turn.
pub(super) fn radians(degrees: f64) -> Result<f64, Invalid> {
    match degrees > 0.0 && degrees < 180.0 {
        true => Ok(degrees.to_radians()),
        false => Err(wrong(format!(
            "the angle is {degrees}; it must lie between 0 and 180 degrees"
        ))),
    }
}

/// The error for a direction that can have no corners, or creases.
pub(super) fn refused(choice: &DirectionChoice, what: &str) -> Option<String> {
    let found = match &choice.basis {
        BasisChoice::Polynomial(_) => format!("a polynomial has no {what}: use a B-spline"),
        BasisChoice::BSpline { knots, .. }
            if !matches!(knots, Knots::Usual | Knots::Averaged | Knots::Spread) =>
        {
            format!(
                "{what} have knots of their own, and the pieces between them averaged ones: leave knots out"
            )
        }
        _ if choice.ends.is_some() => {
            format!(
                "each piece between {what} has a control point for each data point: leave ends out"
            )
        }
        _ if choice.weights.is_some() => format!("with fixed weights there are no {what}"),
        _ => return None,
    };
    Some(found)
}

/// Refuses settings that corners cannot be combined with.
fn check(request: &Request) -> Result<(), Invalid> {
    if let Some(found) = refused(&request.u, "corners") {
        return Err(wrong(found));
    }
    let least_squares = matches!(request.method, Method::LeastSquares(_));
    let found = match request.weights {
        _ if least_squares && request.weights != Weights::None => {
            "rational least squares does not pass through given points, so it has no corners"
        }
        _ => match request.method.automatic() {
            Some((settings, _)) if !settings.constraints.is_empty() => {
                "a fit that chooses the number of its control points has either corners or constraints: give a number"
            }
            Some((settings, _)) if settings.ends == EndPoints::Free => {
                "a fit that chooses the number of its control points passes through the ends of the pieces between its \
                 corners: leave end_points out"
            }
            _ => return Ok(()),
        },
    };
    Err(wrong(found.to_owned()))
}

/// The data points at the ends of the pieces between corners. On a closed curve they begin with the first corner and
/// end with it, with indices beyond the number of data.
pub(super) fn ends_of_pieces(corners: &[usize], count: usize, closed: bool) -> Vec<usize> {
    match closed {
        true => corners
            .iter()
            .copied()
            .chain([corners[0] + count])
            .collect(),
        false => std::iter::once(0)
            .chain(corners.iter().copied())
            .chain([count - 1])
            .collect(),
    }
}

/// Parameters from the first point to the last, or on a closed curve to its first corner after a period.
pub(super) fn unrolled(parameters: &[f64], corners: &[usize], period: Option<f64>) -> Vec<f64> {
    let again = period.map(|period| parameters[..=corners[0]].iter().map(move |t| t + period));
    parameters
        .iter()
        .copied()
        .chain(again.into_iter().flatten())
        .collect()
}

fn wrong(detail: String) -> Invalid {
    Invalid::at(Place::Corners(Axis::U), detail)
}

/// Refuses indices that do not increase, are none of points, or those of the ends of an open curve.
pub(super) fn check_indices(
    indices: &[usize],
    (axis, (thing, whole)): (Axis, (&str, &str)),
    count: usize,
    closed: bool,
) -> Result<(), Invalid> {
    for (place, &index) in indices.iter().enumerate() {
        let before = place.checked_sub(1).map(|place| indices[place]);
        let detail = match before {
            _ if index >= count => {
                format!(
                    "there is no {thing} {index}: {whole} has {thing}s 0 to {}",
                    count - 1
                )
            }
            _ if !closed && (index == 0 || index + 1 == count) => {
                format!("{thing} {index} is an end of {whole}, where it cannot turn")
            }
            Some(before) if index <= before => {
                format!("{thing} {index} comes after {thing} {before}: their indices must increase")
            }
            _ => continue,
        };
        return Err(Invalid::at(Place::Corner(axis, place), detail));
    }
    Ok(())
}

/// Lets least squares pass through the data points of corners without another constraint.
fn pass_through(request: &mut Request, corners: &[usize]) -> Result<(), Invalid> {
    let Method::LeastSquares(settings) = &mut request.method else {
        return Ok(());
    };
    // Its pieces are fits by themselves, through their ends.
    if settings.automatic.is_some() {
        return Ok(());
    }
    let mut constraints = settings.constraints.to_vec();
    for &index in corners {
        let at = At::Index(index);
        let through = Constraint {
            at,
            wanted: Wanted::DataPoint,
        };
        let place = constraints.iter().position(|it| it.at == at);
        match place {
            None => constraints.push(through),
            Some(place) if constraints[place] == through => {}
            Some(place) => {
                let detail = format!(
                    "point {index} is a corner: the curve passes through it, and turns there"
                );
                return Err(Invalid::at(Place::Constraint(place), detail));
            }
        }
    }
    settings.constraints = constraints.into();
    Ok(())
}

#[cfg(test)]
mod tests;
