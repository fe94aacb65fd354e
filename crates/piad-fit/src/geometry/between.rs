//! Between the data: curves and surfaces that leave them between neighbours.
//!
//! Errors at the data say nothing of what is between them. There the straight line between two points of a curve, and
//! the bilinear patch between four of a grid, are what the data say, but for the [`freedom`](super::freedom) that they
//! leave where they bend. A curve that is further away from them than that leaves its data.

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

/// Gaps and cells in which the fit is away from its data by more than this part of the largest distance, or of what is
/// allowed, are looked at in small steps: the places that are looked at first miss up to a quarter of a bump.
const DOUBTFUL: f64 = 0.7;

/// A place between neighbouring data that the fit has left.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Excursion {
    /// The data point before it, of a surface that with the lowest indices.
    pub index: usize,
    /// How far the fit is from the segment, or the bilinear patch, between the neighbours.
    pub distance: f64,
    /// How far it may be, but for its distances at the data: the freedom that these leave.
    pub free: f64,
}

impl Excursion {
    /// The place where a fit leaves its neighbours by most beyond their freedom; `None` if it does so nowhere, or if data
    /// have no neighbours as they are scattered. Places where it is far less than is `allowed` are looked at roughly.
    pub(crate) fn of(setup: &Setup, control_points: &Points, allowed: f64) -> Option<Self> {
        if setup.is_scattered() {
            return None;
        }
        let gaps = Gaps::new(setup);
        Self::beyond(gaps.freedom(), &gaps, control_points, allowed)
    }

    /// The same, with the part of the freedom that a fit should not need: half of that of curves, and less along long
    /// edges beside densely sampled bends.
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

    /// By how much the fit is further away than the data leave it free.
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

/// By how much a fit leaves its data in each gap between neighbours beyond their freedom, of grids in each cell, row by
/// row; zero where it does not. Scattered data have no gaps.
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

/// How far a surface of scattered data leaves their bounding box, as a part of its diagonal.
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
