//! How well parameters unfold points: the share of nearest neighbours in space that are nearest neighbours in (u, v).

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::normals::some;
use super::pairs::{Domain, Pairs};
use crate::data::points::Points;

/// The points that are looked at.
const SAMPLES: usize = 5_000;

/// The neighbours of each of them.
const NEIGHBOURS: usize = 10;

/// The share of the neighbours in space that are neighbours by parameters.
pub(super) fn share_kept(points: &Points, pairs: &Pairs) -> f64 {
    let indices: Vec<usize> = (0..points.len()).collect();
    let samples: Vec<usize> = some(&indices, SAMPLES).copied().collect();
    let in_space = |&i: &usize| [0, 1, 2].map(|axis| points.lane(axis)[i]);
    let by_parameters = |&i: &usize| unrolled(pairs, i);
    let near = neighbours(samples.iter().map(in_space).collect());
    let near_by_parameters = neighbours(samples.iter().map(by_parameters).collect());
    let kept = near.iter().zip(&near_by_parameters);
    let kept: usize = kept
        .map(|(a, b)| a.iter().filter(|other| b.contains(other)).count())
        .sum();
    let all: usize = near.iter().map(Vec::len).sum();
    kept as f64 / all.max(1) as f64
}

/// The place of parameters as far from others as these are on their surface: a closed direction is a circle, poles are
/// those of a sphere.
pub(super) fn unrolled(pairs: &Pairs, i: usize) -> [f64; 3] {
    let [u, v] = [0, 1].map(|axis| pairs.values.lane(axis)[i]);
    let Domain::Closed(period) = pairs.domains[0] else {
        return [u, v, 0.0];
    };
    let radius = period / std::f64::consts::TAU;
    let (sin, cos) = (u / radius).sin_cos();
    match pairs.domains[1] {
        Domain::Between { .. } => {
            let (height, out) = (v / radius).sin_cos();
            [radius * out * cos, radius * out * sin, radius * height]
        }
        Domain::Data | Domain::Closed(_) => [radius * cos, radius * sin, v],
    }
}

/// The nearest neighbours of each place.
fn neighbours(places: Vec<[f64; 3]>) -> Vec<Vec<usize>> {
    let with_index = places
        .iter()
        .enumerate()
        .map(|(k, &place)| GeomWithData::new(place, k));
    let tree = RTree::bulk_load(with_index.collect());
    let near = |(k, place): (usize, &[f64; 3])| {
        let others = tree
            .nearest_neighbor_iter(*place)
            .map(|it| it.data)
            .filter(|other| *other != k);
        others.take(NEIGHBOURS).collect()
    };
    places.iter().enumerate().map(near).collect()
}
