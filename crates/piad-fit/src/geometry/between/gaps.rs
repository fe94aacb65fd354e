//! The gaps between the data of a curve and the cells of a grid, and how far a fit is from the data in them.

use super::line::{Line, Place, parameters};
use super::segment;
use crate::basis::direction::Direction;
use crate::data::grid::Grid;
use crate::data::points::{Points, normalizing_scale};
use crate::geometry::evaluation::Geometry;
use crate::geometry::freedom;
use crate::invalid::Side;
use crate::setup::Setup;

/// Places at which gaps and spans are examined, as parts of them.
const PLACES: [f64; 3] = [0.25, 0.5, 0.75];

/// The same of surfaces, in each direction.
const PLACES_OF_SURFACES: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// Only the middle is examined if there are more gaps than this.
const MANY: usize = 100_000;

/// The sides of a cell are parallel if the sine of their angle has a square below this.
const SINGULAR: f64 = 1e-9;

/// The approximate number of places evaluated at a time.
pub(super) const AT_ONCE: usize = 16_384;

/// The gaps of a curve, or the cells of a grid.
pub(super) struct Gaps<'a> {
    setup: &'a Setup,
    points: &'a Points,
    /// The data of a curve that are not left out, or the rows of a grid.
    rows: Vec<usize>,
    along: Line,
    across: Line,
    /// The number of data in a row.
    columns: usize,
}

impl<'a> Gaps<'a> {
    pub(super) fn new(setup: &'a Setup) -> Self {
        let v = setup.v();
        let rows = setup.rows();
        let all: Vec<usize> = (0..setup.grid().columns).collect();
        let parts: &[f64] = match v {
            _ if setup.grid().count() > MANY => &[0.5],
            Some(_) => &PLACES_OF_SURFACES,
            None => &PLACES,
        };
        Self {
            setup,
            points: &setup.points,
            along: Line::new(setup.u(), &rows, parts),
            across: v.map_or_else(Line::single, |v| Line::new(v, &all, parts)),
            rows,
            columns: setup.grid().columns,
        }
    }

    /// The data at the corners of a cell.
    fn corners(&self, cell: usize) -> [[usize; 2]; 2] {
        let (row, column) = (cell / self.across.count(), cell % self.across.count());
        let [left, right] = self.across.ends[column];
        self.along.ends[row].map(|row| [left, right].map(|column| row * self.columns + column))
    }

    pub(super) fn first(&self, cell: usize) -> usize {
        self.corners(cell)[0][0]
    }

    /// Values of gaps as those between all successive data of a curve, of which some can be left out.
    pub(super) fn of_all_data(&self, values: Vec<f64>) -> Vec<f64> {
        let data = self.setup.u().parameters.len();
        if self.rows.len() == data {
            return values;
        }
        let closed = self.setup.u().is_closed();
        let value = |index: usize| {
            let before = self
                .rows
                .partition_point(|&row| row <= index)
                .checked_sub(1);
            let gap = before.or(closed.then(|| values.len() - 1));
            gap.and_then(|gap| values.get(gap)).copied().unwrap_or(0.0)
        };
        let count = data - usize::from(!closed);
        (0..count).map(value).collect()
    }

    pub(super) fn count(&self) -> usize {
        self.along.count() * self.across.count()
    }

    /// The freedom of each cell: that which its bends leave, but no more than its corners are apart, and infinite where
    /// one of these is missing; none where edges are data. Beside ends at which the fit has a zero derivative, it is
    /// how far these are apart.
    pub(super) fn freedom(&self) -> Vec<f64> {
        if self.setup.polyline {
            return vec![0.0; self.count()];
        }
        let missing = self.setup.missing();
        let is_whole = |cell: usize| {
            let corners = self.corners(cell);
            missing.is_none_or(|missing| !corners.iter().flatten().any(|&i| missing.contains(i)))
        };
        let (mut bends, apart) = (self.bends(), self.apart());
        self.pass_on(&mut bends);
        let ratio = weight_ratio(self.setup);
        bends.iter_mut().for_each(|bend| *bend *= ratio);
        let pairs = bends.into_iter().zip(apart).enumerate();
        let free = pairs.map(|(cell, (bend, apart))| match is_whole(cell) {
            true if self.is_beside_copies(cell) => apart,
            true => freedom::of_bend(bend).min(apart),
            false => f64::INFINITY,
        });
        free.collect()
    }

    /// The part of its freedom that each gap of a curve should have at most: less if it is long beside densely sampled
    /// bends.
    pub(super) fn parts_beside_bends(&self) -> Vec<f64> {
        let ends = &self.along.ends;
        let (count, is_closed) = (ends.len(), self.setup.u().is_closed());
        let part = |gap: usize| {
            let [from, to] = ends[gap];
            let before = (is_closed || gap > 0).then(|| ends[(gap + count - 1) % count]);
            let after = (is_closed || gap + 1 < count).then(|| ends[(gap + 1) % count]);
            let before = before.map(|[first, _]| [first, from, to]);
            let after = after.map(|[_, last]| [last, to, from]);
            let parts = before.into_iter().chain(after);
            let parts = parts.map(|indices| freedom::part_beside(self.points, indices));
            parts.reduce(f64::max).unwrap_or(1.0)
        };
        (0..count).map(part).collect()
    }

    /// Returns true if the functions of copies of an end point differ from zero in a cell.
    fn is_beside_copies(&self, cell: usize) -> bool {
        let (along, across) = (cell / self.across.count(), cell % self.across.count());
        let lines = [(along, self.along.count()), (across, self.across.count())];
        let mut all = self.setup.directions().zip(lines);
        all.any(|(direction, (gap, gaps))| {
            let degree = direction.basis.degree();
            (gap < degree && direction.stands_still(Side::Start))
                || (gap + degree >= gaps && direction.stands_still(Side::End))
        })
    }

    /// Passes values of cells on to those beside them.
    fn pass_on(&self, values: &mut [f64]) {
        freedom::pass_on(values, self.across.count(), self.setup.u(), self.setup.v());
    }

    /// The bend of each cell, of grids the sum of those along its rows and its columns.
    fn bends(&self) -> Vec<f64> {
        let (setup, points) = (self.setup, self.points);
        let u = parameters(setup.u(), &self.rows);
        let Some(v) = setup.v() else {
            return freedom::bends(points, &self.rows, &u);
        };
        let Grid { rows, columns } = setup.grid();
        let t = v.explicit_parameters();
        let of_row = |row: usize| {
            let indices: Vec<usize> = (0..columns).map(|column| row * columns + column).collect();
            freedom::bends(points, &indices, &t)
        };
        let of_column = |column: usize| {
            let indices: Vec<usize> = (0..rows).map(|row| row * columns + column).collect();
            freedom::bends(points, &indices, &u)
        };
        let of_rows: Vec<Vec<f64>> = (0..rows).map(of_row).collect();
        let of_columns: Vec<Vec<f64>> = (0..columns).map(of_column).collect();
        let of_cell = |cell: usize| {
            let (along, across) = (cell / self.across.count(), cell % self.across.count());
            let [[first, second], [low, high]] = [self.along.ends[along], self.across.ends[across]];
            let of_rows = of_rows[first][across].max(of_rows[second][across]);
            of_rows + of_columns[low][along].max(of_columns[high][along])
        };
        (0..self.count()).map(of_cell).collect()
    }

    /// The largest distance between the corners of each cell, or of one of those around it, and a part of that of
    /// others, which is passed on: fits overshoot in a flat place next to a steep one.
    fn apart(&self) -> Vec<f64> {
        let is_curve = self.setup.v().is_none();
        let own = |cell: usize| {
            let [[a, b], [c, d]] = self.corners(cell);
            if is_curve {
                return self.points.distance(a, c);
            }
            let pairs = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)];
            let distance = |(i, j)| self.points.distance(i, j);
            pairs.into_iter().map(distance).fold(0.0, f64::max)
        };
        let own: Vec<f64> = (0..self.count()).map(own).collect();
        let mut most = self.largest_around(&own);
        self.pass_on(&mut most);
        most
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

    /// The largest distance in each cell at the places of its lines.
    pub(super) fn distances(&self, control_points: &Points) -> Vec<f64> {
        let mut distances = vec![0.0_f64; self.count()];
        let geometry = Geometry::new(self.setup, control_points);
        let across = &self.across.places;
        for along in self.along.places.chunks((AT_ONCE / across.len()).max(1)) {
            self.measure(&geometry, along, across, &mut distances);
        }
        distances
    }

    /// Looks at some cells in small steps.
    pub(super) fn look_closer(
        &self,
        control_points: &Points,
        cells: &[usize],
        distances: &mut [f64],
    ) {
        let geometry = Geometry::new(self.setup, control_points);
        let columns = self.across.count();
        for cell in cells {
            let along = self.along.closer(cell / columns);
            let across = self.across.closer(cell % columns);
            self.measure(&geometry, &along, &across, distances);
        }
    }

    /// Raises the distances of cells to those at places.
    fn measure(
        &self,
        geometry: &Geometry<'_>,
        along: &[Place],
        across: &[Place],
        distances: &mut [f64],
    ) {
        let parameters =
            |places: &[Place]| places.iter().map(|it| it.parameter).collect::<Vec<_>>();
        let fit = geometry.evaluate(&parameters(along), &parameters(across));
        if self.setup.v().is_none() {
            return segment::measure(self.points, &self.along.ends, along, &fit, distances);
        }
        let pairs = along
            .iter()
            .flat_map(|a| across.iter().map(move |b| (a, b)));
        for (index, (a, b)) in pairs.enumerate() {
            let cell = a.gap * self.across.count() + b.gap;
            let distance = self.distance(cell, [a.part, b.part], &fit, index);
            distances[cell] = distances[cell].max(distance);
        }
    }

    /// How far point `index` of a fit is from the bilinear patch between the corners of a cell: from that place on it which
    /// is nearest, but for values of functions, which are compared at the same parameters.
    fn distance(&self, cell: usize, at: [f64; 2], fit: &Points, index: usize) -> f64 {
        let corners = self.corners(cell);
        let at = match fit.dimension() {
            1 => at,
            _ => self.nearest(corners, at, fit, index),
        };
        let lanes = fit.lanes().iter().zip(self.points.lanes());
        let differences = lanes.map(|(fit, data)| fit[index] - Patch::new(corners, data).value(at));
        freedom::length_of(differences)
    }

    /// The parts of a cell at which its patch is nearest, by one step of Gauss and Newton.
    fn nearest(
        &self,
        corners: [[usize; 2]; 2],
        at: [f64; 2],
        fit: &Points,
        index: usize,
    ) -> [f64; 2] {
        let lanes = || fit.lanes().iter().zip(self.points.lanes());
        let slopes = lanes().flat_map(|(_, data)| Patch::new(corners, data).slopes(at));
        // Squares of lengths of any unit stay within the range of numbers.
        let unit = normalizing_scale(slopes.fold(0.0, |most: f64, slope| most.max(slope.abs())));
        let mut normal = [[0.0; 2]; 2];
        let mut moments = [0.0; 2];
        for (fit, data) in lanes() {
            let patch = Patch::new(corners, data);
            let difference = (fit[index] - patch.value(at)) * unit;
            let slopes = patch.slopes(at).map(|slope| slope * unit);
            for i in 0..2 {
                moments[i] += slopes[i] * difference;
                for j in 0..2 {
                    normal[i][j] += slopes[i] * slopes[j];
                }
            }
        }
        let determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
        let step = match determinant > SINGULAR * normal[0][0] * normal[1][1] {
            true => [
                (moments[0] * normal[1][1] - moments[1] * normal[0][1]) / determinant,
                (moments[1] * normal[0][0] - moments[0] * normal[1][0]) / determinant,
            ],
            // Cells whose sides are parallel have one direction.
            false if normal[0][0] > 0.0 => [moments[0] / normal[0][0], 0.0],
            false => [0.0; 2],
        };
        [0, 1].map(|i| (at[i] + step[i]).clamp(0.0, 1.0))
    }
}

/// The ratio of the largest weight to the smallest. The speed of a rational fit changes with its weights, so its freedom
/// is multiplied by this ratio.
fn weight_ratio(setup: &Setup) -> f64 {
    let of = |weights: &[f64]| {
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let smallest = weights.iter().copied().fold(f64::INFINITY, f64::min);
        largest / smallest
    };
    let lifted = setup
        .lifted
        .as_ref()
        .and_then(|points| points.lanes().last());
    let fixed = setup.directions().filter_map(Direction::weights);
    lifted.map_or(1.0, |weights| of(weights)) * fixed.map(of).product::<f64>()
}

/// One coordinate of a bilinear patch.
struct Patch([[f64; 2]; 2]);

impl Patch {
    fn new(corners: [[usize; 2]; 2], data: &[f64]) -> Self {
        Self(corners.map(|pair| pair.map(|corner| data[corner])))
    }

    fn value(&self, [s, r]: [f64; 2]) -> f64 {
        let [low, high] = self.0.map(|[left, right]| (1.0 - r) * left + r * right);
        (1.0 - s) * low + s * high
    }

    /// Its derivatives in both directions.
    fn slopes(&self, [s, r]: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.0;
        [
            (1.0 - r) * (c - a) + r * (d - b),
            (1.0 - s) * (b - a) + s * (d - c),
        ]
    }
}
