//! A mesh with one loop on a rectangle.

use std::sync::Arc;

use super::super::normals::Cloud;
use super::super::pairs::Pairs;
use super::boundary::Boundary;
use super::corners::corners;
use super::gradient::Gradients;
use super::mean_value::solved;
use super::sheet::Sheet;
use super::topology::wrong;
use crate::data::points::Points;
use crate::invalid::Invalid;

/// Where the vertices are on a rectangle, u along its longer sides. These are as long as the mesh is in the mean. A mesh with
/// a ragged boundary ends within the rectangle.
pub(super) fn parameters(cloud: &Cloud, mut sheet: Sheet) -> Result<Pairs, Invalid> {
    let line = Boundary::new(&sheet, &sheet.loops[0]);
    let corners = corners(&line).ok_or_else(|| {
        let count = line.len();
        wrong(format!(
            "the boundary of the mesh has {count} points: a rectangle has four corners"
        ))
    })?;
    if line.is_ragged(&corners.at) {
        sheet.surround(0, line.ring());
    }
    let sheet = sheet.split();
    let values = on_sides(&sheet, corners.at);
    let mut values = solved(&sheet, &values, None)?;
    let mut gradients = Gradients::new(&sheet, &values, None);
    let [width, height] = gradients.steps();
    let turn = |values: &mut Vec<[f64; 2]>, by: fn([f64; 2]) -> [f64; 2]| {
        values.iter_mut().for_each(|it| *it = by(*it));
        Gradients::new(&sheet, values, None)
    };
    if height > width * (1.0 + 1e-9) {
        gradients = turn(&mut values, |[u, v]| [v, 1.0 - u]);
    }
    if gradients.decreases(0) {
        gradients = turn(&mut values, |[u, v]| [1.0 - u, 1.0 - v]);
    }
    let steps = gradients.steps().map(|step| cloud.length(step));
    let points = &values[..cloud.points.len()];
    let lane = |axis: usize| {
        points
            .iter()
            .map(|it| it[axis] * steps[axis])
            .collect::<Vec<f64>>()
    };
    Ok(Pairs::open(Arc::new(Points::from_lanes([
        lane(0),
        lane(1),
    ]))))
}

/// True if the boundary is smooth between four sharp corners.
pub(super) fn is_patch(sheet: &Sheet) -> bool {
    let line = Boundary::new(sheet, &sheet.loops[0]);
    corners(&line).is_some_and(|corners| corners.are_sharp && !line.is_ragged(&corners.at))
}

/// The vertices of the loop on the sides of a square, by lengths of the loop.
fn on_sides(sheet: &Sheet, corners: [usize; 4]) -> Vec<[f64; 2]> {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let line = &sheet.loops[0];
    let boundary = Boundary::new(sheet, line);
    let mut values = vec![[0.0; 2]; sheet.places.len()];
    for side in 0..4 {
        let start = corners[side];
        let end = corners
            .get(side + 1)
            .map_or(corners[0] + line.len(), |end| *end);
        let [low, high] = [start, end].map(|k| boundary.length(k));
        let [from, to] = [square[side], square[(side + 1) % 4]];
        for k in start..end {
            let part = (boundary.length(k) - low) / (high - low);
            let vertex = line[k % line.len()] as usize;
            values[vertex] = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
        }
    }
    values
}
