//! The collocation matrix of scattered points: each has a (u, v) of its own.
//!
//! ```text
//! A[i][(k, l)] = B_k(u_i) B_l(v_i)
//! ```
//!
//! A row has (p + 1)(q + 1) entries, which are products: of each point the values of the functions
//! of both directions are kept, p + q + 2 numbers. Around a closed direction the first control points follow the last
//! ones: products have a margin of p more of them, so that those of a point are always next to each other.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::basis::direction::Direction;
use crate::basis::evaluated::Evaluated;
use crate::data::grid::Grid;
use crate::linear::folded;

/// The most multiplications of a factorization of the normal equations.
const MOST_WORK: usize = 4_000_000_000;

/// The number of rows that are multiplied by one thread.
const ROWS: usize = 16_384;

/// The collocation matrix of points at scattered parameters.
#[derive(Clone, Debug)]
pub struct Sparse {
    /// The arrangement of the control points.
    control: Grid,
    /// The functions of u at each point.
    u: Line,
    /// Those of v.
    v: Line,
}

/// The functions of a direction that can differ from zero, at each point.
#[derive(Clone, Debug)]
struct Line {
    /// The control point of each function.
    control_points: Vec<u32>,
    functions: Evaluated,
}

impl Line {
    fn new(direction: &Direction) -> Self {
        let functions = 0..direction.basis.functions();
        Self {
            control_points: functions.map(|j| direction.free_index(j) as u32).collect(),
            functions: Evaluated::new(direction, &direction.parameters),
        }
    }
}

impl Sparse {
    /// Evaluates the bases at the parameters of all points.
    pub(crate) fn new(u: &Direction, v: &Direction) -> Self {
        Self {
            control: Grid {
                rows: u.free(),
                columns: v.free(),
            },
            u: Line::new(u),
            v: Line::new(v),
        }
    }

    /// About how many bytes it takes: the matrix, and what solving its normal equations does.
    pub(crate) fn memory(u: &Direction, v: &Direction) -> usize {
        let widths = [u, v].map(|direction| direction.basis.support_width());
        let count = u.parameters.len();
        let points = count * (widths.iter().sum::<usize>() + 4) * size_of::<f64>();
        let controls = u.free() * v.free();
        let cells = (u.free() + 1 - widths[0]) * (v.free() + 1 - widths[1]);
        let left = (cells * widths[0] * widths[1]).min(count);
        let (rows, width) = (controls.saturating_add(left), widths[0] * v.free());
        // Factorizations that would take longer are not made.
        let longest = MOST_WORK / (4 * width * width);
        let factor = rows.min(longest.max(controls)).saturating_mul(width);
        points + factor.saturating_mul(size_of::<f64>())
    }

    /// The number of points.
    pub fn rows(&self) -> usize {
        self.u.functions.firsts.len()
    }

    /// The arrangement of the control points.
    pub(crate) fn control_grid(&self) -> Grid {
        self.control
    }

    /// How many functions of u and of v can differ from zero at a point.
    pub(crate) fn widths(&self) -> [usize; 2] {
        [self.u.functions.width, self.v.functions.width]
    }

    /// The first functions of u and v that can differ from zero at point `i`.
    pub(crate) fn cell(&self, i: usize) -> (u32, u32) {
        (self.u.functions.firsts[i], self.v.functions.firsts[i])
    }

    /// The entries of row `i`, columns and values.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let ((first, along), (start, across)) = (self.u.functions.at(i), self.v.functions.at(i));
        along.iter().enumerate().flat_map(move |(k, a)| {
            let across = across.iter().enumerate();
            across.map(move |(l, b)| (self.control_point(first + k, start + l), a * b))
        })
    }

    /// The control point of two functions, one of u and one of v.
    pub(crate) fn control_point(&self, k: usize, l: usize) -> usize {
        let [row, column] = [self.u.control_points[k], self.v.control_points[l]];
        row as usize * self.control.columns + column as usize
    }

    /// The places of the control points in the order in which rows are narrow: that of a closed u is folded.
    pub(crate) fn places(&self) -> Vec<u32> {
        let Grid { rows, columns } = self.control;
        let fold = folded(rows);
        let line = |row: usize| if self.folds() { fold(row) } else { row };
        let places = (0..rows * columns).map(|j| line(j / columns) * columns + j % columns);
        places.map(|place| place as u32).collect()
    }

    /// The most places from the first to the last entry of a row.
    pub(crate) fn band(&self) -> usize {
        let lines = if self.folds() { 2 } else { 1 } * self.u.functions.width;
        lines * self.control.columns
    }

    fn folds(&self) -> bool {
        self.u.control_points.len() != self.control.rows
    }

    /// Returns true if each function has a control point of its own.
    fn is_open(&self) -> bool {
        let functions = self.u.control_points.len() * self.v.control_points.len();
        functions == self.control.count()
    }

    /// The numbers of control points with those of the margins.
    fn with_margin<'a>(&self, x: &'a [f64]) -> Cow<'a, [f64]> {
        if self.is_open() {
            return Cow::Borrowed(x);
        }
        let columns = self.v.control_points.len();
        let functions = self.u.control_points.len() * columns;
        let all = (0..functions).map(|k| x[self.control_point(k / columns, k % columns)]);
        Cow::Owned(all.collect())
    }

    /// `y = A x` for one coordinate x of all control points.
    pub(crate) fn apply(&self, x: &[f64], y: &mut [f64]) {
        let (x, columns) = (self.with_margin(x), self.v.control_points.len());
        let sum = |i: usize| {
            let ((first, along), (start, across)) =
                (self.u.functions.at(i), self.v.functions.at(i));
            let line = |(k, a): (usize, &f64)| {
                let x = &x[(first + k) * columns + start..][..across.len()];
                let sum: f64 = x.iter().zip(across).map(|(x, b)| x * b).sum();
                a * sum
            };
            along.iter().enumerate().map(line).sum::<f64>()
        };
        let parts = y.par_chunks_mut(ROWS).enumerate();
        parts.for_each(|(part, y)| {
            let places = y.iter_mut().enumerate();
            places.for_each(|(i, y)| *y = sum(part * ROWS + i));
        });
    }

    /// `y = Aᵀ x` for one coordinate x of all points. The order of the sums does not depend on the
    /// number of threads.
    pub(crate) fn apply_transposed(&self, x: &[f64], y: &mut [f64]) {
        if self.is_open() {
            return self.add_by_functions(x, y);
        }
        let columns = self.v.control_points.len();
        let mut sums = vec![0.0; self.u.control_points.len() * columns];
        self.add_by_functions(x, &mut sums);
        y.fill(0.0);
        for (k, sum) in sums.into_iter().enumerate() {
            y[self.control_point(k / columns, k % columns)] += sum;
        }
    }

    /// The same for each function of u and each of v.
    fn add_by_functions(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let columns = self.v.control_points.len();
        for (i, &x) in x.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            let ((first, along), (start, across)) =
                (self.u.functions.at(i), self.v.functions.at(i));
            for (k, a) in along.iter().enumerate() {
                let factor = a * x;
                let y = &mut y[(first + k) * columns + start..][..across.len()];
                y.iter_mut().zip(across).for_each(|(y, b)| *y += factor * b);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::choice::{BasisChoice, DirectionChoice};
    use crate::basis::knots::Knots;
    use crate::invalid::Axis;
    use crate::parameters::{Domain, Parametrization};
    use nalgebra::{DMatrix, DVector};

    fn direction(degree: usize, free: usize, phase: f64, axis: Axis) -> Direction {
        let choice = DirectionChoice::new(
            BasisChoice::BSpline {
                degree,
                knots: Knots::Spread,
            },
            Parametrization::ChordLength,
        );
        let parameters = (0..60).map(|i| (f64::from(i) * phase).sin()).collect();
        Direction::scattered(&choice, (parameters, Domain::Data), free, axis).unwrap()
    }

    /// Both products, the rows and the columns, against the matrix of products of all functions.
    #[test]
    fn products_are_those_of_the_whole_matrix() {
        let u = direction(3, 7, 1.3, Axis::U);
        let v = direction(2, 5, 2.1, Axis::V);
        let sparse = Sparse::new(&u, &v);
        let line = |direction: &Direction, i: usize| {
            let mut values = vec![0.0; direction.basis.support_width()];
            let start = direction.evaluate(direction.parameters[i], &mut values);
            let mut all = vec![0.0; direction.free()];
            all[start..start + values.len()].copy_from_slice(&values);
            all
        };
        let dense = DMatrix::from_fn(60, 35, |i, j| line(&u, i)[j / 5] * line(&v, i)[j % 5]);
        let x = DVector::from_fn(35, |j, _| (j as f64).cos());
        let mut y = vec![0.0; 60];
        sparse.apply(x.as_slice(), &mut y);
        assert!((&dense * &x - DVector::from_column_slice(&y)).amax() < 1e-15);
        let mut back = vec![0.0; 35];
        sparse.apply_transposed(&y, &mut back);
        let expected = dense.transpose() * DVector::from_column_slice(&y);
        assert!((expected - DVector::from_column_slice(&back)).amax() < 1e-14);
        for i in 0..60 {
            assert!(sparse.row(i).all(|(j, value)| value == dense[(i, j)]));
        }
    }
}
