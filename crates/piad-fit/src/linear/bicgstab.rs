//! Sparse systems that are not symmetric: the stabilized method of biconjugate gradients (van der Vorst 1992), with an
//! incomplete factorization without fill-in as its preconditioner (Meijerink, van der Vorst 1977), which exists for
//! M-matrices. Several right-hand sides are solved at the same time, each by one thread.

use std::sync::Arc;

use rayon::prelude::*;

use crate::interrupt;

/// Steps that are taken at most, and those that each unknown adds by the square root of their number.
const STEPS: usize = 400;
const STEPS_BY_ROOT: usize = 20;

/// A residual that is this part of the right-hand side is none.
const DONE: f64 = 1e-13;

/// A residual up to this part is a solution where rounding ends the steps before.
const NEAR: f64 = 1e-8;

/// The part of the fill-in that is left out which the diagonal gets instead, so that smooth vectors are kept (Gustafsson
/// 1978).
const MODIFIED: f64 = 0.99;

/// The rows of a square matrix whose diagonal is 1.
#[derive(Debug)]
pub(crate) struct SparseRows {
    /// Where each row starts, and the last one ends.
    starts: Vec<u32>,
    /// The columns of the entries beside the diagonal, increasing in each row.
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl SparseRows {
    /// No rows yet, with room for some.
    pub(crate) fn with_room(rows: usize, entries: usize) -> Self {
        let mut starts = Vec::with_capacity(rows + 1);
        starts.push(0);
        Self {
            starts,
            columns: Vec::with_capacity(entries),
            values: Vec::with_capacity(entries),
        }
    }

    /// Appends a row of entries beside the diagonal, whose columns increase.
    pub(crate) fn push(&mut self, entries: impl Iterator<Item = (u32, f64)>) {
        for (column, value) in entries {
            self.columns.push(column);
            self.values.push(value);
        }
        self.starts.push(self.columns.len() as u32);
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// `y = A x`.
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        for (row, y) in y.iter_mut().enumerate() {
            let range = self.range(row);
            let entries = self.columns[range.clone()].iter().zip(&self.values[range]);
            *y = x[row] + entries.map(|(&k, a)| a * x[k as usize]).sum::<f64>();
        }
    }

    /// `L U` with the entries that the matrix has: those of L, whose diagonal is 1, and of U, and the diagonal of U.
    fn factor(&self) -> (Vec<f64>, Vec<f64>) {
        let mut values = self.values.clone();
        let mut diagonal = vec![1.0; self.len()];
        let mut place = vec![u32::MAX; self.len()];
        for row in 0..self.len() {
            let range = self.range(row);
            for k in range.clone() {
                place[self.columns[k] as usize] = k as u32;
            }
            for k in range.clone() {
                let other = self.columns[k] as usize;
                if other >= row {
                    break;
                }
                values[k] /= diagonal[other];
                for l in self.range(other) {
                    let column = self.columns[l] as usize;
                    if column <= other {
                        continue;
                    }
                    if column == row {
                        diagonal[row] -= values[k] * values[l];
                    } else if place[column] != u32::MAX {
                        values[place[column] as usize] -= values[k] * values[l];
                    } else {
                        diagonal[row] -= MODIFIED * values[k] * values[l];
                    }
                }
            }
            range.for_each(|k| place[self.columns[k] as usize] = u32::MAX);
        }
        (values, diagonal)
    }

    /// `x ← (L U)⁻¹ x`.
    fn precondition(&self, (values, diagonal): &(Vec<f64>, Vec<f64>), x: &mut [f64]) {
        for row in 0..self.len() {
            let below = self
                .range(row)
                .take_while(|&k| (self.columns[k] as usize) < row);
            let sum: f64 = below.map(|k| values[k] * x[self.columns[k] as usize]).sum();
            x[row] -= sum;
        }
        for row in (0..self.len()).rev() {
            let above = self.range(row).rev();
            let above = above.take_while(|&k| (self.columns[k] as usize) > row);
            let sum: f64 = above.map(|k| values[k] * x[self.columns[k] as usize]).sum();
            x[row] = (x[row] - sum) / diagonal[row];
        }
    }

    /// The solutions of `A x = b` for several right-hand sides; `None` if the steps do not come near one.
    pub(crate) fn solve(&self, all: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
        let factor = self.factor();
        interrupt::check();
        let rule = interrupt::rule();
        let solved = all.into_par_iter().map(|b| match &rule {
            Some(rule) => interrupt::until(Arc::clone(rule), || self.solution(&factor, b)),
            None => self.solution(&factor, b),
        });
        solved.collect()
    }

    fn solution(&self, factor: &(Vec<f64>, Vec<f64>), b: Vec<f64>) -> Option<Vec<f64>> {
        let count = self.len();
        let size = norm(&b);
        let mut x = b.clone();
        self.precondition(factor, &mut x);
        let mut r = vec![0.0; count];
        let mut steps = STEPS + STEPS_BY_ROOT * count.isqrt();
        let (mut best, mut least) = (x.clone(), f64::INFINITY);
        // It starts again from where it is if it breaks down, or if the residual that it updates has drifted away.
        while steps > 0 {
            self.apply(&x, &mut r);
            r.iter_mut().zip(&b).for_each(|(r, b)| *r = b - *r);
            let left = norm(&r);
            if left < least {
                least = left;
                best.clone_from(&x);
            } else {
                break;
            }
            if left <= DONE * size {
                break;
            }
            self.steps(factor, &mut x, &mut r, (DONE * size, &mut steps));
        }
        (least <= NEAR * size).then_some(best)
    }

    /// Steps until the residual is small, or a step cannot be taken.
    fn steps(
        &self,
        factor: &(Vec<f64>, Vec<f64>),
        x: &mut [f64],
        r: &mut [f64],
        (done, left): (f64, &mut usize),
    ) {
        let count = self.len();
        let shadow = r.to_vec();
        let mut p = r.to_vec();
        let [mut v, mut t, mut y] = [(); 3].map(|()| vec![0.0; count]);
        let mut rho = dot(&shadow, r);
        while *left > 0 {
            *left -= 1;
            interrupt::check();
            y.copy_from_slice(&p);
            self.precondition(factor, &mut y);
            self.apply(&y, &mut v);
            let alpha = rho / dot(&shadow, &v);
            if !alpha.is_finite() {
                return;
            }
            add(x, alpha, &y);
            add(r, -alpha, &v);
            y.copy_from_slice(r);
            self.precondition(factor, &mut y);
            self.apply(&y, &mut t);
            let omega = dot(&t, r) / dot(&t, &t);
            if !omega.is_finite() || omega == 0.0 {
                return;
            }
            add(x, omega, &y);
            add(r, -omega, &t);
            let next = dot(&shadow, r);
            let beta = next / rho * (alpha / omega);
            if norm(r) <= done || !beta.is_finite() || beta == 0.0 {
                return;
            }
            rho = next;
            for ((p, r), v) in p.iter_mut().zip(&*r).zip(&v) {
                *p = r + beta * (*p - omega * v);
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// `x ← x + c y`.
fn add(x: &mut [f64], c: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += c * y);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A convection on a grid, whose matrix is far from symmetric.
    #[test]
    fn systems_are_solved() {
        let side = 40;
        let mut rows = SparseRows::with_room(side * side, 4 * side * side);
        for i in 0..side * side {
            let (row, column) = (i / side, i % side);
            let sides = [
                (row > 0).then(|| (i - side, -0.05)),
                (column > 0).then(|| (i - 1, -0.6)),
                (column + 1 < side).then(|| (i + 1, -0.15)),
                (row + 1 < side).then(|| (i + side, -0.2)),
            ];
            rows.push(
                sides
                    .into_iter()
                    .flatten()
                    .map(|(k, value)| (k as u32, value)),
            );
        }
        let wanted: Vec<f64> = (0..side * side).map(|i| (i as f64 * 0.37).sin()).collect();
        let mut right = vec![0.0; side * side];
        rows.apply(&wanted, &mut right);
        let found = rows.solve(vec![right.clone(), right]).unwrap();
        for (a, b) in found.iter().flat_map(|it| it.iter().zip(&wanted)) {
            assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
        let none = rows.solve(vec![vec![0.0; side * side]]).unwrap();
        assert!(none[0].iter().all(|x| *x == 0.0));
    }
}
