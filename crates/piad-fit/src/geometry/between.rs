//! Between the data: curves and surfaces that are further from two neighbouring points than these are apart.
//!
//! Errors at the data say nothing of what is between them. There the straight line between two points of a curve, and
//! the bilinear patch between four of a grid, are what the data say, as far as the points are apart. A curve that is
//! further away from them, at the same parameter, leaves its data.
//!
//! Points of one coordinate and grids may go beyond a flat place beside a steep one: there the distance of the
//! neighbours is the largest among those of a gap and of the gaps around it.

use std::fmt;

use super::evaluation::Geometry;
use crate::basis::direction::Direction;
use crate::data::points::Points;
use crate::setup::Setup;

/// Places at which gaps and spans are looked at, as parts of them.
const PLACES: [f64; 3] = [0.25, 0.5, 0.75];

/// The same of surfaces, in each direction.
const PLACES_OF_SURFACES: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// Only the middle is looked at where there are more gaps than this.
const MANY: usize = 100_000;

/// Gaps and cells in which the fit is away from its data by more than this part of what is allowed are looked at in
/// [`CLOSER`] steps: the places that are looked at first miss up to a quarter of a bump.
const DOUBTFUL: f64 = 0.7;

/// See [`DOUBTFUL`].
const CLOSER: usize = 16;

/// About how many places are evaluated at a time.
const AT_ONCE: usize = 16_384;

/// A place between neighbouring data that the fit has left.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Excursion {
    /// The data point before it, of a surface that with the lowest indices.
    pub index: usize,
    /// How far the fit is from the straight line, or the bilinear patch, between the neighbours.
    pub distance: f64,
    /// How far the neighbours are apart.
    pub apart: f64,
}

impl Excursion {
    /// The place where a fit leaves its neighbours by most beyond what they are apart and what is `allowed`; `None` if
    /// there is none, or if data have no neighbours as they are scattered.
    pub(crate) fn of(setup: &Setup, control_points: &Points, allowed: f64) -> Option<Self> {
        if setup.is_scattered() {
            return None;
        }
        let gaps = Gaps::new(setup);
        let apart = gaps.apart();
        let mut doubtful: Vec<usize> = Vec::new();
        gaps.each_distance(control_points, |cell, distance| {
            if distance > DOUBTFUL * (apart[cell] + allowed) && doubtful.last() != Some(&cell) {
                doubtful.push(cell);
            }
        });
        doubtful.sort_unstable();
        doubtful.dedup();
        let mut farthest: Option<(f64, Self)> = None;
        gaps.each_distance_in(&doubtful, control_points, |cell, distance| {
            let (index, apart) = (gaps.first(cell), apart[cell]);
            let excess = distance - apart - allowed;
            if excess > farthest.map_or(0.0, |(most, _)| most) {
                let excursion = Self {
                    index,
                    distance,
                    apart,
                };
                farthest = Some((excess, excursion));
            }
        });
        farthest.map(|(_, excursion)| excursion)
    }
}

impl fmt::Display for Excursion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            index,
            distance,
            apart,
        } = self;
        write!(
            f,
            "between point {index} and its neighbours, which are {apart:.3e} apart, the fit is {distance:.3e} away from \
             them"
        )
    }
}

/// How far a surface of scattered data leaves their bounding box, as a part of its diagonal.
pub(crate) fn outside(setup: &Setup, control_points: &Points) -> f64 {
    let geometry = Geometry::new(setup, control_points);
    let mut places = setup.directions().map(of_spans);
    let (u, v) = (
        places.next().unwrap_or_default(),
        places.next().unwrap_or_default(),
    );
    let extents = setup.points.extents();
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

/// The gaps between successive data of a direction.
struct Line {
    /// The data at both ends.
    ends: Vec<[usize; 2]>,
    /// Their parameters.
    ranges: Vec<[f64; 2]>,
    places: Vec<Place>,
}

/// A place in a gap.
#[derive(Clone, Copy)]
struct Place {
    parameter: f64,
    gap: usize,
    /// The part of the gap that is before it.
    part: f64,
}

impl Line {
    /// With places at some parts of each gap, and of each span of knots, as these can be shorter.
    fn new(direction: &Direction, parts: &[f64]) -> Self {
        let all = direction.explicit_parameters();
        let (count, gaps) = (direction.parameters.len(), all.len() - 1);
        let inside = |[from, to]: [f64; 2]| {
            let parts = parts.iter();
            parts.map(move |part| (1.0 - part) * from + part * to)
        };
        let place = |gap: usize, parameter: f64| Place {
            parameter,
            gap,
            part: (parameter - all[gap]) / (all[gap + 1] - all[gap]),
        };
        let in_gaps = (0..gaps).flat_map(|gap| {
            let parameters = inside([all[gap], all[gap + 1]]);
            parameters.map(move |t| place(gap, t))
        });
        let in_spans = spans(direction).flat_map(inside).filter_map(|t| {
            let gap = all.partition_point(|start| *start <= t).checked_sub(1)?;
            (gap < gaps).then(|| place(gap, t))
        });
        Self {
            ends: (0..gaps).map(|i| [i, (i + 1) % count]).collect(),
            ranges: (0..gaps).map(|i| [all[i], all[i + 1]]).collect(),
            places: in_gaps.chain(in_spans).collect(),
        }
    }

    /// Across a curve: one line.
    fn single() -> Self {
        Self {
            ends: vec![[0, 0]],
            ranges: vec![[0.0; 2]],
            places: vec![Place {
                parameter: 0.0,
                gap: 0,
                part: 0.0,
            }],
        }
    }

    fn count(&self) -> usize {
        self.ends.len()
    }

    /// Places in small steps in one gap.
    fn closer(&self, gap: usize) -> Vec<Place> {
        let [from, to] = self.ranges[gap];
        let place = |part: f64| Place {
            parameter: (1.0 - part) * from + part * to,
            gap,
            part,
        };
        let steps = if from < to { CLOSER } else { 2 };
        (1..steps).map(|k| place(k as f64 / steps as f64)).collect()
    }
}

/// The spans of the knots of a direction.
fn spans(direction: &Direction) -> impl Iterator<Item = [f64; 2]> {
    let (low, high) = direction.basis.domain();
    let knots = direction.basis.knots().unwrap_or_default().to_vec();
    let pairs = 1..knots.len();
    let spans = pairs.map(move |i| [knots[i - 1], knots[i]]);
    spans.filter(move |&[from, to]| low <= from && from < to && to <= high)
}

/// The gaps of a curve, or the cells of a grid.
struct Gaps<'a> {
    setup: &'a Setup,
    points: &'a Points,
    along: Line,
    across: Line,
    /// The number of data in a row.
    columns: usize,
}

impl<'a> Gaps<'a> {
    fn new(setup: &'a Setup) -> Self {
        let v = setup.v();
        let parts: &[f64] = match v {
            _ if setup.grid().count() > MANY => &[0.5],
            Some(_) => &PLACES_OF_SURFACES,
            None => &PLACES,
        };
        Self {
            setup,
            points: &setup.points,
            along: Line::new(setup.u(), parts),
            across: v.map_or_else(Line::single, |v| Line::new(v, parts)),
            columns: setup.grid().columns,
        }
    }

    /// The data at the corners of a cell.
    fn corners(&self, cell: usize) -> [[usize; 2]; 2] {
        let (row, column) = (cell / self.across.count(), cell % self.across.count());
        let [left, right] = self.across.ends[column];
        self.along.ends[row].map(|row| [left, right].map(|column| row * self.columns + column))
    }

    fn first(&self, cell: usize) -> usize {
        self.corners(cell)[0][0]
    }

    fn count(&self) -> usize {
        self.along.count() * self.across.count()
    }

    /// How far the corners of each cell are apart, infinitely where one of them is missing.
    fn apart(&self) -> Vec<f64> {
        let missing = self.setup.missing();
        let own = |cell: usize| {
            let [[a, b], [c, d]] = self.corners(cell);
            if missing.is_some_and(|missing| [a, b, c, d].iter().any(|&i| missing.contains(i))) {
                return f64::INFINITY;
            }
            let pairs = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)];
            let distance = |(i, j)| self.points.distance(i, j);
            pairs.into_iter().map(distance).fold(0.0, f64::max)
        };
        let own: Vec<f64> = (0..self.count()).map(own).collect();
        match self.setup.v().is_none() && self.points.dimension() > 1 {
            true => own,
            false => self.largest_around(&own),
        }
    }

    /// The largest among each cell and those around it.
    fn largest_around(&self, own: &[f64]) -> Vec<f64> {
        let (rows, columns) = (self.along.count(), self.across.count());
        let largest = |cell: usize| {
            let (row, column) = (cell / columns, cell % columns);
            let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
            let cells = near(row, rows);
            let cells =
                cells.flat_map(|i| near(column, columns).map(move |j| own[i * columns + j]));
            cells.fold(0.0, f64::max)
        };
        (0..own.len()).map(largest).collect()
    }

    /// Each cell with the distance at each of its places.
    fn each_distance(&self, control_points: &Points, mut visit: impl FnMut(usize, f64)) {
        let geometry = Geometry::new(self.setup, control_points);
        let across = &self.across.places;
        for along in self.along.places.chunks((AT_ONCE / across.len()).max(1)) {
            self.distances_at(&geometry, along, across, &mut visit);
        }
    }

    /// Some cells with the distances at places in small steps.
    fn each_distance_in(
        &self,
        cells: &[usize],
        control_points: &Points,
        mut visit: impl FnMut(usize, f64),
    ) {
        let geometry = Geometry::new(self.setup, control_points);
        let columns = self.across.count();
        for cell in cells {
            let (along, across) = (
                self.along.closer(cell / columns),
                self.across.closer(cell % columns),
            );
            self.distances_at(&geometry, &along, &across, &mut visit);
        }
    }

    fn distances_at(
        &self,
        geometry: &Geometry<'_>,
        along: &[Place],
        across: &[Place],
        visit: &mut impl FnMut(usize, f64),
    ) {
        let parameters =
            |places: &[Place]| places.iter().map(|it| it.parameter).collect::<Vec<_>>();
        let fit = geometry.evaluate(&parameters(along), &parameters(across));
        let pairs = along
            .iter()
            .flat_map(|a| across.iter().map(move |b| (a, b)));
        for (index, (a, b)) in pairs.enumerate() {
            let cell = a.gap * self.across.count() + b.gap;
            visit(cell, self.distance(cell, [a.part, b.part], &fit, index));
        }
    }

    /// How far point `index` of a fit is from the bilinear patch between the corners of a cell, at parts of it.
    fn distance(&self, cell: usize, [s, r]: [f64; 2], fit: &Points, index: usize) -> f64 {
        let [[a, b], [c, d]] = self.corners(cell);
        let lanes = fit.lanes().iter().zip(self.points.lanes());
        let differences = lanes.map(|(fit, data)| {
            let low = (1.0 - r) * data[a] + r * data[b];
            let high = (1.0 - r) * data[c] + r * data[d];
            fit[index] - ((1.0 - s) * low + s * high)
        });
        differences.fold(0.0, f64::hypot)
    }
}

#[cfg(test)]
mod tests;
