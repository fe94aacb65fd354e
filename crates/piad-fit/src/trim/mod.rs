//! The outline of the data of a surface in its parameters.
//!
//! The rectangle of parameters is divided into cells about as long as the spacing of the points (`spacing`). Those that
//! hold points, and gaps of up to two of them, are filled (`cells`), and their boundary (`boundary`) is smoothed within
//! half a cell (`smoothing`), so that loops do not cross (`crossing`). A mesh has its own boundary (`mesh`). A closed
//! direction is cut at its seam, where an outline goes along both sides.

mod boundary;
mod cells;
mod crossing;
mod mesh;
mod smoothing;
mod spacing;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::data::vectors::in_space;
use crate::geometry::nurbs::{KnotVector, Nurbs};
use crate::geometry::outline::{Face, Outline};
use crate::interrupt::Meter;
use crate::invalid::{Invalid, Place};
use crate::parameters::Scattered;
use crate::problem::Problem;
use crate::problem::request::Trim;
use boundary::{Piece, Vertex};
use cells::Side;
use mesh::Boundary;
use spacing::Data;

/// How much further inside than the edges of its filled cells the outline of scattered points is, in cells: a cell that they
/// reach counts as a whole one where any of them lies in it.
const INSIDE: f64 = 0.2;

/// The most loops of an outline.
const MOST_LOOPS: usize = 1000;

/// The problem with the outline of its data, if requested.
///
/// # Errors
///
/// Why there is none.
pub fn trimmed(problem: Problem) -> Result<Problem, Invalid> {
    let outline = match problem.request().trim {
        None => return Ok(problem),
        Some(trim) => outline(&problem, trim)?,
    };
    Ok(problem.with_outline(Arc::new(outline)))
}

fn outline(problem: &Problem, trim: Trim) -> Result<Outline, Invalid> {
    let Some(v) = problem.v() else {
        let detail = "only surfaces are trimmed, and this is a curve";
        return Err(Invalid::at(Place::Trim, detail));
    };
    let data = data(problem, v);
    if let Some(boundary) = of_mesh(problem, trim, &data)? {
        return Ok(boundary);
    }
    let (cells, distance) = spacing::cells(&data, trim.distance)?;
    let mut outline = Outline {
        loops: Vec::new(),
        faces: Vec::new(),
        distance,
    };
    if cells.are_all_filled() {
        return Ok(outline);
    }
    let inside = match data.grid {
        None => INSIDE,
        Some(_) => 0.0,
    };
    let pieces = boundary::pieces(&cells, inside, &mut Meter::default());
    let polygons = taken(pieces, &mut outline);
    if polygons.len() > MOST_LOOPS {
        let place = trim.distance.map_or(Place::Trim, |_| Place::TrimDistance);
        let (loops, pieces) = (polygons.len(), outline.faces.len());
        let detail = format!(
            "the outline of the data has {loops} loops around {pieces} pieces, and at most {MOST_LOOPS} are possible: give a distance greater than {distance:.4}"
        );
        return Err(Invalid::at(place, detail));
    }
    let range = cells.steps.map(|it| it.range());
    let loops = smoothing::smooth(&polygons, range).into_iter();
    let parameter = |axis: usize, place: f64| cells.steps[axis].parameter(place);
    outline.loops = loops.map(|it| in_parameters(it, parameter)).collect();
    Ok(outline)
}

/// The polygons of pieces, which become the faces of an outline.
fn taken(pieces: Vec<Piece>, outline: &mut Outline) -> Vec<Vec<Vertex>> {
    let mut polygons = Vec::new();
    for piece in pieces {
        let first = polygons.len();
        polygons.extend(piece.polygons);
        outline.faces.push(Face {
            outer: first,
            holes: first + 1..polygons.len(),
        });
    }
    polygons
}

/// The boundary of a mesh of which no distance is given and no direction is closed.
fn of_mesh(problem: &Problem, trim: Trim, data: &Data) -> Result<Option<Outline>, Invalid> {
    let Some(Scattered::Mesh(mesh)) = &problem.request().scattered else {
        return Ok(None);
    };
    let is_closed = data.sides.iter().any(|side| side.is_closed);
    let loops = mesh.loops(problem.points.len())?;
    if is_closed || trim.distance.is_some() || loops.is_empty() {
        return Ok(None);
    }
    let boundary = Boundary::new(&loops, &data.parameters, data.sides);
    let mut outline = Outline {
        loops: Vec::new(),
        faces: Vec::new(),
        distance: mesh::mean_edge(&loops, |[a, b]| problem.points.distance(a, b)),
    };
    let polygons = taken(boundary.piece.iter().cloned().collect(), &mut outline);
    let smooth = smoothing::smooth(&polygons, boundary.range()).into_iter();
    let parameter = |axis: usize, place: f64| boundary.parameter(axis, place);
    outline.loops = smooth.map(|it| in_parameters(it, parameter)).collect();
    Ok(Some(outline))
}

/// The data of a problem, without points that are missing or left out.
fn data(problem: &Problem, v: &Direction) -> Data {
    let u = problem.u();
    let count = problem.points.len();
    let columns = problem.grid().columns;
    let parameters = |k: usize| match problem.is_scattered() {
        true => [u.parameters[k], v.parameters[k]],
        false => [u.parameters[k / columns], v.parameters[k % columns]],
    };
    let mut is_given = match problem.missing() {
        Some(missing) => missing.present(),
        None => vec![true; count],
    };
    for &index in problem.outliers() {
        is_given[index] = false;
    }
    let place = |k: usize| in_space(problem.points.point(k));
    Data {
        parameters: (0..count).map(parameters).collect(),
        places: (problem.points.dimension() > 1).then(|| (0..count).map(place).collect()),
        is_given,
        grid: (!problem.is_scattered()).then(|| problem.grid()),
        sides: [side(u), side(v)],
        poles: problem.poles(),
    }
}

fn side(direction: &Direction) -> Side {
    let (low, high) = KnotVector::new(direction).domain();
    Side {
        low,
        high,
        is_closed: direction.is_closed(),
    }
}

/// A loop whose coordinates are those of cells, or units, in parameters of the surface.
fn in_parameters(mut curve: Nurbs, parameter: impl Fn(usize, f64) -> f64) -> Nurbs {
    let [x, y] = [0, 1].map(|axis| {
        let lane = curve.points.lane(axis).iter();
        let lane = lane.map(|place| parameter(axis, *place));
        lane.collect::<Vec<f64>>()
    });
    curve.points = Points::from_lanes([x, y]);
    curve
}
