//! LU decomposition of banded matrices with partial pivoting.
//!
//! With l entries below and r to the right of the diagonal `P B = L U` takes `2 n l (l + r)`
//! operations, and solving for a line `2 n (2 l + r)`: swapping rows lets U reach l places further
//! to the right. Cyclic matrices are factorized in the folded order of [`folded`](super::folded),
//! in which they are banded.
//!
//! It is the fallback where elimination without pivots is not safe, or not written for the
//! bandwidth: for closed curves, high degrees, and matrices that are shifted near an eigenvalue.

use super::band::{Band, unfolded};
use super::banded::Banded;
use super::map::LineMap;
use crate::interrupt;

/// A factorized matrix: solves for a line in O(n · bandwidth).
#[derive(Debug)]
pub struct BandedLu {
    /// The number of rows.
    n: usize,
    /// The most entries of a column of L below the diagonal.
    lower: usize,
    /// The most entries of a row of U to the right of the diagonal.
    upper: usize,
    /// U row by row: the diagonal and `upper` entries to the right of it.
    u: Vec<f64>,
    /// L column by column: the `lower` multipliers below the diagonal, which itself is one.
    l: Vec<f64>,
    /// The row with which each row was swapped before it was eliminated.
    pivots: Vec<u32>,
    /// True if rows and columns are in the folded order.
    folded: bool,
}

impl BandedLu {
    /// Factorizes a square matrix, which may be cyclic. A singular one gives infinite or NaN
    /// solutions.
    pub fn new(matrix: &Banded) -> Self {
        let n = matrix.rows();
        let mut band = Band::new(matrix);
        let (lower, upper) = (band.lower, band.upper);
        let mut l = vec![0.0; n * lower];
        let mut pivots = Vec::with_capacity(n);
        for k in 0..n {
            interrupt::check();
            let below = lower.min(n - 1 - k);
            let right = upper.min(n - 1 - k);
            let pivot = (k..=k + below)
                .rev()
                .max_by(|&a, &b| f64::total_cmp(&band.at(a, k).abs(), &band.at(b, k).abs()))
                .unwrap_or(k);
            pivots.push(pivot as u32);
            if pivot != k {
                for j in k..=k + right.min(upper + lower) {
                    if j + lower >= pivot && j <= pivot + upper {
                        let a = *band.at(k, j);
                        let b = std::mem::replace(band.at(pivot, j), a);
                        *band.at(k, j) = b;
                    }
                }
            }
            let diagonal = *band.at(k, k);
            for r in 1..=below {
                let factor = *band.at(k + r, k) / diagonal;
                l[k * lower + r - 1] = factor;
                if factor != 0.0 {
                    for j in k + 1..=k + right {
                        let above = *band.at(k, j);
                        *band.at(k + r, j) -= factor * above;
                    }
                }
            }
        }
        let width = band.width();
        let mut u = Vec::with_capacity(n * (upper + 1));
        for row in band.rows.chunks_exact(width) {
            u.extend_from_slice(&row[lower..]);
        }
        Self {
            n,
            lower,
            upper,
            u,
            l,
            pivots,
            folded: band.folded,
        }
    }

    /// Solves `B x = b` in place; `at` says which index is at each place of the order of rows.
    fn solve(&self, x: &mut [f64], at: impl Fn(usize) -> usize) {
        let n = self.n;
        for k in 0..n {
            x.swap(at(k), at(self.pivots[k] as usize));
            let pivot = x[at(k)];
            let below = self.lower.min(n - 1 - k);
            let factors = &self.l[k * self.lower..k * self.lower + below];
            for (r, factor) in factors.iter().enumerate() {
                x[at(k + 1 + r)] -= factor * pivot;
            }
        }
        for k in (0..n).rev() {
            let right = self.upper.min(n - 1 - k);
            let row = &self.u[k * (self.upper + 1)..k * (self.upper + 1) + right + 1];
            let known = row[1..].iter().enumerate();
            let sum = known.fold(x[at(k)], |sum, (r, u)| sum - u * x[at(k + 1 + r)]);
            x[at(k)] = sum / row[0];
        }
    }
}

impl LineMap for BandedLu {
    fn apply(&self, lines: &mut [f64]) {
        for line in lines.chunks_exact_mut(self.n) {
            if self.folded {
                self.solve(line, unfolded(self.n));
            } else {
                self.solve(line, |k| k);
            }
        }
    }
}
