//! Polylines: data whose edges are data, too.

use super::request::{Request, Weights};
use crate::basis::choice::Corners;
use crate::data::corners;
use crate::invalid::{Invalid, Place};
use crate::method::EndPoints;

/// Vertices at which a polyline turns by this angle, in degrees, or more go back along the edge before.
const BACK: f64 = 180.0 - 1e-6;

/// Refuses invalid polylines and settings that cannot be combined with them, and finds their corners by default.
pub(super) fn resolve(request: &mut Request) -> Result<(), Invalid> {
    if !request.polyline {
        return Ok(());
    }
    check(request)?;
    let (points, closed) = (&request.points, request.u.closed);
    if let Some(&vertex) = corners::turns(points, closed, BACK.to_radians()).first() {
        let detail = format!("the polyline turns back on itself at point {vertex}");
        return Err(Invalid::at(Place::Point(vertex), detail));
    }
    if let Corners::Found(angle) = request.u.corners.get_or_insert(Corners::USUAL) {
        let radians = super::corners::radians(*angle)?;
        request.u.corners = Some(Corners::At(corners::turns(points, closed, radians).into()));
    }
    Ok(())
}

fn check(request: &Request) -> Result<(), Invalid> {
    let wrong = |detail: &str| Err(Invalid::at(Place::Polyline, detail));
    if request.v.is_some() {
        return wrong("a polyline is a curve: a surface has none");
    }
    if request.points.dimension() == 1 {
        return wrong(
            "points of one coordinate are values of a function: a polyline has two or more",
        );
    }
    let Some((settings, automatic)) = request.method.automatic() else {
        return wrong(
            "the edges of a polyline are fitted by least squares with control_points \"auto\": choose that method",
        );
    };
    if request.weights != Weights::None || settings.data_weights.is_some() {
        return wrong("the edges of a polyline count alike: leave weights out");
    }
    if !settings.constraints.is_empty() || settings.fairness.is_some() {
        return wrong("a polyline is fitted without constraints and fairness: leave them out");
    }
    if settings.ends == EndPoints::Free {
        return wrong("the fit of a polyline passes through its ends: leave end_points out");
    }
    if automatic.correct_parameters {
        return wrong(
            "the points along a polyline stay where they are: leave correct_parameters out",
        );
    }
    match request.points.len() {
        0..=2 => Err(Invalid::at(
            Place::Points,
            "a polyline has two edges at least: two points are a straight line",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
