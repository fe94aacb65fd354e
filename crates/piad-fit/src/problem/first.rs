//! The initial knots of a fit that chooses them, and its memory.

use std::sync::Arc;

use super::construction::first_direction;
use super::request::Request;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::Direction;
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::invalid::{Axis, Invalid};
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::edges::Edges;
use crate::knot_selection::surface::{MOST_FACTOR, sections};
use crate::method::{KnotSelection, LeastSquares, MORE_NUMBERS};
use crate::parameters::{Domain, Pairs};
use crate::setup::Setup;

/// The directions with which a fit begins that chooses its knots.
pub(crate) fn first_directions(
    request: &Request,
    (pairs, missing): (Option<&Pairs>, Option<&Missing>),
    (settings, _): (&LeastSquares, &KnotSelection),
) -> Result<(Direction, Option<Direction>), Invalid> {
    let breaks = |place: usize| {
        let all = request.start_breaks.as_ref();
        all.and_then(|all| all.get(place)).map(|breaks| &breaks[..])
    };
    if let Some(pairs) = pairs {
        let first = |choice: &DirectionChoice, at: usize, most: usize, axis: Axis| {
            first_scattered(choice, (pairs.direction(at), breaks(at)), most, axis)
        };
        let u = first(&request.u, 0, settings.u, Axis::U)?;
        let v = request.v.as_ref();
        let v = v.map(|v| first(v, 1, settings.v, Axis::V));
        return Ok((u, v.transpose()?));
    }
    let data = (&*request.points, request.grid, missing);
    let direction = |choice: &DirectionChoice, most, axis, place: usize| {
        let breaks = breaks(place);
        first_direction(choice.clone(), data, breaks, most, axis)
    };
    let u = direction(&request.u, settings.u, Axis::U, 0)?;
    let v = request.v.as_ref();
    let v = v.map(|choice| direction(choice, settings.v, Axis::V, 1));
    Ok((u, v.transpose()?))
}

/// The direction with which a fit of scattered points begins.
fn first_scattered(
    choice: &DirectionChoice,
    (parameters, breaks): ((Vec<f64>, Domain), Option<&[f64]>),
    most: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let BasisChoice::BSpline { degree, .. } = choice.basis else {
        return Err(Invalid::automatic_knots(axis));
    };
    let free = degree.saturating_add(1);
    if most < free {
        let free = most;
        return Err(Invalid::too_few_control_points(axis, free, degree));
    }
    let direction = Direction::scattered(choice, parameters, free, axis)?;
    let line = match breaks {
        Some(breaks) => Breaks::new(degree, direction.is_closed(), breaks.to_vec()),
        None => Breaks::of(&direction),
    };
    let line = line.ok_or(Invalid::parameter_range(axis))?;
    Ok(line.direction(direction.parameters))
}

/// A fit that chooses its knots, with half as long spans, for data beyond the reach of the setup.
pub(crate) fn finer(setup: &Setup, request: &Request) -> Option<Setup> {
    let (settings, _) = request.method.automatic()?;
    let Grid { rows, columns } = setup.grid();
    let data = match setup.is_scattered() {
        true => [rows; 2],
        false => [rows, columns],
    };
    let halved = |direction: &Direction, most: usize| {
        let line = Breaks::of(direction)?.halved()?;
        let fits = line.control_points() <= most;
        fits.then(|| line.direction(Arc::clone(&direction.parameters)))
    };
    let u = halved(setup.u(), settings.u.min(data[0]))?;
    let v = match setup.v() {
        Some(v) => Some(halved(v, settings.v.min(data[1]))?),
        None => None,
    };
    setup.start().is_none().then(|| Setup {
        u,
        v,
        ..setup.clone()
    })
}

/// The most numbers of a factorization over some of the many knots that are tried for a surface: what
/// its bound of multiplications leaves room for.
const FACTOR: usize = 1 << 21;

/// The approximate number of bytes that a fit takes besides its data: values of functions, and the
/// levels that a schedule remembers, with at most `most` control points.
pub(crate) fn memory(setup: &Setup, settings: &LeastSquares, most: usize) -> usize {
    let dimension = setup.dimension();
    let width: usize = setup
        .directions()
        .map(|it| it.basis.degree() + 1)
        .max()
        .unwrap_or(1);
    let data = match (&setup.sections, setup.polyline) {
        (Some(counts), _) => sections::most_points(counts),
        (None, true) => Edges::most(setup.grid().count()),
        (None, false) => setup.grid().count(),
    };
    // A value of each function at each parameter twice, distances and parameters of five levels,
    // residual and image of a step, weights, and what is being computed.
    let by_data = data * (2 * width + 10 + 2 * dimension + 2);
    let by_control_points = most * (5 * dimension + 4 * width);
    // The normal equations of scattered points, those of an energy, and the factor of both.
    let normal = match setup.v() {
        Some(_) if setup.is_scattered() => {
            let factor = most.saturating_mul(most).min(MOST_FACTOR);
            2 * data * width * width + MORE_NUMBERS + factor
        }
        _ => 0,
    };
    // Points one by one, the values at each of them, and the vectors of conjugate gradients.
    let constrained = match setup.v() {
        Some(_) if !settings.is_plain_surface() => data * (2 * width + 3 * dimension + 8) + FACTOR,
        _ => 0,
    };
    // Places and derivatives at all points, and these once more at other parameters.
    let moves = settings.automatic.is_some_and(|it| it.correct_parameters);
    let moved = match setup.v() {
        Some(_) if moves => data * (4 * dimension + 2 * width + 8),
        _ => 0,
    };
    (by_data + by_control_points + normal + constrained + moved) * size_of::<f64>()
}
