//! Checks of a request before and while it becomes a problem.

use std::sync::Arc;

use super::request::Tolerance;
use super::request::{Request, Weights};
use crate::basis::choice::DirectionChoice;
use crate::data::bounds::Extent;
use crate::data::missing::Missing;
use crate::data::points::{MAX_DIMENSION, MAX_SURFACE_DIMENSION, Points, ROUNDING};
use crate::invalid::{Invalid, Place};
use crate::method::Scope;
use crate::setup::Setup;

/// The sizes that the settings of a method are checked against.
pub(super) fn scope(request: &Request) -> Scope<'_> {
    Scope {
        grid: request.grid,
        is_surface: request.v.is_some(),
        is_scattered: request.scattered.is_some(),
        dimension: request.points.dimension(),
        is_homogeneous: matches!(request.weights, Weights::Homogeneous(_)),
        selected: request.selected.as_deref(),
    }
}

/// Refuses points with no coordinate, or with more than there may be.
pub(super) fn check_dimension(request: &Request) -> Result<(), Invalid> {
    let (most, of) = match request.v {
        Some(_) => (MAX_SURFACE_DIMENSION, "a surface"),
        None => (MAX_DIMENSION, "a curve"),
    };
    let dimension = request.points.dimension();
    if (1..=most).contains(&dimension) {
        return Ok(());
    }
    let detail = format!("points of {of} have 1 to {most} coordinates, not {dimension}");
    Err(Invalid::at(Place::Points, detail))
}

/// Refuses grids with fewer than 2 points in a direction, and gives missing points a place. Returns
/// which are missing.
pub(super) fn check_points(request: &mut Request) -> Result<Option<Missing>, Invalid> {
    let grid = request.grid;
    let has_columns = request.v.is_some() && request.scattered.is_none();
    if grid.rows < 2 || (has_columns && grid.columns < 2) {
        let count = if grid.rows < 2 {
            grid.rows
        } else {
            grid.columns
        };
        return Err(Invalid::too_few_points(count));
    }
    let missing = Missing::new(&request.missing, grid.count());
    if let Some(missing) = &missing {
        if request.missing.len() == grid.count() {
            return Err(Invalid::at(Place::Points, "no point is given"));
        }
        if let (false, Some(&index)) = (
            request.method.algorithm().fits_holes(),
            request.missing.first(),
        ) {
            return Err(Invalid::at(
                Place::Point(index),
                "a point is missing; only least-squares fits of surfaces leave points out",
            ));
        }
        missing.fill(Arc::make_mut(&mut request.points), grid);
    }
    Ok(missing)
}

/// Scattered points are those of a surface, for a method that fits them, and without weights.
pub(super) fn check_scattered(request: &Request) -> Result<(), Invalid> {
    if request.scattered.is_none() {
        return Ok(());
    }
    let weighted = |choice: &DirectionChoice| choice.weights.is_some();
    let mut choices = std::iter::once(&request.u).chain(&request.v);
    if !request.method.algorithm().fits_scattered() || request.v.is_none() {
        let method = request.method.algorithm().info().name;
        return Err(Invalid::at(
            Place::Method,
            format!(
                "scattered points have no order, and {method} needs one: fit a surface with least_squares, such as control_points auto"
            ),
        ));
    }
    if request.weights != Weights::None || choices.any(weighted) {
        return Err(Invalid::at(
            Place::Weights,
            "scattered points have no weights of a rational surface; data_weights of the method says how much each of them counts",
        ));
    }
    Ok(())
}

/// A given start has the number and the coordinates of the control points.
pub(super) fn check_start(setup: &Setup) -> Result<(), Invalid> {
    let Some(start) = setup.start() else {
        return Ok(());
    };
    let (given, expected) = (start.len(), setup.control_grid().count());
    if given != expected || start.dimension() != setup.data().dimension() {
        return Err(Invalid::at(
            Place::Method,
            format!(
                "the fit starts from {given} control points, but this one has {expected}, or in other coordinates"
            ),
        ));
    }
    Ok(())
}

/// Refuses coordinates that are infinite or NaN, and names the first one.
pub(super) fn check_finite(points: &Points, extents: &[Extent]) -> Result<(), Invalid> {
    let lanes = points.lanes().iter().zip(extents);
    for (coordinate, (lane, _)) in lanes.enumerate().filter(|(_, (_, it))| !it.is_finite) {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::at(
                Place::Point(index),
                format!(
                    "coordinate {coordinate} is {value}, which is not a finite number",
                    value = lane[index]
                ),
            ));
        }
    }
    Ok(())
}

/// The tolerance in data units: a relative one is a multiple of the `diagonal`, but never below the
/// rounding of coordinates of this `magnitude`, unless it is zero.
pub(super) fn resolve_tolerance(
    tolerance: Option<Tolerance>,
    magnitude: f64,
    diagonal: f64,
) -> Result<f64, Invalid> {
    let (value, relative) = match tolerance.unwrap_or(Tolerance::DEFAULT) {
        Tolerance::Absolute(value) => (value, false),
        Tolerance::Relative(value) => (value, true),
    };
    if !(value.is_finite() && value >= 0.0) {
        let place = match relative {
            true => Place::RelativeTolerance,
            false => Place::Tolerance,
        };
        let detail =
            format!("the tolerance is {value}; it must be a finite number, zero or greater");
        return Err(Invalid::at(place, detail));
    }
    // Relative to points that are nearly equal, rounding of their coordinates would be too much.
    let rounding = magnitude * ROUNDING;
    let tolerance = match relative {
        true if value > 0.0 => (value * diagonal).max(rounding),
        true => 0.0,
        false => value,
    };
    if tolerance.is_finite() {
        Ok(tolerance)
    } else {
        Err(Invalid::at(
            Place::RelativeTolerance,
            format!(
                "the tolerance is {value} times {diagonal}, the diagonal of the bounding box, which exceeds the range of 64-bit numbers"
            ),
        ))
    }
}
