//! Isolated points in space: their neighbours are far away, and lie on no surface with them.
//!
//! They are left out before the surface is parametrized, as they would distort it: far points get parameters outside of
//! those of the others, where nothing contradicts them.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::median;
use crate::data::points::Points;

/// The number of neighbours.
const NEIGHBOURS: usize = 12;

/// For an isolated point the last of them is this number of times further away than for most points.
const SPARSE: f64 = 4.0;

/// The least extent of points that lie on no surface, as a part of their largest: random points have .4 to .6.
const FLAT: f64 = 0.2;

/// True for each isolated point; false for all points that do not have three coordinates.
pub(crate) fn isolated(points: &Points) -> Vec<bool> {
    let [x, y, z] = points.lanes() else {
        return vec![false; points.len()];
    };
    let place = |i: usize| [x[i], y[i], z[i]];
    let leaf = |i: usize| GeomWithData::new(place(i), i);
    let tree = RTree::bulk_load((0..points.len()).map(leaf).collect());
    let near = |i: usize| tree.nearest_neighbor_iter(place(i)).take(NEIGHBOURS + 1);
    let all = (0..points.len()).into_par_iter();
    let reaches: Vec<f64> = all
        .clone()
        .map(|i| {
            let last = near(i).last();
            last.map_or(0.0, |it| points.distance(i, it.data))
        })
        .collect();
    let usual = median(reaches.clone());
    let is_on_none = |i: usize| !is_flat(near(i).map(|it| Vector3::from(*it.geom())));
    all.map(|i| reaches[i] > SPARSE * usual && is_on_none(i))
        .collect()
}

/// Returns true if points lie near a plane.
fn is_flat(places: impl Iterator<Item = Vector3<f64>>) -> bool {
    let places: Vec<Vector3<f64>> = places.collect();
    let mean = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
    let centred = places.iter().map(|it| it - mean);
    let moments: Matrix3<f64> = centred.map(|it| it * it.transpose()).sum();
    let squares = SymmetricEigen::new(moments).eigenvalues;
    squares.min() <= FLAT * FLAT * squares.max()
}
