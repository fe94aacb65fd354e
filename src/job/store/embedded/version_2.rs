//! What files of version 2 of the format and before leave open of a problem, and what it meant then.
//!
//! Since version 3 knots and ends are stored as they are used. Before, a problem without them had its
//! knots at the data, whatever its degree, and ends with copies of the end points; open least-squares
//! fits had theirs by PT97 (9.68)–(9.69), and end points were data points like others.

use crate::fit::basis::knots::Knots;
use crate::fit::direction::{BasisChoice, DirectionChoice};
use crate::fit::ends::{End, Ends};
use crate::fit::method::{EndPoints, Method};
use crate::fit::problem::Request;

/// Says what was left open.
pub(super) fn complete(request: &mut Request) {
    let complete = if request.method.has_fewer_control_points() {
        least_squares
    } else {
        direction
    };
    if let Method::LeastSquares(settings) = &mut request.method
        && settings.ends == EndPoints::Usual
    {
        settings.ends = EndPoints::Free;
    }
    complete(&mut request.u);
    if let Some(v) = &mut request.v {
        complete(v);
    }
}

fn least_squares(choice: &mut DirectionChoice) {
    choice.name_open(Knots::PieglTiller);
}

fn direction(choice: &mut DirectionChoice) {
    let BasisChoice::BSpline { knots, .. } = &mut choice.basis else {
        return;
    };
    if *knots == Knots::Usual {
        *knots = Knots::Data;
    }
    if *knots == Knots::Data && !choice.closed && choice.ends.is_none() {
        choice.ends = Some(Ends::both(End::Repeated));
    }
}
