//! Grids with missing points whose knots a fit chooses: the points that are there are fitted as scattered points, at the
//! parameters of their rows and columns.

use std::sync::Arc;

use super::request::Request;
use super::robust::Inliers;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::parameters::{Domain, Pairs, Parametrization, Scattered};
use crate::setup::Setup;

/// The points that are there, and their fit; `None` if none is missing.
pub(super) fn present(request: &Request, setup: &Setup) -> Option<(Inliers, Request)> {
    let missing = setup.missing().filter(|_| !request.missing.is_empty())?;
    let [u, v] = [setup.u(), setup.v()?];
    let columns = v.parameters.len();
    let present = Inliers::without(missing, &request.points);
    let of = |direction: &Direction, place: fn(usize, usize) -> usize| {
        let indices = present.indices.iter();
        indices
            .map(|&index| direction.parameters[place(index, columns)])
            .collect::<Vec<f64>>()
    };
    let lanes = [
        of(u, |i, columns| i / columns),
        of(v, |i, columns| i % columns),
    ];
    let pairs = Pairs {
        values: Arc::new(Points::from_lanes(lanes)),
        domains: [u, v].map(domain),
    };
    let mut request = request.clone();
    request.missing.clear();
    // Those of the grid are lists of rows and columns.
    for choice in std::iter::once(&mut request.u).chain(&mut request.v) {
        choice.parameters = Parametrization::Uniform;
    }
    let mut alone = present.alone(&request);
    alone.scattered = Some(Scattered::Given(pairs));
    Some((present, alone))
}

/// How far a direction goes, also where its first or last line has no point.
fn domain(direction: &Direction) -> Domain {
    let t = &direction.parameters;
    match direction.period() {
        Some(period) => Domain::Closed(period),
        None => Domain::Between {
            ends: [t[0], t[t.len() - 1]],
            poles: [false; 2],
        },
    }
}
