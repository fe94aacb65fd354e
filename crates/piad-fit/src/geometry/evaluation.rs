//! The curve or surface of some control points: evaluation and sampling.
//!
//! ```text
//! C(t) = Σ_j X_j B_j(t),   S(u, v) = Σ_i Σ_j X_ij B_i(u) B_j(v)
//! ```
//!
//! with the rational basis functions of directions that have weights. In a homogeneous fit X has
//! one coordinate more, the weight, and points are projected: the first d coordinates of the sum
//! over the last one.
//!
//! Readers see the *complete* control net, as a CAD kernel stores it: with the copies at the ends,
//! which can differ from their control points ([`crate::ends`]), and on closed curves with the
//! control points of the next turn, one for each basis function. The iteration has the free ones
//! only.

use crate::basis::direction::Direction;
use crate::basis::evaluated::Evaluated;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::interrupt::Meter;
use crate::setup::Setup;

/// The fitted curve or surface with the control points of one level. It borrows both, and copies
/// nothing.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    setup: &'a Setup,
    control_points: &'a Points,
}

impl<'a> Geometry<'a> {
    /// The geometry of `control_points`, the free ones of some level of a problem with this `setup`, in homogeneous
    /// coordinates if the problem is.
    pub fn new(setup: &'a Setup, control_points: &'a Points) -> Self {
        Self {
            setup,
            control_points,
        }
    }

    /// Number of control points in the u direction, end copies included.
    pub fn rows(&self) -> usize {
        self.setup.u().basis.functions()
    }

    /// Number of control points in the v direction, end copies included; `None` for a curve.
    pub fn columns(&self) -> Option<usize> {
        self.setup.v().map(|v| v.basis.functions())
    }

    /// Every row and column of the complete net, row by row; the column of a curve is 0.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.columns().unwrap_or(1);
        (0..self.rows()).flat_map(move |row| (0..columns).map(move |column| (row, column)))
    }

    /// The free control point that the control point at a place of the complete net is equal to, if it
    /// is equal to one: all but those beside ends with derivatives.
    pub fn equal_to(&self, row: usize, column: usize) -> Option<usize> {
        let columns = self.setup.control_grid().columns;
        let start = self.setup.u().equal_to(row)? * columns;
        match self.setup.v() {
            None => Some(start),
            Some(v) => Some(start + v.equal_to(column)?),
        }
    }

    /// Where the complete control net depends on free control point `index`: every `(row, column)`,
    /// the column of a curve being 0.
    pub fn occurrences(&self, index: usize) -> impl Iterator<Item = (usize, usize)> + 'a {
        let columns = self.setup.control_grid().columns;
        let v = self.setup.v();
        let rows = self.setup.u().functions_of(index / columns);
        rows.flat_map(move |row| {
            let across = v.map(|v| v.functions_of(index % columns));
            let single = across.is_none().then_some(0);
            let across = across.into_iter().flatten().chain(single);
            across.map(move |column| (row, column))
        })
    }

    /// The places of the complete net that depend on these free control points, each once: natural
    /// ends have a control point that depends on two of them.
    pub fn changed(&self, moved: &[usize]) -> impl Iterator<Item = (usize, usize)> + use<> {
        let places = moved.iter().flat_map(|&index| self.occurrences(index));
        let mut places: Vec<(usize, usize)> = places.collect();
        places.sort_unstable();
        places.dedup();
        places.into_iter()
    }

    /// The free control points, in order, that are elsewhere in another geometry, or beside which a copy
    /// at an end is elsewhere; `None` if the other one has other control points.
    pub fn differences(&self, other: &Self) -> Option<Vec<usize>> {
        let (mine, others) = (self.control_points, other.control_points);
        let dimension = mine.dimension();
        if (others.len(), others.dimension()) != (mine.len(), dimension) {
            return None;
        }
        let lanes = || mine.lanes().iter().zip(others.lanes());
        let moved = |index: &usize| lanes().any(|(a, b)| a[*index] != b[*index]);
        let mut differences: Vec<usize> = (0..mine.len()).filter(moved).collect();
        if self.setup.offsets().is_some() || other.setup.offsets().is_some() {
            let columns = self.setup.control_grid().columns;
            let copies = self
                .places()
                .filter(|(row, column)| self.equal_to(*row, *column).is_none());
            for (row, column) in copies {
                let at = |of: &Self, c| of.coordinate(row, column, c);
                if (0..dimension).any(|c| at(self, c) != at(other, c)) {
                    let across = self.setup.v().map_or(0, |v| v.free_index(column));
                    differences.push(self.setup.u().free_index(row) * columns + across);
                }
            }
            differences.sort_unstable();
            differences.dedup();
        }
        Some(differences)
    }

    /// Whether the control points have weights of their own.
    pub fn is_homogeneous(&self) -> bool {
        self.setup.is_homogeneous()
    }

    /// One coordinate, of the loop, of the control point at a place of the complete net.
    pub fn coordinate(&self, row: usize, column: usize, coordinate: usize) -> f64 {
        let lane = self.control_points.lane(coordinate);
        if let Some(index) = self.equal_to(row, column) {
            return lane[index];
        }
        let columns = self.setup.control_grid().columns;
        let across = |start: usize| -> f64 {
            match self.setup.v() {
                None => lane[start],
                Some(v) => {
                    let parts = v.parts(column);
                    parts.map(|(index, part)| part * lane[start + index]).sum()
                }
            }
        };
        let parts = self.setup.u().parts(row);
        let sum: f64 = parts
            .map(|(index, part)| part * across(index * columns))
            .sum();
        let offsets = self.setup.offsets();
        sum + offsets.map_or(0.0, |it| it.at(row, column, coordinate))
    }

    /// Each coordinate of the complete control net, row by row, as a CAD kernel stores it; in
    /// homogeneous coordinates if the fit is.
    pub fn net(&self) -> Vec<Vec<f64>> {
        let lane = |c| {
            let value = |(row, column)| self.coordinate(row, column, c);
            self.places().map(value).collect()
        };
        (0..self.control_points.dimension()).map(lane).collect()
    }

    /// The place of the control point at a place of the complete net, d coordinates in data units:
    /// those of a homogeneous fit are divided by its weight, and infinite or NaN if that is zero.
    pub fn place(&self, row: usize, column: usize) -> impl ExactSizeIterator<Item = f64> + 'a {
        let weight = self.weight(row, column).unwrap_or(1.0);
        let geometry = *self;
        let coordinate = move |c| geometry.coordinate(row, column, c) / weight;
        (0..self.setup.dimension()).map(coordinate)
    }

    /// The weight of the control point at a place of the complete net, in a homogeneous fit.
    pub fn weight(&self, row: usize, column: usize) -> Option<f64> {
        let last = self.setup.dimension();
        self.is_homogeneous()
            .then(|| self.coordinate(row, column, last))
    }

    /// The points of the curve at the parameters `u`, or of the surface on the grid `u × v`, row by
    /// row, d coordinates each. Parameters lie in the domains of the bases. Of a curve each point
    /// costs `d (p + 1)` multiplications besides evaluating the basis.
    pub fn evaluate(&self, u: &[f64], v: &[f64]) -> Points {
        let grid = Values {
            along: LineValues::new(self.setup.u(), u),
            across: match self.setup.v() {
                None => LineValues::one(),
                Some(direction) => LineValues::new(direction, v),
            },
            controls: self.setup.control_grid(),
        };
        let lanes = self.control_points.lanes().iter();
        let mut lanes: Vec<Vec<f64>> = lanes.map(|lane| grid.sums(lane)).collect();
        if let Some(offsets) = self.setup.offsets() {
            let across = self.setup.v().map(|direction| (direction, v));
            offsets.add(1.0, (self.setup.u(), u), across, &mut lanes);
        }
        // From homogeneous coordinates to points.
        if self.is_homogeneous()
            && let Some(weights) = lanes.pop()
        {
            for lane in &mut lanes {
                lane.iter_mut().zip(&weights).for_each(|(x, w)| *x /= w);
            }
        }
        Points::from_lanes(lanes)
    }

    /// Whether the curve or surface lies in the convex hull of its control points: whether all
    /// weights are positive.
    pub fn is_within_hull(&self) -> bool {
        let positive = |weights: &[f64]| weights.iter().all(|weight| *weight > 0.0);
        let mut given = self.setup.directions().filter_map(Direction::weights);
        given.all(positive) && self.bad_weight().is_none()
    }

    /// Homogeneous fits: the first control point whose weight is not positive, as the free control
    /// point that it belongs to. It has no place, or the curve may leave the convex hull of its
    /// control points.
    pub(crate) fn bad_weight(&self) -> Option<(usize, f64)> {
        if !self.is_homogeneous() {
            return None;
        }
        let weights = self.control_points.lanes().last()?;
        let free = weights.iter().position(|weight| *weight <= 0.0);
        free.map(|index| (index, weights[index]))
            .or_else(|| self.bad_copy())
    }

    /// The same of the copies at the ends.
    fn bad_copy(&self) -> Option<(usize, f64)> {
        self.setup.offsets()?;
        let mut copies = self
            .places()
            .filter(|(row, column)| self.equal_to(*row, *column).is_none());
        copies.find_map(|(row, column)| {
            let weight = self.weight(row, column).filter(|weight| *weight <= 0.0)?;
            let start = self.setup.u().free_index(row) * self.setup.control_grid().columns;
            let index = self.setup.v().map_or(0, |v| v.free_index(column));
            Some((start + index, weight))
        })
    }
}

/// The values of the basis functions at the places of a grid, for sums over control points.
struct Values {
    /// Of direction u.
    along: LineValues,
    /// Of direction v; of a curve the one function that is 1.
    across: LineValues,
    /// The arrangement of the free control points.
    controls: Grid,
}

impl Values {
    /// The sums at all places of the grid, of one coordinate of the control points. Sums along one
    /// direction can serve a whole row or column of the grid, so that there are three orders of
    /// summation; the one with the fewest multiplications is taken.
    fn sums(&self, lane: &[f64]) -> Vec<f64> {
        let (along, across) = (&self.along, &self.across);
        let Grid { rows, columns } = self.controls;
        let (r, c) = (along.count(), across.count());
        let at_once = r * c * along.width() * across.width();
        let by_rows = r * along.width() * columns + r * c * across.width();
        let by_columns = c * across.width() * rows + r * c * along.width();
        let mut sums = vec![0.0; r * c];
        let mut meter = Meter::default();
        if at_once <= by_rows.min(by_columns) {
            for (place, sum) in sums.iter_mut().enumerate() {
                meter.add(along.width() * across.width());
                let inner = |k: usize| across.sum(place % c, |l| lane[k * columns + l]);
                *sum = along.sum(place / c, inner);
            }
        } else if by_rows <= by_columns {
            let mut line = vec![0.0; columns];
            for (i, sums) in sums.chunks_exact_mut(c).enumerate() {
                line.fill(0.0);
                meter.add(by_rows / r);
                along.each(i, |k, a| {
                    let row = &lane[k * columns..][..columns];
                    line.iter_mut().zip(row).for_each(|(sum, x)| *sum += a * x);
                });
                for (j, sum) in sums.iter_mut().enumerate() {
                    *sum = across.sum(j, |l| line[l]);
                }
            }
        } else {
            for j in 0..c {
                meter.add(by_columns / c);
                let column = |k: usize| across.sum(j, |l| lane[k * columns + l]);
                let column: Vec<f64> = (0..rows).map(column).collect();
                for i in 0..r {
                    sums[i * c + j] = along.sum(i, |k| column[k]);
                }
            }
        }
        sums
    }
}

/// The values of the basis functions of a direction at some parameters.
struct LineValues {
    functions: Evaluated,
    /// At each parameter the free control points of these functions.
    indices: Vec<u32>,
}

impl LineValues {
    /// Evaluates the basis of a direction at all parameters.
    fn new(direction: &Direction, parameters: &[f64]) -> Self {
        let mut functions = Evaluated::new(direction, parameters);
        let width = functions.width;
        let mut indices = Vec::with_capacity(functions.values.len());
        let values = functions.values.chunks_exact_mut(width);
        for (values, &first) in values.zip(&functions.firsts) {
            let first = first as usize;
            direction.share(first, values);
            indices.extend((0..width).map(|k| direction.free_index(first + k) as u32));
        }
        Self { functions, indices }
    }

    /// Across a curve there is one control point, whose function is 1.
    fn one() -> Self {
        let functions = Evaluated {
            width: 1,
            firsts: vec![0],
            values: vec![1.0],
        };
        let indices = vec![0];
        Self { functions, indices }
    }

    /// The number of parameters.
    fn count(&self) -> usize {
        self.functions.firsts.len()
    }

    /// How many functions can differ from zero at a parameter.
    fn width(&self) -> usize {
        self.functions.width
    }

    /// Each control point that matters at parameter `i`, with the value of its function.
    fn each(&self, i: usize, mut visit: impl FnMut(usize, f64)) {
        let (_, values) = self.functions.at(i);
        for (&index, &value) in self.indices[i * self.width()..].iter().zip(values) {
            visit(index as usize, value);
        }
    }

    /// The sum at parameter `i`.
    fn sum(&self, i: usize, control: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each(i, |index, value| sum += value * control(index));
        sum
    }
}
