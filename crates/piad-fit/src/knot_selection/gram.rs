//! Normal equations of B-splines: symmetric, banded and positive definite.
//!
//! Entry (i, j) of `Aᵀ W A` differs from zero for |i − j| ≤ p. Those of a closed line are ordered as
//! on a circle that is pressed flat, in which they have twice the bandwidth. The factorization
//! `L Lᵀ` takes n b² operations and stays within the band.
//!
//! Additions to the equations, such as the energy of a fairness term, go through [`Gram::add`].

use super::values::Values;
use crate::basis::quadrature::Row;
use crate::linear::folded;

/// A pivot below this part of its diagonal entry is a control point that the data do not determine:
/// beyond it a solution has no digits left.
const SINGULAR: f64 = 1e-13;

/// The lower half of a symmetric banded matrix.
#[derive(Clone, Debug)]
pub(super) struct Gram {
    order: Order,
    /// The number of entries that are kept beside the diagonal.
    band: usize,
    /// Row by row entries (i, i − band) … (i, i).
    rows: Vec<f64>,
}

/// The places of unknowns.
#[derive(Clone, Copy, Debug)]
struct Order {
    count: usize,
    folds: bool,
}

impl Order {
    fn place(self, i: usize) -> usize {
        if self.folds { folded(self.count)(i) } else { i }
    }
}

impl Gram {
    /// Zeros, of `count` unknowns that are at most `reach` from each other, around the end if the
    /// line is closed.
    pub(super) fn new(count: usize, reach: usize, closed: bool) -> Self {
        let band = if closed { 2 * reach } else { reach };
        let band = band.min(count.saturating_sub(1));
        Self {
            order: Order {
                count,
                folds: closed,
            },
            band,
            rows: vec![0.0; count * (band + 1)],
        }
    }

    /// Adds to entry (i, j), which stands for (j, i) too: call it for one of them.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let (i, j) = (self.order.place(i), self.order.place(j));
        let (i, j) = (i.max(j), i.min(j));
        self.rows[i * (self.band + 1) + j + self.band - i] += value;
    }

    /// `AᵀWA` of the control points that move, and the squares of some rows.
    pub(super) fn of(values: &Values, weights: Option<&[f64]>, bending: &[Row]) -> Self {
        let (line, width) = (values.line(), values.width());
        let (fixed, count) = (line.fixed_ends(), line.control_points());
        let mut gram = Self::new(count - 2 * fixed, line.degree(), line.is_closed());
        let products = values.products(weights);
        for (part, products) in values
            .parts()
            .iter()
            .zip(products.chunks_exact(width * width))
        {
            let place = |k: usize| {
                let j = line.control_point(part.span + k);
                (fixed..count - fixed).contains(&j).then(|| j - fixed)
            };
            for a in 0..width {
                for b in 0..=a {
                    if let (Some(i), Some(j)) = (place(a), place(b)) {
                        gram.add(i, j, products[a * width + b]);
                    }
                }
            }
        }
        for row in bending {
            let moving = |j: usize| (fixed..count - fixed).contains(&j).then(|| j - fixed);
            for (k, &(a, x)) in row.iter().enumerate() {
                for &(b, y) in &row[..=k] {
                    if let (Some(i), Some(j)) = (moving(a), moving(b)) {
                        gram.add(i, j, x * y);
                    }
                }
            }
        }
        gram
    }

    /// The Cholesky factor, or `None` if some combination of unknowns is not determined.
    pub(super) fn factor(mut self) -> Option<Cholesky> {
        let (band, width) = (self.band, self.band + 1);
        for i in 0..self.order.count {
            let (done, rest) = self.rows.split_at_mut(i * width);
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
        Some(Cholesky {
            order: self.order,
            band,
            rows: self.rows,
        })
    }
}

/// `L` of `L Lᵀ`, row by row as in [`Gram`].
#[derive(Clone, Debug)]
pub(super) struct Cholesky {
    order: Order,
    band: usize,
    rows: Vec<f64>,
}

impl Cholesky {
    /// Solves in place.
    pub(super) fn solve(&self, x: &mut [f64]) {
        if !self.order.folds {
            self.solve_ordered(x);
            return;
        }
        let mut ordered = vec![0.0; x.len()];
        for (i, &x) in x.iter().enumerate() {
            ordered[self.order.place(i)] = x;
        }
        self.solve_ordered(&mut ordered);
        for (i, x) in x.iter_mut().enumerate() {
            *x = ordered[self.order.place(i)];
        }
    }

    /// `L y = x`, then `Lᵀ x = y`.
    fn solve_ordered(&self, x: &mut [f64]) {
        let (band, width) = (self.band, self.band + 1);
        for i in 0..x.len() {
            let from = i.saturating_sub(band);
            let row = &self.rows[i * width..(i + 1) * width];
            let left = &row[band - (i - from)..band];
            let sum: f64 = left.iter().zip(&x[from..i]).map(|(l, x)| l * x).sum();
            x[i] = (x[i] - sum) / row[band];
        }
        for i in (0..x.len()).rev() {
            let from = i.saturating_sub(band);
            let row = &self.rows[i * width..(i + 1) * width];
            x[i] /= row[band];
            let (before, at) = x.split_at_mut(i);
            let left = &row[band - (i - from)..band];
            for (x, l) in before[from..].iter_mut().zip(left) {
                *x -= l * at[0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Open and closed, against the product with the dense matrix.
    #[test]
    fn solutions_satisfy_the_equations() {
        for (count, closed) in [(1, false), (2, false), (9, false), (7, true), (12, true)] {
            let reach = 2;
            let mut gram = Gram::new(count, reach, closed);
            let mut dense = vec![vec![0.0; count]; count];
            let mut add = |i: usize, j: usize, value: f64| {
                gram.add(i, j, value);
                dense[i][j] += value;
                if i != j {
                    dense[j][i] += value;
                }
            };
            for i in 0..count {
                add(i, i, 5.0 + 0.1 * i as f64);
                for k in 1..=reach {
                    if closed || i + k < count {
                        add(i, (i + k) % count, 0.7 - 0.4 * k as f64 + 0.01 * i as f64);
                    }
                }
            }
            let right: Vec<f64> = (0..count).map(|i| (i as f64).sin() + 1.0).collect();
            let mut x = right.clone();
            gram.factor().unwrap().solve(&mut x);
            for (row, right) in dense.iter().zip(&right) {
                let product: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
                assert!((product - right).abs() < 1e-13, "{count} {closed}");
            }
        }
    }

    /// A control point that no parameter sees.
    #[test]
    fn what_is_not_determined_is_said() {
        let mut gram = Gram::new(3, 1, false);
        gram.add(0, 0, 1.0);
        gram.add(1, 0, 1.0);
        gram.add(1, 1, 1.0);
        gram.add(2, 2, 1.0);
        assert!(gram.factor().is_none());
    }
}
