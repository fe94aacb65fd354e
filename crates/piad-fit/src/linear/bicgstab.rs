//! Sparse systems that are not symmetric: the stabilized method of biconjugate gradients (van der Vorst 1992), with a
//! multigrid cycle as its preconditioner. Several right-hand sides are solved at the same time, each by one thread.

use std::sync::Arc;

use rayon::prelude::*;

use super::aggregation::Hierarchy;
use super::sparse_rows::SparseRows;
use super::vectors::{add, dot, length};
use crate::interrupt;

/// The most steps.
const STEPS: usize = 1000;

/// A residual that is this part of the right-hand side counts as zero.
const DONE: f64 = 1e-13;

/// A residual up to this part counts as a solution if rounding ends the steps before it is smaller.
const ACCEPTED_RESIDUAL: f64 = 1e-8;

impl SparseRows {
    /// The solutions of `A x = b` for several right-hand sides; `None` if the steps do not come near one.
    pub(crate) fn solve(&self, all: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
        let hierarchy = Hierarchy::new(self);
        interrupt::check();
        let rule = interrupt::rule();
        let solved = all.into_par_iter().map(|b| match &rule {
            Some(rule) => interrupt::until(Arc::clone(rule), || self.solution(&hierarchy, b)),
            None => self.solution(&hierarchy, b),
        });
        solved.collect()
    }

    fn solution(&self, hierarchy: &Hierarchy<'_>, b: Vec<f64>) -> Option<Vec<f64>> {
        let count = self.len();
        let size = length(&b);
        let mut x = hierarchy.apply(&b);
        let mut r = vec![0.0; count];
        let mut steps = STEPS;
        let (mut best, mut least) = (x.clone(), f64::INFINITY);
        // It starts again from where it is if it breaks down, or if the residual that it updates has drifted away.
        while steps > 0 {
            self.apply(&x, &mut r);
            r.iter_mut().zip(&b).for_each(|(r, b)| *r = b - *r);
            let left = length(&r);
            if left < least {
                least = left;
                best.clone_from(&x);
            } else {
                break;
            }
            if left <= DONE * size {
                break;
            }
            self.steps(hierarchy, &mut x, &mut r, (DONE * size, &mut steps));
        }
        (least <= ACCEPTED_RESIDUAL * size).then_some(best)
    }

    /// Steps until the residual is small, or a step cannot be taken.
    fn steps(
        &self,
        hierarchy: &Hierarchy<'_>,
        x: &mut [f64],
        r: &mut [f64],
        (done, left): (f64, &mut usize),
    ) {
        let count = self.len();
        let shadow = r.to_vec();
        let mut p = r.to_vec();
        let [mut v, mut t] = [(); 2].map(|()| vec![0.0; count]);
        let mut rho = dot(&shadow, r);
        while *left > 0 {
            *left -= 1;
            interrupt::check();
            let y = hierarchy.apply(&p);
            self.apply(&y, &mut v);
            let alpha = rho / dot(&shadow, &v);
            if !alpha.is_finite() {
                return;
            }
            add(x, alpha, &y);
            add(r, -alpha, &v);
            let y = hierarchy.apply(r);
            self.apply(&y, &mut t);
            let omega = dot(&t, r) / dot(&t, &t);
            if !omega.is_finite() || omega == 0.0 {
                return;
            }
            add(x, omega, &y);
            add(r, -omega, &t);
            let next = dot(&shadow, r);
            let beta = next / rho * (alpha / omega);
            if length(r) <= done || !beta.is_finite() || beta == 0.0 {
                return;
            }
            rho = next;
            for ((p, r), v) in p.iter_mut().zip(&*r).zip(&v) {
                *p = r + beta * (*p - omega * v);
            }
        }
    }
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
