//! How well parameters unfold points: the share of nearest neighbours in space that are nearest neighbours in (u, v).

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::normals::some;
use super::pairs::{Domain, Pairs};
use crate::data::points::Points;

/// The points that are examined, and the neighbours of each of them.
const SAMPLES: usize = 5_000;
const NEIGHBOURS: usize = 10;

/// For folds fewer points are examined, with more neighbours in space: on a steep surface the nearest points by
/// parameters are not the nearest in space, but not far away there either.
const FOLD_SAMPLES: usize = 1_000;
const FOLD_NEIGHBOURS: usize = 60;

/// Points fold if more than this share of their neighbours by parameters are far away in space.
const FOLDED: f64 = 0.01;

/// How well parameters unfold points.
pub(super) struct Unfolding {
    /// The share of the nearest neighbours in space that are among the nearest by parameters.
    pub kept: f64,
    /// True if two parts of the surface have the same parameters.
    pub folds: bool,
}

/// The nearest neighbours of points in space.
pub(super) struct Neighbourhoods {
    samples: Vec<usize>,
    near: Vec<Vec<usize>>,
    around: Vec<Vec<usize>>,
}

impl Neighbourhoods {
    pub(super) fn new(points: &Points) -> Self {
        let indices: Vec<usize> = (0..points.len()).collect();
        let samples: Vec<usize> = some(&indices, SAMPLES).copied().collect();
        let places: Vec<_> = samples
            .iter()
            .map(|&i| [0, 1, 2].map(|axis| points.lane(axis)[i]))
            .collect();
        Self {
            near: neighbours(&places, SAMPLES, NEIGHBOURS),
            around: neighbours(&places, FOLD_SAMPLES, FOLD_NEIGHBOURS),
            samples,
        }
    }

    /// How well parameters unfold the points.
    pub(super) fn unfolded(&self, pairs: &Pairs) -> Unfolding {
        let places: Vec<_> = self.samples.iter().map(|&i| unrolled(pairs, i)).collect();
        let near = neighbours(&places, SAMPLES, NEIGHBOURS);
        let few = neighbours(&places, FOLD_SAMPLES, NEIGHBOURS);
        Unfolding {
            kept: share(&self.near, &near),
            folds: share(&few, &self.around) < 1.0 - FOLDED,
        }
    }
}

/// The share of some neighbours that are among others.
fn share(near: &[Vec<usize>], others: &[Vec<usize>]) -> f64 {
    let kept = near.iter().zip(others);
    let kept: usize = kept
        .map(|(a, b)| a.iter().filter(|it| b.contains(it)).count())
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

/// The nearest neighbours of some of the places.
fn neighbours(places: &[[f64; 3]], samples: usize, count: usize) -> Vec<Vec<usize>> {
    let with_index = places
        .iter()
        .enumerate()
        .map(|(k, &place)| GeomWithData::new(place, k));
    let tree = RTree::bulk_load(with_index.collect());
    let near = |&k: &usize| {
        let others = tree
            .nearest_neighbor_iter(places[k])
            .map(|it| it.data)
            .filter(|other| *other != k);
        others.take(count).collect()
    };
    let indices: Vec<usize> = (0..places.len()).collect();
    some(&indices, samples).map(near).collect()
}
