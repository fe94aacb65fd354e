//! Deviations between the data: curves and surfaces that are far from them between neighbours.
//!
//! Errors at the data do not bound the deviation between them. The reference is the straight line between two points of
//! a curve, and the bilinear patch between four of a grid. Where the data bend, they leave some
//! [`freedom`](super::freedom). A curve that is further away than that deviates from its data.

mod gaps;
mod line;
mod segment;

use std::fmt;

use super::evaluation::Geometry;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::setup::Setup;
use gaps::{AT_ONCE, Gaps};
use line::spans;

/// Gaps and cells whose deviation is above this part of the largest one, or of the allowed one, are sampled in small
/// steps: the coarse samples miss up to a quarter of a bump.
const DOUBTFUL: f64 = 0.7;

/// A place between neighbouring data at which the fit deviates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Excursion {
    /// The data point before it, of a surface that with the lowest indices.
    pub index: usize,
    /// The distance of the fit from the segment, or the bilinear patch, between the neighbours.
    pub distance: f64,
    /// The allowed distance, apart from the distances at the data: the freedom that these leave.
    pub free: f64,
}

impl Excursion {
    /// The place with the largest deviation beyond the freedom; `None` if there is none, or if data have no neighbours
    /// as they are scattered. Places far below `allowed` are sampled coarsely.
    pub(crate) fn of(setup: &Setup, control_points: &Points, allowed: f64) -> Option<Self> {
        if setup.is_scattered() {
            return None;
        }
        let gaps = Gaps::new(setup);
        Self::beyond(gaps.freedom(), &gaps, control_points, allowed)
    }

    /// The same, with the part of the freedom that a fit should use: half for curves, and less along long edges beside
    /// densely sampled bends.
    pub(crate) fn of_part(setup: &Setup, control_points: &Points, allowed: f64) -> Option<Self> {
        if setup.is_scattered() || setup.v().is_some() {
            return Self::of(setup, control_points, allowed);
        }
        let gaps = Gaps::new(setup);
        let freedom = gaps.freedom().into_iter().zip(gaps.parts_beside_bends());
        let freedom = freedom.map(|(free, part)| 0.5 * part * free).collect();
        Self::beyond(freedom, &gaps, control_points, allowed)
    }

    fn beyond(
        freedom: Vec<f64>,
        gaps: &Gaps<'_>,
        control_points: &Points,
        allowed: f64,
    ) -> Option<Self> {
        let mut distances = gaps.distances(control_points);
        let farthest = |distances: &[f64]| {
            let all = distances.iter().zip(&freedom).enumerate();
            let all = all.map(|(cell, (distance, free))| Self {
                index: gaps.first(cell),
                distance: *distance,
                free: *free,
            });
            all.filter(|it| it.excess() > 0.0).reduce(|most, it| {
                match it.excess() > most.excess() {
                    true => it,
                    false => most,
                }
            })
        };
        let most = farthest(&distances).map_or(0.0, Self::excess);
        let may_be_farther =
            |cell: &usize| distances[*cell] > DOUBTFUL * (freedom[*cell] + most.max(allowed));
        let doubtful: Vec<usize> = (0..gaps.count()).filter(may_be_farther).collect();
        gaps.look_closer(control_points, &doubtful, &mut distances);
        farthest(&distances)
    }

    /// The deviation beyond the freedom.
    pub fn excess(self) -> f64 {
        self.distance - self.free
    }
}

impl fmt::Display for Excursion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            index,
            distance,
            free,
        } = self;
        write!(
            f,
            "between point {index} and its neighbours the fit is {distance:.3e} away from straight lines, where the data \
             leave it {free:.3e} of freedom"
        )
    }
}

/// The deviation beyond the freedom in each gap between neighbours, of grids in each cell, row by row; zero where there
/// is none. Scattered data have no gaps.
pub fn excesses(setup: &Setup, control_points: &Points) -> Vec<f64> {
    if setup.is_scattered() {
        return Vec::new();
    }
    let gaps = Gaps::new(setup);
    let pairs = gaps
        .distances(control_points)
        .into_iter()
        .zip(gaps.freedom());
    let excesses = pairs.map(|(distance, free)| (distance - free).max(0.0));
    gaps.of_all_data(excesses.collect())
}

/// The distance of a surface of scattered data from their bounding box, as a part of its diagonal.
pub(crate) fn outside(setup: &Setup, control_points: &Points) -> f64 {
    let geometry = Geometry::new(setup, control_points);
    let mut places = setup.directions().map(of_spans);
    let (u, v) = (
        places.next().unwrap_or_default(),
        places.next().unwrap_or_default(),
    );
    let extents = setup.extents();
    let mut farthest = 0.0;
    for u in u.chunks((AT_ONCE / v.len().max(1)).max(1)) {
        let points = geometry.evaluate(u, &v);
        for (extent, lane) in extents.iter().zip(points.lanes()) {
            let beyond = |x: &f64| (extent.low - x).max(x - extent.high);
            farthest = lane.iter().map(beyond).fold(farthest, f64::max);
        }
    }
    farthest / setup.diagonal()
}

/// Parameters in the spans of a direction: both ends of each, and two between.
fn of_spans(direction: &Direction) -> Vec<f64> {
    let inside =
        |[from, to]: [f64; 2]| [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|s| (1.0 - s) * from + s * to);
    let (_, high) = direction.basis.domain();
    spans(direction).flat_map(inside).chain([high]).collect()
}

#[cfg(test)]
mod tests;
