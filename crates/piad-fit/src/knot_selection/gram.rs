//! Normal equations of B-splines: symmetric, banded and positive definite.
//!
//! Entry (i, j) of `Aᵀ W A` differs from zero for |i − j| ≤ p. Those of a closed line are ordered as
//! on a circle that is pressed flat, in which they have twice the bandwidth.
//!
//! Additions to the equations, such as the energy of a fairness term, go through [`Gram::add`].

use super::values::Values;
use crate::basis::quadrature::Row;
use crate::linear::folded;
use crate::linear::symmetric::{Cholesky, SymmetricBand};

/// The matrix of the normal equations.
#[derive(Clone, Debug)]
pub(super) struct Gram {
    order: Order,
    matrix: SymmetricBand,
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
        Self {
            order: Order {
                count,
                folds: closed,
            },
            matrix: SymmetricBand::new(count, band + 1),
        }
    }

    /// Adds to entry (i, j), which stands for (j, i) too: call it for one of them.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let (i, j) = (self.order.place(i), self.order.place(j));
        self.matrix.add(i.max(j), i.min(j), value);
    }

    /// `AᵀWA` of the control points that move, and the squares of some rows.
    pub(super) fn of(values: &Values, weights: Option<&[f64]>, bending: &[Row]) -> Self {
        let (line, width) = (values.line(), values.width());
        let (fixed, count) = (line.fixed_ends(), line.control_points());
        let moving = |j: usize| (fixed..count - fixed).contains(&j).then(|| j - fixed);
        let mut gram = Self::new(count - 2 * fixed, line.degree(), line.is_closed());
        let products = values.products(weights);
        for (part, products) in values
            .parts()
            .iter()
            .zip(products.chunks_exact(width * width))
        {
            let place = |k: usize| moving(line.control_point(part.span + k));
            for a in 0..width {
                for b in 0..=a {
                    if let (Some(i), Some(j)) = (place(a), place(b)) {
                        gram.add(i, j, products[a * width + b]);
                    }
                }
            }
        }
        for row in bending {
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

    /// Its factor, or `None` if some combination of unknowns is not determined.
    pub(super) fn factor(self) -> Option<Factor> {
        let (order, cholesky) = (self.order, self.matrix.factor()?);
        Some(Factor { order, cholesky })
    }
}

/// The factor of the matrix.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    order: Order,
    cholesky: Cholesky,
}

impl Factor {
    /// Solves in place.
    pub(super) fn solve(&self, x: &mut [f64]) {
        if !self.order.folds {
            self.cholesky.solve(x);
            return;
        }
        let mut ordered = vec![0.0; x.len()];
        for (i, &x) in x.iter().enumerate() {
            ordered[self.order.place(i)] = x;
        }
        self.cholesky.solve(&mut ordered);
        for (i, x) in x.iter_mut().enumerate() {
            *x = ordered[self.order.place(i)];
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
