//! The cells of a surface: Bézier patches on pieces of its knot spans, found by where they lie.

use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::parts::Homogeneous;
use super::patch::Patch;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The degree up to which a knot span is one cell: polynomials of higher degrees can turn more often.
const SIMPLE: usize = 3;

/// The highest degree of a surface with foot points: the time of a step grows with its square.
pub(super) const MAX_DEGREE: usize = 32;

/// Squared distances that differ by this part are equal but for rounding.
const ROUNDING: f64 = 1e-12;

/// A piece of a knot span, and how its Bézier points depend on the control points of the span.
#[derive(Debug)]
struct Interval {
    low: f64,
    high: f64,
    /// The first of the p + 1 control points.
    first: usize,
    /// (p + 1)², row by row.
    matrix: Vec<f64>,
}

/// A cell in the tree.
#[derive(Debug)]
struct Cell {
    /// The numbers of its intervals.
    place: [u32; 2],
    /// The box around its Bézier points.
    hull: AABB<[f64; 3]>,
}

impl RTreeObject for Cell {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.hull
    }
}

impl PointDistance for Cell {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        self.hull.distance_2(point)
    }
}

/// A surface in cells.
#[derive(Debug)]
pub(super) struct Cells {
    intervals: [Vec<Interval>; 2],
    degrees: [usize; 2],
    closed: [bool; 2],
    /// The control net, row by row.
    net: Vec<Homogeneous>,
    columns: usize,
    tree: RTree<Cell>,
}

impl Cells {
    /// The cells of a surface whose control points are at these places.
    pub(super) fn new(surface: &Nurbs, v: &KnotVector, place: impl Fn(usize) -> [f64; 3]) -> Self {
        let lifted = |index: usize| {
            let ([x, y, z], w) = (place(index), surface.weight(index));
            [w * x, w * y, w * z, w]
        };
        let mut cells = Self {
            intervals: [intervals(&surface.u), intervals(v)],
            degrees: [surface.u.degree, v.degree],
            closed: [surface.u.closed, v.closed],
            net: (0..surface.points.len()).map(lifted).collect(),
            columns: surface.columns(),
            tree: RTree::new(),
        };
        let mut patch = Patch::new(cells.degrees);
        let mut all = Vec::with_capacity(cells.intervals[0].len() * cells.intervals[1].len());
        for i in 0..cells.intervals[0].len() {
            for j in 0..cells.intervals[1].len() {
                let place = [i as u32, j as u32];
                cells.load(place, &mut patch);
                all.push(Cell {
                    place,
                    hull: hull(&patch.net),
                });
            }
        }
        cells.tree = RTree::bulk_load(all);
        cells
    }

    /// Room for searches.
    pub(super) fn search(&self) -> Search<'_> {
        Search {
            cells: self,
            patch: Patch::new(self.degrees),
        }
    }

    /// The Bézier points of a cell, `M_u X M_vᵀ`.
    fn load(&self, place: [u32; 2], patch: &mut Patch) {
        let [along, across] = [0, 1].map(|axis| &self.intervals[axis][place[axis] as usize]);
        let [rows, columns] = self.degrees.map(|degree| degree + 1);
        for (i, row) in patch.net.chunks_exact_mut(columns).enumerate() {
            let mut line = [[0.0; 4]; MAX_DEGREE + 1];
            for k in 0..rows {
                let factor = along.matrix[i * rows + k];
                let start = (along.first + k) * self.columns + across.first;
                let net = &self.net[start..start + columns];
                for (sum, point) in line.iter_mut().zip(net) {
                    (0..4).for_each(|c| sum[c] += factor * point[c]);
                }
            }
            for (j, point) in row.iter_mut().enumerate() {
                *point = [0.0; 4];
                let factors = &across.matrix[j * columns..(j + 1) * columns];
                for (factor, x) in factors.iter().zip(&line) {
                    (0..4).for_each(|c| point[c] += factor * x[c]);
                }
            }
        }
    }

    /// The index of the interval of a direction with a parameter, and the position in it from 0 to 1.
    fn place(&self, axis: usize, parameter: f64) -> (u32, f64) {
        let intervals = &self.intervals[axis];
        let number = intervals.partition_point(|interval| interval.high < parameter);
        let number = number.min(intervals.len() - 1);
        let Interval { low, high, .. } = intervals[number];
        let part = ((parameter - low) / (high - low)).clamp(0.0, 1.0);
        (number as u32, part)
    }

    /// The parameter of a direction at a part of an interval. That of the end of a closed direction is
    /// that of its start.
    fn parameter(&self, axis: usize, number: u32, part: f64) -> f64 {
        let intervals = &self.intervals[axis];
        let interval = &intervals[number as usize];
        let t = (1.0 - part) * interval.low + part * interval.high;
        match self.closed[axis] && t >= intervals[intervals.len() - 1].high {
            true => intervals[0].low,
            false => t,
        }
    }
}

/// Searches in cells, one after the other.
#[derive(Debug)]
pub(super) struct Search<'a> {
    cells: &'a Cells,
    patch: Patch,
}

impl Search<'_> {
    /// The parameters of the point of the surface that is nearest to a point, and its squared distance,
    /// which is not larger than that at `known` parameters.
    pub(super) fn foot_point(
        &mut self,
        point: [f64; 3],
        known: Option<[f64; 2]>,
    ) -> ([f64; 2], f64) {
        let (mut best, mut pair) = (f64::INFINITY, [f64::NAN; 2]);
        if let Some(known) = known {
            let places = [0, 1].map(|axis| self.cells.place(axis, known[axis]));
            let cell = places.map(|(number, _)| number);
            self.cells.load(cell, &mut self.patch);
            let foot = self.patch.descend(places.map(|(_, part)| part), point);
            best = foot.square;
            pair = [0, 1].map(|axis| self.cells.parameter(axis, cell[axis], foot.at[axis]));
        }
        for (cell, nearest) in self.cells.tree.nearest_neighbor_iter_with_distance_2(point) {
            if nearest > best * (1.0 + ROUNDING) {
                break;
            }
            self.cells.load(cell.place, &mut self.patch);
            let Some(foot) = self.patch.nearest(point, best) else {
                continue;
            };
            let parameter =
                |axis: usize| self.cells.parameter(axis, cell.place[axis], foot.at[axis]);
            let here = [parameter(0), parameter(1)];
            let nearer = foot.square < best * (1.0 - ROUNDING);
            let equal = foot.square <= best * (1.0 + ROUNDING);
            if nearer || equal && here < pair {
                pair = here;
            }
            best = best.min(foot.square);
        }
        (pair, best)
    }
}

/// The number of cells of a knot span.
pub(super) fn pieces(degree: usize) -> usize {
    degree.div_ceil(SIMPLE).max(1)
}

/// The pieces of all spans of a direction.
fn intervals(knots: &KnotVector) -> Vec<Interval> {
    let pieces = pieces(knots.degree);
    let span = |span: usize| {
        let (low, high) = (knots.knots[span], knots.knots[span + 1]);
        let at = move |piece: usize| {
            let part = piece as f64 / pieces as f64;
            (1.0 - part) * low + part * high
        };
        (0..pieces).map(move |piece| {
            let (low, high) = (at(piece), at(piece + 1));
            Interval {
                low,
                high,
                first: span - knots.degree,
                matrix: extraction(knots, span, low, high),
            }
        })
    };
    knots.spans().into_iter().flat_map(span).collect()
}

/// The matrix from the p + 1 control points of a span to the Bézier points on a part of it: point k
/// is the blossom at p − k times `low` and k times `high` (PT97 §5.3; Ramshaw).
fn extraction(knots: &KnotVector, span: usize, low: f64, high: f64) -> Vec<f64> {
    let (p, knots) = (knots.degree, &knots.knots);
    let size = p + 1;
    let mut matrix = Vec::with_capacity(size * size);
    for k in 0..size {
        // Row j: how the point of de Boor's scheme depends on the control points.
        let mut points: Vec<Vec<f64>> = (0..size)
            .map(|j| (0..size).map(|i| f64::from(u8::from(i == j))).collect())
            .collect();
        for r in 1..size {
            let t = if r <= p - k { low } else { high };
            for j in (r..size).rev() {
                let i = span - p + j;
                let part = (t - knots[i]) / (knots[i + size - r] - knots[i]);
                let (before, rest) = points.split_at_mut(j);
                for (x, y) in rest[0].iter_mut().zip(&before[j - 1]) {
                    *x = (1.0 - part) * y + part * *x;
                }
            }
        }
        matrix.extend_from_slice(&points[p]);
    }
    matrix
}

/// The box around projected control points.
fn hull(net: &[Homogeneous]) -> AABB<[f64; 3]> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in net {
        for c in 0..3 {
            let x = point[c] / point[3];
            low[c] = low[c].min(x);
            high[c] = high[c].max(x);
        }
    }
    AABB::from_corners(low, high)
}
