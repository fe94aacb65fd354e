//! The parameters of the scattered points of a request.

use super::admission::Admission;
use super::request::Request;
use crate::invalid::Invalid;
use crate::parameters::scattered::Unfolded;
use crate::parameters::{Domain, Pairs, Scattered};

/// The rule for the parameters of scattered points, if it is to be chosen.
pub(super) fn chosen(request: &Request) -> Result<Option<Scattered>, Invalid> {
    match &request.scattered {
        Some(rule @ (Scattered::Auto | Scattered::Sections(_))) => {
            rule.chosen(&request.points).map(Some)
        }
        _ => Ok(None),
    }
}

/// The parameters of a mesh, unless these take too much.
pub(super) fn unfolded(
    request: &Request,
    admission: &Admission,
) -> Result<Option<Unfolded>, Invalid> {
    let Some(rule) = &request.scattered else {
        return Ok(None);
    };
    if let Scattered::Mesh(mesh) = rule {
        mesh.check_count()?;
        let (bytes, multiplications) = mesh.cost();
        admission.check(bytes, 0, multiplications)?;
    }
    rule.unfolded(&request.points, closed(request))
}

/// The directions that are requested as closed.
fn closed(request: &Request) -> [bool; 2] {
    [Some(&request.u), request.v.as_ref()].map(|it| it.is_some_and(|it| it.closed))
}

/// The parameters of scattered points. Surfaces with a pole end at the data unless they are as those of `auto` without
/// conditions, of which all control points of a pole are one.
pub(super) fn pairs(
    request: &Request,
    chosen: Option<&Scattered>,
) -> Result<Option<Pairs>, Invalid> {
    let scattered = chosen.or(request.scattered.as_ref());
    let pairs = scattered.map(|it| it.parameters(&request.points, closed(request)));
    let Some(mut pairs) = pairs.transpose()? else {
        return Ok(None);
    };
    let settings = request.method.automatic();
    if settings.is_none_or(|(settings, _)| !settings.allows_poles()) {
        for domain in &mut pairs.domains {
            if domain.poles() != [false; 2] {
                *domain = Domain::Data;
            }
        }
    }
    Ok(Some(pairs))
}
