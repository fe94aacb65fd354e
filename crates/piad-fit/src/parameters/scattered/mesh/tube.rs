//! A mesh with two loops: u goes around, and v from one loop to the other.

use std::sync::Arc;

use super::super::normals::Cloud;
use super::super::pairs::{Domain, Pairs};
use super::boundary::Boundary;
use super::cut::Cut;
use super::gradient::Gradients;
use super::mean_value::solved;
use super::sheet::Sheet;
use super::topology::wrong;
use crate::data::points::Points;
use crate::invalid::Invalid;

/// Where the vertices are on a tube whose lengths are those of the mesh in the mean.
///
/// Both loops start where the shortest path between them ends, and the second one is then turned so that u and v are at
/// right angles in the mean: adding a multiple of v to u keeps all means.
pub(super) fn parameters(cloud: &Cloud, mut sheet: Sheet) -> Result<Pairs, Invalid> {
    for number in 0..sheet.loops.len() {
        let line = Boundary::new(&sheet, &sheet.loops[number]);
        if line.is_ragged(&[0]) {
            sheet.surround(number, line.ring());
        }
    }
    let sheet = &sheet.split();
    let cut = Cut::new(sheet).ok_or_else(|| wrong("the loops of the mesh are not connected"))?;
    let mut values = vec![[0.0; 2]; sheet.places.len()];
    let ends = [cut.path.first(), cut.path.last()];
    for (number, (line, start)) in sheet.loops.iter().zip(ends).enumerate() {
        let mut line = line.clone();
        // The mesh is on the left of both loops: u increases along the first one, and against the second one.
        if number == 1 {
            line.reverse();
        }
        let start = line.iter().position(|vertex| Some(vertex) == start);
        line.rotate_left(start.unwrap_or(0));
        let place = |k: usize| sheet.places[line[k % line.len()] as usize];
        let step = |k: usize| (place(k + 1) - place(k)).norm();
        let whole: f64 = (0..line.len()).map(step).sum();
        let mut length = 0.0;
        for (k, &vertex) in line.iter().enumerate() {
            values[vertex as usize] = [length / whole, number as f64];
            length += step(k);
        }
    }
    let left = cut.left(sheet);
    let mut values = solved(sheet, &values, Some(&left))?;
    let shear = Gradients::new(sheet, &values, Some(&left)).shear();
    values.iter_mut().for_each(|[u, v]| *u += shear * *v);
    let gradients = Gradients::new(sheet, &values, Some(&left));
    let is_turned = gradients.decreases(1);
    let [period, height] = gradients.steps().map(|step| cloud.length(step));
    let (around, along): (Vec<f64>, Vec<f64>) = values[..cloud.points.len()]
        .iter()
        .map(|&[u, v]| if is_turned { [-u, 1.0 - v] } else { [u, v] })
        .map(|[u, v]| (wrapped(u) * period, v * height))
        .unzip();
    Ok(Pairs {
        values: Arc::new(Points::from_lanes([around, along])),
        domains: [Domain::Closed(period), Domain::Data],
    })
}

/// The part of a number beyond a whole one.
fn wrapped(u: f64) -> f64 {
    let part = u.rem_euclid(1.0);
    if part < 1.0 { part } else { 0.0 }
}
