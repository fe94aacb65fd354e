//! Least-squares factorizations of matrices with few consecutive entries in a row: `AᵀA = RᵀR`, with
//! an upper triangular R that is as narrow as A.
//!
//! R comes from rotations (Givens) of the rows of A, in the order of their first columns, so that the condition of A is
//! that of R, and not its square as with a Cholesky decomposition of AᵀA. That takes O(m w²) for m rows of w entries,
//! and a solution O(n w) for n columns.
//!
//! Where that is too much, as with the many rows of the fairness of a surface, the products `AᵀA` are summed up as rows
//! arrive, and decomposed (Cholesky) in O(n w²); steps of refinement recover the lost digits.
//!
//! Columns that depend on those before them are left out: their unknowns stay zero. Columns that do so
//! only together, a little each, make solutions grow without bound from one to the next; small rows of
//! the identity hold them then (Tikhonov). Cubics over 999 equal shares of 1000 points are of that kind,
//! with a condition of 1e31.

use super::map::LineMap;
use crate::interrupt;

/// A column whose part that is independent of the columns before it is smaller than this part of it
/// depends on them.
const DEPENDENT: f64 = 1e-12;

/// The same of the squares of these parts, which are differences of products.
const DEPENDENT_SQUARE: f64 = 1e-14;

/// An upper triangular matrix R, for solutions of `RᵀR x = b`.
#[derive(Debug)]
pub(crate) struct Triangular {
    /// The place of each column.
    places: Vec<u32>,
    /// The numbers that are kept of each row, from the diagonal on.
    width: usize,
    rows: Vec<f64>,
    /// Which rows have entries.
    taken: Vec<bool>,
}

impl Triangular {
    /// The factor of a matrix without rows, of as many columns as there are places. The first and
    /// the last entry of a row that comes are at most `width` places apart.
    pub(crate) fn new(places: Vec<u32>, width: usize) -> Self {
        let (n, width) = (places.len(), width.min(places.len()));
        Self {
            width,
            rows: vec![0.0; n * width],
            taken: vec![false; n],
            places,
        }
    }

    /// The factor of a matrix with these products of columns; `fixed` columns, and those that depend on others before
    /// them, are left out.
    pub(crate) fn of_products(
        places: Vec<u32>,
        width: usize,
        mut products: Vec<f64>,
        fixed: impl Fn(usize) -> bool,
    ) -> Self {
        let n = places.len();
        let squares: Vec<f64> = products.iter().step_by(width.max(1)).copied().collect();
        let mut taken = vec![true; n];
        for (column, &place) in places.iter().enumerate() {
            taken[place as usize] = !fixed(column);
        }
        for place in 0..n {
            interrupt::check();
            let (row, later) = products[place * width..].split_at_mut(width);
            taken[place] &= row[0] > DEPENDENT_SQUARE * squares[place];
            if !taken[place] {
                row.fill(0.0);
                continue;
            }
            let diagonal = row[0].sqrt();
            row[0] = diagonal;
            row[1..].iter_mut().for_each(|entry| *entry /= diagonal);
            for (k, other) in later.chunks_exact_mut(width).enumerate().take(width - 1) {
                let factor = row[k + 1];
                if factor != 0.0 {
                    let pairs = other.iter_mut().zip(&row[k + 1..]);
                    pairs.for_each(|(entry, x)| *entry -= factor * x);
                }
            }
        }
        Self {
            places,
            width,
            rows: products,
            taken,
        }
    }

    /// Rotates another row of the matrix into the factor. It takes the least time if rows come in
    /// the order of their first places.
    pub(crate) fn insert_row(&mut self, row: impl Iterator<Item = (usize, f64)> + Clone) {
        let entries = row.filter(|&(_, value)| value != 0.0);
        let places = entries.map(|(column, value)| (self.places[column] as usize, value));
        let places: Vec<(usize, f64)> = places.collect();
        let Some(first) = places.iter().map(|(place, _)| *place).min() else {
            return;
        };
        let mut line = vec![0.0; self.width];
        for (place, value) in places {
            line[place - first] += value;
        }
        self.insert(&mut line, first);
    }

    /// The rows of the factor, as places and values.
    pub(crate) fn rows(
        &self,
    ) -> impl Iterator<Item = impl Iterator<Item = (usize, f64)> + Clone + '_> {
        let rows = self.rows.chunks_exact(self.width).enumerate();
        rows.map(|(place, row)| {
            let entries = row.iter().enumerate();
            entries.map(move |(k, value)| (place + k, *value))
        })
    }

    /// Rotates a row, which begins at place `first`, into the rows that are there.
    pub(super) fn insert(&mut self, line: &mut [f64], first: usize) {
        let width = self.width;
        for place in first..self.taken.len() {
            let row = &mut self.rows[place * width..(place + 1) * width];
            if line[0] != 0.0 {
                if !self.taken[place] {
                    row.copy_from_slice(line);
                    self.taken[place] = true;
                    return;
                }
                let radius = row[0].hypot(line[0]);
                let (cosine, sine) = (row[0] / radius, line[0] / radius);
                for (above, below) in row.iter_mut().zip(&mut *line) {
                    let rotated = cosine * *above + sine * *below;
                    *below = cosine * *below - sine * *above;
                    *above = rotated;
                }
            }
            line.copy_within(1.., 0);
            line[width - 1] = 0.0;
            if line.iter().all(|x| *x == 0.0) {
                return;
            }
        }
    }

    /// Leaves out fixed columns and those that depend on others before them.
    pub(crate) fn leave_out(&mut self, fixed: impl Fn(usize) -> bool) {
        let (n, width) = (self.taken.len(), self.width);
        let lengths = self.lengths();
        let mut given = vec![false; n];
        for (column, &place) in self.places.iter().enumerate() {
            given[place as usize] = fixed(column);
        }
        for place in 0..n {
            let diagonal = self.rows[place * width].abs();
            if given[place] || diagonal <= DEPENDENT * lengths[place] {
                // The part of the row in later columns is in their rows.
                let row = &mut self.rows[place * width..(place + 1) * width];
                let mut line = row.to_vec();
                row.fill(0.0);
                line[0] = 0.0;
                self.taken[place] = false;
                line.copy_within(1.., 0);
                line[width - 1] = 0.0;
                self.insert(&mut line, place + 1);
            }
        }
    }

    /// The lengths of the columns.
    fn lengths(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.taken.len()];
        for (place, row) in self.rows.chunks_exact(self.width).enumerate() {
            for (square, value) in squares[place..].iter_mut().zip(row) {
                *square += value * value;
            }
        }
        squares.iter().map(|square: &f64| square.sqrt()).collect()
    }

    /// Returns true if R with columns of length one has a singular value below [`DEPENDENT`], as far as one solution
    /// shows it: that of a right side whose signs alternate, as solutions that grow do.
    pub(super) fn is_nearly_singular(&self) -> bool {
        let lengths = self.lengths();
        let signs = [1.0, -1.0].into_iter().cycle();
        let mut x: Vec<f64> = lengths
            .iter()
            .zip(signs)
            .map(|(l, sign)| l * sign)
            .collect();
        self.solve(&mut x);
        let bound = DEPENDENT.powi(-2);
        let mut scaled = x.iter().zip(&lengths).map(|(x, length)| x * length);
        // Infinities and NaN are not within the bound either.
        !scaled.all(|x| x.abs() <= bound)
    }

    /// The factor of the same matrix with small rows of the identity below it.
    pub(super) fn regularized(self) -> Self {
        let lengths = self.lengths();
        let mut factor = Self::new(self.places.clone(), self.width);
        let rows = self.rows.chunks_exact(self.width).enumerate();
        for (place, row) in rows.filter(|&(place, _)| self.taken[place]) {
            factor.insert(&mut row.to_vec(), place);
            let mut unit = vec![0.0; self.width];
            unit[0] = DEPENDENT * lengths[place];
            factor.insert(&mut unit, place);
        }
        factor.leave_out(|column| !self.taken[self.places[column] as usize]);
        factor
    }

    /// `x ← R⁻¹ R⁻ᵀ x`, in the order of places.
    fn solve(&self, x: &mut [f64]) {
        let (n, width) = (x.len(), self.width);
        for place in 0..n {
            let row = &self.rows[place * width..(place + 1) * width];
            if !self.taken[place] {
                x[place] = 0.0;
                continue;
            }
            x[place] /= row[0];
            let value = x[place];
            for (x, entry) in x[place + 1..].iter_mut().zip(&row[1..]) {
                *x -= entry * value;
            }
        }
        for place in (0..n).rev().filter(|&place| self.taken[place]) {
            let row = &self.rows[place * width..(place + 1) * width];
            let later = row[1..].iter().zip(&x[place + 1..]);
            let sum: f64 = later.map(|(entry, x)| entry * x).sum();
            x[place] = (x[place] - sum) / row[0];
        }
    }
}

impl LineMap for Triangular {
    /// Solves `RᵀR x = b` for each line.
    fn apply(&self, lines: &mut [f64]) {
        let mut ordered = vec![0.0; self.places.len()];
        for line in lines.chunks_exact_mut(self.places.len()) {
            for (x, &place) in line.iter().zip(&self.places) {
                ordered[place as usize] = *x;
            }
            self.solve(&mut ordered);
            for (x, &place) in line.iter_mut().zip(&self.places) {
                *x = ordered[place as usize];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::linear::rows::Rows;

    fn entry(i: usize, j: usize) -> f64 {
        ((3 * i + 7 * j) as f64).sin() + 0.3
    }

    /// Against the normal equations, solved densely.
    #[test]
    fn solutions_are_those_of_the_normal_equations() {
        let (m, n, width) = (40, 12, 4);
        let mut rows = Rows::new((0..n as u32).collect(), width);
        let mut dense = DMatrix::zeros(m, n);
        for i in 0..m {
            let first = i * (n - width + 1) / m;
            let row: Vec<(usize, f64)> = (first..first + width).map(|j| (j, entry(i, j))).collect();
            row.iter().for_each(|&(j, value)| dense[(i, j)] = value);
            rows.push(row.iter().copied(), 1.0);
        }
        let b: Vec<f64> = (0..n).map(|j| (j as f64).cos()).collect();
        let mut x = b.clone();
        rows.triangular(|_| false).apply(&mut x);
        let normal = dense.transpose() * &dense;
        let expected = normal.lu().solve(&DVector::from_vec(b)).unwrap();
        for (x, expected) in x.iter().zip(expected.iter()) {
            assert!((x - expected).abs() < 1e-10 * expected.abs().max(1.0));
        }
    }

    /// The factor of products is that of rotations, but for signs of rows and rounding.
    #[test]
    fn products_have_the_same_solutions() {
        let (m, n, width) = (60, 14, 5);
        let places: Vec<u32> = (0..n as u32).rev().collect();
        let mut rotated = Rows::new(places.clone(), width);
        let mut summed = Rows::of_products(places, width);
        for i in 0..m {
            let first = i * (n - width + 1) / m;
            let row = (first..first + width).map(|j| (j, entry(i, j)));
            rotated.push(row.clone(), 0.7);
            summed.push(row, 0.7);
        }
        let fixed = |column| column == 3;
        let b: Vec<f64> = (0..n).map(|j| (j as f64).cos()).collect();
        let [mut x, mut y] = [b.clone(), b];
        rotated.triangular(fixed).apply(&mut x);
        summed.triangular(fixed).apply(&mut y);
        let largest = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (x, y) in x.iter().zip(&y) {
            assert!((x - y).abs() < 1e-9 * largest, "{x} {y}");
        }
        assert_eq!((x[3], y[3]), (0.0, 0.0));
    }

    /// Column 2 is zero and column 3 twice column 1: both are left out, and the others solved for.
    #[test]
    fn dependent_columns_are_left_out() {
        let (m, n) = (9, 5);
        let mut rows = Rows::new((0..n as u32).collect(), n);
        let value = |i: usize, j: usize| match j {
            2 => 0.0,
            3 => 2.0 * entry(i, 1),
            _ => entry(i, j),
        };
        for i in 0..m {
            rows.push((0..n).map(|j| (j, value(i, j))), 1.0);
        }
        let kept = [0, 1, 4];
        let dense = DMatrix::from_fn(m, 3, |i, k| value(i, kept[k]));
        let b = [1.0, -2.0, 0.0, 9.0, 0.5];
        let mut x = b;
        rows.triangular(|_| false).apply(&mut x);
        let right = DVector::from_fn(3, |k, _| b[kept[k]]);
        let expected = (dense.transpose() * &dense).lu().solve(&right).unwrap();
        for (k, &j) in kept.iter().enumerate() {
            assert!((x[j] - expected[k]).abs() < 1e-9 * expected.amax());
        }
        assert_eq!((x[2], x[3]), (0.0, 0.0));
    }
}
