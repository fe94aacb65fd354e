//! LU decomposition of totally positive banded matrices, which needs no pivots: elimination makes no
//! entry larger (de Boor, Pinkus 1977).
//!
//! Rows of a fixed number of entries, and as many lines as registers hold: each step waits for the one
//! before, so that several lines take as long as one.

use std::array::from_fn;

use rayon::prelude::*;

use super::LineMap;
use super::banded::{Banded, Diagonal};

/// Lines that are solved side by side.
const LINES: usize = 4;

/// Groups of lines with fewer numbers in all are solved by one thread.
const PARALLEL: usize = 100_000;

/// `L U = B` with at most H entries on each side of the diagonal; the diagonal of U is one.
#[derive(Debug)]
pub(super) struct Elimination<const H: usize> {
    /// The entries of each row of L left of the diagonal, nearest first, divided by the one on it.
    lower: Vec<[f64; H]>,
    /// The reciprocal of the diagonal of L.
    pivots: Vec<f64>,
    /// The entries of each row of U right of the diagonal.
    upper: Vec<[f64; H]>,
}

/// Decomposes a square matrix that is totally positive and not cyclic, if its band is narrow.
pub(super) fn decompose(matrix: &Banded) -> Option<Box<dyn LineMap>> {
    let diagonals: Vec<Diagonal> = matrix.diagonals().collect();
    let filled = |it: &&Diagonal| it.values.iter().any(|&x| x != 0.0);
    let offsets = diagonals.iter().filter(filled).map(|it| it.offset);
    let reach = offsets.map(i64::unsigned_abs).max().unwrap_or(0);
    let n = matrix.rows();
    Some(match reach {
        0 | 1 => Box::new(Elimination::<1>::new(n, &diagonals)),
        2 => Box::new(Elimination::<2>::new(n, &diagonals)),
        3 => Box::new(Elimination::<3>::new(n, &diagonals)),
        4 => Box::new(Elimination::<4>::new(n, &diagonals)),
        _ => return None,
    })
}

impl<const H: usize> Elimination<H> {
    fn new(n: usize, diagonals: &[Diagonal<'_>]) -> Self {
        let zeros = [0.0; H];
        let (mut lower, mut upper) = (vec![zeros; n], vec![zeros; n]);
        let mut pivots = vec![0.0; n];
        for it in diagonals {
            let end = it.start + it.values.len();
            let place = it.offset.unsigned_abs() as usize;
            if place > H {
                // Nothing but zeros.
                continue;
            }
            let pivots = pivots[it.start..end].iter_mut().zip(it.values);
            let lower = lower[it.start..end].iter_mut().zip(it.values);
            let upper = upper[it.start..end].iter_mut().zip(it.values);
            match it.offset {
                0 => pivots.for_each(|(to, value)| *to = *value),
                1.. => upper.for_each(|(to, value)| to[place - 1] = *value),
                _ => lower.for_each(|(to, value)| to[place - 1] = *value),
            }
        }
        let mut all = Self {
            lower,
            pivots,
            upper,
        };
        all.eliminate();
        all
    }

    /// Row by row, by the rows of U before it, the farthest first.
    fn eliminate(&mut self) {
        // The last rows of U, the nearest first.
        let mut before = [[0.0; H]; H];
        let rows = self.lower.iter_mut().zip(&mut self.upper);
        for ((lower, upper), pivot) in rows.zip(&mut self.pivots) {
            for k in (0..H).rev() {
                let factor = lower[k];
                let row = before[k];
                // Entry j of that row is k − j columns left of the diagonal.
                for (j, entry) in row.into_iter().enumerate() {
                    match k.cmp(&j) {
                        std::cmp::Ordering::Greater => lower[k - j - 1] -= factor * entry,
                        std::cmp::Ordering::Equal => *pivot -= factor * entry,
                        std::cmp::Ordering::Less => upper[j - k - 1] -= factor * entry,
                    }
                }
            }
            let reciprocal = 1.0 / *pivot;
            *pivot = reciprocal;
            *upper = upper.map(|x| x * reciprocal);
            *lower = lower.map(|x| x * reciprocal);
            before.rotate_right(1);
            before[0] = *upper;
        }
    }

    /// Solves N lines in place.
    fn solve<const N: usize>(&self, lines: &mut [&mut [f64]; N]) {
        let mut before = [[0.0; N]; H];
        let rows = self.lower.iter().zip(&self.pivots);
        for (i, (lower, pivot)) in rows.enumerate() {
            // The nearest one, which all wait for, comes last.
            let mut x: [f64; N] = from_fn(|line| lines[line][i] * pivot);
            for k in (0..H).rev() {
                x = from_fn(|line| x[line] - lower[k] * before[k][line]);
            }
            before.rotate_right(1);
            before[0] = x;
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
        let mut behind = [[0.0; N]; H];
        for (i, upper) in self.upper.iter().enumerate().rev() {
            let mut x: [f64; N] = from_fn(|line| lines[line][i]);
            for k in (0..H).rev() {
                x = from_fn(|line| x[line] - upper[k] * behind[k][line]);
            }
            behind.rotate_right(1);
            behind[0] = x;
            (0..N).for_each(|line| lines[line][i] = x[line]);
        }
    }

    fn solve_group(&self, lines: &mut [&mut [f64]]) {
        let (n, count) = (self.pivots.len(), lines.len());
        // One length for all, so that places need no checks.
        let mut cut = lines.iter_mut().map(|line| &mut line[..n]);
        let mut next = || cut.next().unwrap_or_default();
        match count {
            0 => {}
            1 => self.solve(&mut [next()]),
            2 => self.solve(&mut [next(), next()]),
            3 => self.solve(&mut [next(), next(), next()]),
            _ => self.solve(&mut [next(), next(), next(), next()]),
        }
    }
}

impl<const H: usize> LineMap for Elimination<H> {
    fn apply(&self, lines: &mut [f64]) {
        let mut lines: Vec<&mut [f64]> = lines.chunks_exact_mut(self.pivots.len()).collect();
        self.apply_each(&mut lines);
    }

    fn apply_each(&self, lines: &mut [&mut [f64]]) {
        if lines.len() > LINES && lines.len() * self.pivots.len() >= PARALLEL {
            let groups = lines.par_chunks_mut(LINES);
            groups.for_each(|group| self.solve_group(group));
        } else {
            let groups = lines.chunks_mut(LINES);
            groups.for_each(|group| self.solve_group(group));
        }
    }
}
