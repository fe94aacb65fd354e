//! Scattered points of a surface, compared with those whose parameters are nearest.
//!
//! A point is off by its distance from the plane over the parameters that is nearest to two thirds of its twelve
//! neighbours, as the others may be wrong. The twelve next neighbours give another plane where the surface bends: the
//! doubt is the difference. An isolated point, whose neighbours are much further away than others', is off by that
//! distance.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{Neighbourhood, median};
use crate::data::points::Points;

/// The number of neighbours that make a plane.
const NEIGHBOURS: usize = 12;

/// The number of further neighbours that are compared with them.
const FAR: usize = 12;

/// The number of neighbours to find, as some may be outliers.
const LOOKED_UP: usize = 2 * (NEIGHBOURS + FAR);

/// How often the third of the neighbours that is furthest from a plane is left out.
const STEPS: usize = 3;

/// A point is isolated if its neighbours are this number of times further away than theirs, ...
const BY_ITSELF: f64 = 4.0;

/// ... or than those of most points.
const SPARSE: f64 = 10.0;

/// Scattered points with their neighbours.
pub(crate) struct Cloud<'a> {
    points: &'a Points,
    /// Where each point is.
    parameters: Vec<[f64; 2]>,
    /// The nearest others of each point, the nearest first.
    neighbours: Vec<Vec<u32>>,
    /// Their distance for most points.
    usual_reach: f64,
}

impl<'a> Cloud<'a> {
    /// Scattered points with these parameters, whose range does not matter. Isolated ones are not neighbours.
    pub(crate) fn new(points: &'a Points, [u, v]: &[Vec<f64>; 2], is_isolated: &[bool]) -> Self {
        let scales = [u, v].map(|lane| Points::from_lanes([lane.clone()]).inner_diagonal());
        let scaled = |t: f64, scale: f64| if scale > 0.0 { t / scale } else { t };
        let pairs = u.iter().zip(v);
        let parameters: Vec<[f64; 2]> = pairs
            .map(|(u, v)| [scaled(*u, scales[0]), scaled(*v, scales[1])])
            .collect();
        let leaf = |(i, it): (usize, &[f64; 2])| GeomWithData::new(*it, i as u32);
        let leaves = parameters.iter().enumerate().map(leaf);
        let leaves = leaves.filter(|it| !is_isolated[it.data as usize]);
        let tree: RTree<GeomWithData<[f64; 2], u32>> = RTree::bulk_load(leaves.collect());
        let nearest = |(i, it): (usize, &[f64; 2])| {
            let others = tree.nearest_neighbor_iter(*it).map(|it| it.data);
            others
                .filter(|&other| other != i as u32)
                .take(LOOKED_UP)
                .collect()
        };
        let mut cloud = Self {
            neighbours: parameters.par_iter().enumerate().map(nearest).collect(),
            points,
            parameters,
            usual_reach: 0.0,
        };
        let none = vec![false; points.len()];
        let reaches = (0..points.len()).filter_map(|i| cloud.reach(i, &none));
        cloud.usual_reach = median(reaches.collect());
        cloud
    }

    /// The neighbours of a point that are not left out.
    fn around<'b>(
        &'b self,
        index: usize,
        is_left_out: &'b [bool],
    ) -> impl Iterator<Item = usize> + 'b {
        let all = self.neighbours[index].iter().map(|&it| it as usize);
        all.filter(|&it| !is_left_out[it])
    }

    /// The distance of the last neighbour that makes a plane, in parameters.
    fn reach(&self, index: usize, is_left_out: &[bool]) -> Option<f64> {
        let last = self.around(index, is_left_out).take(NEIGHBOURS).last()?;
        let ([u, v], [s, t]) = (self.parameters[index], self.parameters[last]);
        Some((u - s).hypot(v - t))
    }

    /// Returns true if a point's neighbours are much further away than others'.
    fn is_by_itself(&self, reach: f64, near: &[usize], is_left_out: &[bool]) -> bool {
        let theirs = near.iter().filter_map(|&it| self.reach(it, is_left_out));
        let usual = BY_ITSELF * median(theirs.collect());
        reach > usual.min(SPARSE * self.usual_reach)
    }

    /// The plane nearest to two thirds of some points, evaluated at another one and relative to it, for each
    /// coordinate.
    fn plane(&self, index: usize, some: &[usize], reach: f64) -> Option<Vec<f64>> {
        let [u, v] = self.parameters[index];
        let row = |it: usize| {
            let [s, t] = self.parameters[it];
            Vector3::new(1.0, (s - u) / reach, (t - v) / reach)
        };
        let lanes = self.points.lanes();
        let mut kept = some.to_vec();
        let mut coefficients: Vec<Vector3<f64>> = Vec::new();
        for step in 0..STEPS {
            if step > 0 {
                let off = |it: usize| {
                    let pairs = lanes.iter().zip(&coefficients);
                    pairs.fold(0.0, |off: f64, (lane, plane)| {
                        off.hypot(lane[it] - lane[index] - plane.dot(&row(it)))
                    })
                };
                let mut by_distance: Vec<(f64, usize)> =
                    some.iter().map(|&it| (off(it), it)).collect();
                by_distance.sort_by(|a, b| a.0.total_cmp(&b.0));
                by_distance.truncate(2 * some.len() / 3);
                kept = by_distance.into_iter().map(|(_, it)| it).collect();
            }
            let moments: Matrix3<f64> = kept.iter().map(|&it| row(it) * row(it).transpose()).sum();
            let moments = moments.cholesky()?;
            let solved = lanes.iter().map(|lane| {
                let sums = kept.iter().map(|&it| row(it) * (lane[it] - lane[index]));
                moments.solve(&sums.sum::<Vector3<f64>>())
            });
            coefficients = solved.collect();
        }
        Some(coefficients.iter().map(|plane| plane[0]).collect())
    }
}

impl Neighbourhood for Cloud<'_> {
    const DOUBT: f64 = 2.0;

    fn count(&self) -> usize {
        self.points.len()
    }

    fn off(&self, index: usize, is_left_out: &[bool]) -> Option<f64> {
        let near: Vec<usize> = self.around(index, is_left_out).take(NEIGHBOURS).collect();
        let reach = self.reach(index, is_left_out)?;
        if near.len() < NEIGHBOURS {
            return None;
        }
        if self.is_by_itself(reach, &near, is_left_out) {
            return Some(self.points.distance(index, near[0]));
        }
        let plane = self.plane(index, &near, reach)?;
        Some(plane.into_iter().fold(0.0, f64::hypot))
    }

    fn doubt(&self, index: usize, is_left_out: &[bool]) -> f64 {
        let all: Vec<usize> = self
            .around(index, is_left_out)
            .take(NEIGHBOURS + FAR)
            .collect();
        let Some((near, far)) = all.split_at_checked(NEIGHBOURS) else {
            return 0.0;
        };
        let reach = self.reach(index, is_left_out).unwrap_or(0.0);
        if self.is_by_itself(reach, near, is_left_out) {
            return 0.0;
        }
        let planes = [near, far].map(|some| self.plane(index, some, reach));
        let [Some(near), Some(far)] = planes else {
            return 0.0;
        };
        let pairs = near.iter().zip(&far);
        pairs.fold(0.0, |sum: f64, (a, b)| sum.hypot(a - b))
    }
}
