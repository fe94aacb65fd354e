//! Symmetric banded matrices, their Cholesky factors `L Lᵀ`, and the parts of their inverses within the band.
//!
//! A factorization takes n w² operations for n rows with w entries up to the diagonal, and stays within the band.

/// A pivot below this part of its diagonal entry is an unknown that the equations say nothing about: beyond it a
/// solution has no digits left.
const SINGULAR: f64 = 1e-13;

/// The lower half of a symmetric banded matrix.
#[derive(Clone, Debug)]
pub(crate) struct SymmetricBand {
    /// The entries of a row up to its diagonal.
    pub width: usize,
    /// Row by row entries (i, i + 1 − width) … (i, i).
    entries: Vec<f64>,
}

impl SymmetricBand {
    /// Zeros.
    pub(crate) fn new(order: usize, width: usize) -> Self {
        let width = width.clamp(1, order.max(1));
        Self {
            width,
            entries: vec![0.0; order * width],
        }
    }

    /// The number of rows.
    fn order(&self) -> usize {
        self.entries.len() / self.width
    }

    fn index(&self, i: usize, j: usize) -> usize {
        (i + 1) * self.width - 1 - (i - j)
    }

    /// Entry (i, j), i ≥ j.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[self.index(i, j)]
    }

    /// The first column within the band of row i.
    fn first(&self, i: usize) -> usize {
        (i + 1).saturating_sub(self.width)
    }

    /// The entries of row i from that column on to the one before the diagonal.
    fn left(&self, i: usize) -> &[f64] {
        &self.entries[self.index(i, self.first(i))..self.index(i, i)]
    }

    /// Adds to entry (i, j), i ≥ j, which stands for (j, i) too.
    pub(crate) fn add(&mut self, i: usize, j: usize, value: f64) {
        let index = self.index(i, j);
        self.entries[index] += value;
    }

    /// Adds the products of a row of unknowns at some places with itself.
    pub(crate) fn add_products(&mut self, row: &[(usize, f64)], factor: f64, places: &[usize]) {
        for &(a, x) in row {
            for &(b, y) in row {
                if places[a] >= places[b] {
                    self.add(places[a], places[b], factor * x * y);
                }
            }
        }
    }

    /// The sum with a multiple of a matrix of the same size.
    pub(crate) fn plus(&self, other: &Self, factor: f64) -> Self {
        let pairs = self.entries.iter().zip(&other.entries);
        Self {
            width: self.width,
            entries: pairs.map(|(a, b)| a + factor * b).collect(),
        }
    }

    /// A whole column.
    pub(crate) fn column(&self, j: usize) -> Vec<f64> {
        let entry = |i: usize| match (i.max(j), i.min(j)) {
            (i, j) if i - j < self.width => self.at(i, j),
            _ => 0.0,
        };
        (0..self.order()).map(entry).collect()
    }

    /// Makes a row and its column those of the identity.
    pub(crate) fn fix(&mut self, place: usize) {
        for other in self.first(place)..self.order().min(place + self.width) {
            let index = self.index(place.max(other), place.min(other));
            self.entries[index] = if other == place { 1.0 } else { 0.0 };
        }
    }

    /// The Cholesky factor, or `None` if some combination of unknowns is not determined.
    pub(crate) fn factor(mut self) -> Option<Cholesky> {
        let width = self.width;
        let band = width - 1;
        for i in 0..self.order() {
            let (done, rest) = self.entries.split_at_mut(i * width);
            let row = &mut rest[..width];
            let diagonal = row[band];
            for k in band.saturating_sub(i)..band {
                let j = i + k - band;
                let other = &done[j * width..(j + 1) * width];
                // Entries (i, l) and (j, l) for the columns l that both rows have.
                let shared = row[..k].iter().zip(&other[band - k..band]);
                let sum: f64 = shared.map(|(a, b)| a * b).sum();
                row[k] = (row[k] - sum) / other[band];
            }
            let square: f64 = row[..band].iter().map(|x| x * x).sum();
            let pivot = diagonal - square;
            if !(pivot > SINGULAR * diagonal && pivot.is_finite()) {
                return None;
            }
            row[band] = pivot.sqrt();
        }
        Some(Cholesky(self))
    }
}

/// The factor L.
#[derive(Clone, Debug)]
pub(crate) struct Cholesky(SymmetricBand);

impl Cholesky {
    /// Solves `L Lᵀ x = b` in the place of b.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let Self(lower) = self;
        for i in 0..x.len() {
            let products = lower.left(i).iter().zip(&x[lower.first(i)..i]);
            let sum: f64 = products.map(|(l, x)| l * x).sum();
            x[i] = (x[i] - sum) / lower.at(i, i);
        }
        for i in (0..x.len()).rev() {
            x[i] /= lower.at(i, i);
            let (before, at) = x.split_at_mut(i);
            let before = before[lower.first(i)..].iter_mut();
            before.zip(lower.left(i)).for_each(|(x, l)| *x -= l * at[0]);
        }
    }

    /// The trace of the inverse of `L Lᵀ` times another matrix, but for fixed places. The entries of the inverse within the
    /// band come from the last to the first:
    ///
    /// ```text
    /// Z_ij = (δ_ij / L_jj − Σ_{k > j} L_kj Z_ki) / L_jj,   i ≥ j
    /// ```
    pub(crate) fn trace_of_inverse_times(&self, other: &SymmetricBand, fixed: &[usize]) -> f64 {
        let Self(lower) = self;
        let order = lower.order();
        let mut inverse = SymmetricBand::new(order, lower.width);
        let mut trace = 0.0;
        for j in (0..order).rev() {
            let end = order.min(j + lower.width);
            let pivot = lower.at(j, j);
            for i in (j..end).rev() {
                let products =
                    (j + 1..end).map(|k| lower.at(k, j) * inverse.at(k.max(i), k.min(i)));
                let unit = if i == j { 1.0 / pivot } else { 0.0 };
                let value = (unit - products.sum::<f64>()) / pivot;
                inverse.add(i, j, value);
                let times = if i == j { 1.0 } else { 2.0 };
                if !fixed.contains(&i) && !fixed.contains(&j) {
                    trace += times * value * other.at(i, j);
                }
            }
        }
        trace
    }
}
