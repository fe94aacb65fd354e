//! The corners of a curve: where they are, and what has none.

use std::sync::Arc;

use super::request::{Request, Weights};
use crate::basis::choice::{BasisChoice, Corners};
use crate::basis::knots::Knots;
use crate::data::corners;
use crate::invalid::{Axis, Invalid, Place};
use crate::method::{At, Constraint, Method, Wanted};

/// Finds the corners of a curve where they are not given, and leaves them out where there are none; least squares passes
/// through them.
pub(super) fn resolve(request: &mut Request) -> Result<(), Invalid> {
    if request.v.iter().any(|v| v.corners.is_some()) {
        return Err(wrong(
            "corners are those of curves: a surface has none".to_owned(),
        ));
    }
    let Some(corners) = request.u.corners.clone() else {
        return Ok(());
    };
    check(request)?;
    let indices = match corners {
        Corners::At(indices) => {
            check_indices(&indices, request.grid.rows)?;
            indices
        }
        Corners::Found(degrees) => {
            if !(degrees > 0.0 && degrees < 180.0) {
                let detail =
                    format!("the angle is {degrees}; it must lie between 0 and 180 degrees");
                return Err(wrong(detail));
            }
            if request.points.dimension() == 1 {
                let detail =
                    "points of one coordinate have no angles: give the indices of the corners";
                return Err(wrong(detail.to_owned()));
            }
            corners::find(&request.points, false, degrees.to_radians()).into()
        }
    };
    request.u.corners = (!indices.is_empty()).then(|| Corners::At(Arc::clone(&indices)));
    pass_through(request, &indices)
}

/// Refuses what corners cannot be combined with.
fn check(request: &Request) -> Result<(), Invalid> {
    let choice = &request.u;
    let least_squares = matches!(request.method, Method::LeastSquares(_));
    let found = match &choice.basis {
        _ if request.v.is_some() => "corners are those of curves: a surface has none",
        BasisChoice::Polynomial(_) => "a polynomial has no corners: use a B-spline",
        BasisChoice::BSpline { knots, .. }
            if !matches!(knots, Knots::Usual | Knots::Averaged | Knots::Spread) =>
        {
            "corners have knots of their own, and the pieces between them averaged ones: leave knots out"
        }
        _ if choice.closed => {
            "a closed curve turns smoothly at each of its points: begin with a corner, end with the same point again, and \
             leave closed out"
        }
        _ if choice.ends.is_some() => {
            "each piece between corners has a control point for each data point: leave ends out"
        }
        _ if choice.weights.is_some() => "with fixed weights a curve has no corners",
        _ if least_squares && request.weights != Weights::None => {
            "rational least squares does not pass through given points, so it has no corners"
        }
        _ if request.method.is_automatic() => {
            "a fit that chooses the number of its control points has no corners: give a number"
        }
        _ => return Ok(()),
    };
    Err(wrong(found.to_owned()))
}

fn wrong(detail: String) -> Invalid {
    Invalid::at(Place::Corners(Axis::U), detail)
}

/// Refuses indices that are none of inner points, or do not increase.
fn check_indices(indices: &[usize], count: usize) -> Result<(), Invalid> {
    for (place, &index) in indices.iter().enumerate() {
        let before = place.checked_sub(1).map(|place| indices[place]);
        let detail = match before {
            _ if index >= count => {
                format!(
                    "there is no point {index}: the curve has points 0 to {}",
                    count - 1
                )
            }
            _ if index == 0 || index + 1 == count => {
                format!("point {index} is an end of the curve, which turns nowhere")
            }
            Some(before) if index <= before => {
                format!("corner {index} comes after corner {before}: their indices must increase")
            }
            _ => continue,
        };
        return Err(Invalid::at(Place::Corner(Axis::U, place), detail));
    }
    Ok(())
}

/// Lets least squares pass through the data points of corners, at which nothing else is asked for.
fn pass_through(request: &mut Request, corners: &[usize]) -> Result<(), Invalid> {
    let Method::LeastSquares(settings) = &mut request.method else {
        return Ok(());
    };
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
