//! Points of a curve that equal the one before them: devices write them where they rest.

use std::sync::Arc;

use super::order::settings_by_place;
use super::request::Request;
use crate::invalid::{Invalid, Place};
use crate::parameters::Parametrization;

/// Keeps points that equal the one before them once, and of a closed curve the first point alone where the last ones
/// equal it, if requested. Explicit parameters go with their points.
pub(super) fn merge(request: &mut Request) -> Result<(), Invalid> {
    if !std::mem::take(&mut request.merge_repeated) {
        return Ok(());
    }
    if let Some(reason) = settings_by_place(request) {
        return Err(Invalid::at(Place::RepeatedPoints, reason));
    }
    let points = &request.points;
    let equal = |i: usize, j: usize| points.point(i).eq(points.point(j));
    let mut kept: Vec<usize> = (0..points.len())
        .filter(|&i| i == 0 || !equal(i, i - 1))
        .collect();
    while request.u.closed && kept.len() > 1 && equal(0, kept[kept.len() - 1]) {
        kept.pop();
    }
    if kept.len() == points.len() {
        return Ok(());
    }
    if kept.len() < 2 {
        return Err(Invalid::too_few_points(kept.len()));
    }
    if let Parametrization::Explicit(values) = &request.u.parameters
        && values.len() >= points.len()
    {
        let of_kept = kept.iter().map(|&i| values[i]);
        // A closed curve has one more, that of its first point after a period.
        let after = values[points.len()..].iter().copied();
        request.u.parameters = Parametrization::Explicit(Arc::new(of_kept.chain(after).collect()));
    }
    request.grid.rows = kept.len();
    request.points = Arc::new(points.selected(kept.into_iter()));
    Ok(())
}
