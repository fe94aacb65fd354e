//! Sorting the points of a curve.

use std::sync::Arc;

use super::request::{Request, Weights};
use crate::basis::choice::Corners;
use crate::data::nearest_order::{Branch, MOST_POINTS, nearest_order};
use crate::invalid::{Invalid, Place};
use crate::method::{At, Method, Threshold};
use crate::parameters::Parametrization;

/// Sorts the points along their curve, if they are unordered. From then on that is their order.
pub(super) fn resolve(request: &mut Request) -> Result<(), Invalid> {
    if !request.unordered {
        return Ok(());
    }
    check(request)?;
    let order = nearest_order(&request.points).map_err(|Branch { point }| {
        let detail = format!(
            "the points branch at point {point}, so that no order leads along one curve: give them in their order, or fit a \
             surface to scattered points"
        );
        Invalid::at(Place::Point(point), detail)
    })?;
    request.points = Arc::new(request.points.selected(order.into_iter()));
    request.unordered = false;
    Ok(())
}

/// Refuses settings that refer to points by their index.
fn check(request: &Request) -> Result<(), Invalid> {
    let count = request.points.len();
    let found = match &request.u.parameters {
        Parametrization::Explicit(_) if request.v.is_none() => {
            "parameters give the points an order: leave one of both out".to_owned()
        }
        _ => match settings_by_place(request) {
            Some(reason) => reason.to_owned(),
            None if count > MOST_POINTS => {
                format!("at most {MOST_POINTS} points are put in order, and {count} are given")
            }
            None => return Ok(()),
        },
    };
    Err(Invalid::at(Place::Order, found))
}

/// Settings that prevent sorting or removing points, as they refer to points by their index.
pub(super) fn settings_by_place(request: &Request) -> Option<&'static str> {
    let choice = &request.u;
    let by_index = match &request.method {
        Method::LeastSquares(settings) => {
            let is_index = |at: At| matches!(at, At::Index(_));
            let constraints = settings.constraints.iter();
            settings.data_weights.is_some() || constraints.map(|it| it.at).any(is_index)
        }
        Method::Adaptive(settings) => matches!(settings.threshold, Threshold::Each(_)),
        Method::Custom(_) => true,
        _ => request.selected.is_some(),
    };
    if request.v.is_some() {
        return Some("a surface has rows of points, or scattered ones");
    }
    if request.weights != Weights::None || choice.weights.is_some() {
        return Some("weights are those of points in their order: leave them out");
    }
    if matches!(choice.corners, Some(Corners::At(_))) {
        return Some("corners are indices of points in their order: let them be found");
    }
    by_index.then_some("the method has settings for points in their order: leave them out")
}
