//! Fairness that the data choose.

use super::request::Request;
use crate::basis::choice::BasisChoice;
use crate::invalid::{Invalid, Place, Setting};
use crate::method::cross_validation;
use crate::method::{EndPoints, LeastSquares, Method};
use crate::setup::Setup;

/// The default is a control point for each datum, up to this number of data.
const FEW: usize = 50;

/// The largest number of control points of more data, unless one for every [`PART`] data is more.
const MAX_CONTROL_POINTS: usize = 200;

/// See [`MAX_CONTROL_POINTS`].
const PART: usize = 20;

/// The settings of a fit of which the data choose the fairness.
fn settings(request: &mut Request) -> Option<&mut LeastSquares> {
    match &mut request.method {
        Method::LeastSquares(settings) if settings.fairness.is_some_and(|it| it.by_data) => {
            Some(settings)
        }
        _ => None,
    }
}

/// Noise is at the ends, too: these are free unless they are to be interpolated. Without a tolerance enough control
/// points are taken, as fairness says how free they are.
pub(super) fn settle(request: &mut Request) {
    let (count, has_goal) = (request.grid.count(), request.tolerance.is_some());
    let is_curve = request.v.is_none();
    let degree = match request.u.basis {
        BasisChoice::BSpline { degree, .. } => degree,
        BasisChoice::Polynomial(_) => 1,
    };
    let Some(settings) = settings(request) else {
        return;
    };
    if settings.ends == EndPoints::Usual {
        settings.ends = EndPoints::Free;
    }
    if settings.automatic.is_some() && is_curve && !has_goal {
        let most = MAX_CONTROL_POINTS
            .max(count / PART)
            .min(FEW + count.saturating_sub(FEW) / 2);
        settings.automatic = None;
        settings.u = settings.u.min(most.min(count)).max(degree + 1);
    }
}

/// Chooses the fairness, if the data are to choose it.
pub(super) fn choose(request: &mut Request, setup: &Setup, tolerance: f64) -> Result<(), Invalid> {
    let tolerance = request.tolerance.map(|_| tolerance);
    let Some(settings) = settings(request) else {
        return Ok(());
    };
    let value = cross_validation::chosen(setup, settings, tolerance)
        .map_err(|detail| Invalid::at(Place::Setting(Setting::Fairness), detail))?;
    settings.fairness.iter_mut().for_each(|it| it.value = value);
    Ok(())
}
