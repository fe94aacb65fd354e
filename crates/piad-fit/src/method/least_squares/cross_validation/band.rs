//! Symmetric banded matrices, and the parts of their inverses within the band.

/// Pivots below this part of the diagonal are rounding: the data do not determine the curve.
const SINGULAR: f64 = 1e-13;

/// A symmetric matrix of entries near its diagonal, or its factor L with `L Lᵀ`.
pub(super) struct Band {
    /// Entries on and below the diagonal of a column.
    pub width: usize,
    /// Row after row, the diagonal last.
    entries: Vec<f64>,
}

impl Band {
    pub(super) fn new(order: usize, width: usize) -> Self {
        let width = width.clamp(1, order.max(1));
        Self {
            width,
            entries: vec![0.0; order * width],
        }
    }

    fn order(&self) -> usize {
        self.entries.len() / self.width
    }

    fn index(&self, i: usize, j: usize) -> usize {
        (i + 1) * self.width - 1 - (i - j)
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[self.index(i, j)]
    }

    /// The columns to the left of row i within the band.
    fn first(&self, i: usize) -> usize {
        (i + 1).saturating_sub(self.width)
    }

    /// Adds the products of a row with itself.
    pub(super) fn add(&mut self, row: &[(usize, f64)], factor: f64, places: &[usize]) {
        for &(a, x) in row {
            for &(b, y) in row {
                let (i, j) = (places[a], places[b]);
                if i >= j {
                    let index = self.index(i, j);
                    self.entries[index] += factor * x * y;
                }
            }
        }
    }

    pub(super) fn plus(&self, other: &Self, factor: f64) -> Self {
        let pairs = self.entries.iter().zip(&other.entries);
        Self {
            width: self.width,
            entries: pairs.map(|(a, b)| a + factor * b).collect(),
        }
    }

    /// A whole column.
    pub(super) fn column(&self, j: usize) -> Vec<f64> {
        let entry = |i: usize| match (i.max(j), i.min(j)) {
            (i, j) if i - j < self.width => self.at(i, j),
            _ => 0.0,
        };
        (0..self.order()).map(entry).collect()
    }

    /// Makes a row and its column those of the identity.
    pub(super) fn fix(&mut self, place: usize) {
        for other in self.first(place)..self.order().min(place + self.width) {
            let index = self.index(place.max(other), place.min(other));
            self.entries[index] = if other == place { 1.0 } else { 0.0 };
        }
    }

    /// Cholesky's factor in its place; `None` if the matrix is not positive definite.
    pub(super) fn factorize(&mut self) -> Option<()> {
        for i in 0..self.order() {
            let diagonal = self.at(i, i);
            for j in self.first(i)..=i {
                let from = self.first(i).max(self.first(j));
                let products: f64 = (from..j).map(|k| self.at(i, k) * self.at(j, k)).sum();
                let left = self.at(i, j) - products;
                let index = self.index(i, j);
                self.entries[index] = match i == j {
                    true if left <= SINGULAR * diagonal => return None,
                    true => left.sqrt(),
                    false => left / self.at(j, j),
                };
            }
        }
        Some(())
    }

    /// Solves with the factor.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for i in 0..x.len() {
            let products: f64 = (self.first(i)..i).map(|j| self.at(i, j) * x[j]).sum();
            x[i] = (x[i] - products) / self.at(i, i);
        }
        for i in (0..x.len()).rev() {
            x[i] /= self.at(i, i);
            let value = x[i];
            (self.first(i)..i).for_each(|j| x[j] -= self.at(i, j) * value);
        }
    }

    /// The trace of the inverse of `L Lᵀ` times another matrix, but for fixed places. The entries of the inverse within the
    /// band come from the last to the first:
    ///
    /// ```text
    /// Z_ij = (δ_ij / L_jj − Σ_{k > j} L_kj Z_ki) / L_jj,   i ≥ j
    /// ```
    pub(super) fn trace_of_inverse_times(&self, other: &Self, fixed: &[usize]) -> f64 {
        let order = self.order();
        let mut inverse = Self::new(order, self.width);
        let mut trace = 0.0;
        for j in (0..order).rev() {
            let end = order.min(j + self.width);
            let pivot = self.at(j, j);
            for i in (j..end).rev() {
                let products = (j + 1..end).map(|k| self.at(k, j) * inverse.at(k.max(i), k.min(i)));
                let unit = if i == j { 1.0 / pivot } else { 0.0 };
                let value = (unit - products.sum::<f64>()) / pivot;
                let index = inverse.index(i, j);
                inverse.entries[index] = value;
                let times = if i == j { 1.0 } else { 2.0 };
                if !fixed.contains(&i) && !fixed.contains(&j) {
                    trace += times * value * other.at(i, j);
                }
            }
        }
        trace
    }
}
