//! Square matrices on their way into a factorization: cyclic ones are folded flat.

use super::banded::{Banded, Diagonal};
use crate::fit::order;

/// An order of rows and columns in which a cyclic band is an ordinary one of twice the width: the
/// circle is folded flat, 0, n−1, 1, n−2, …
pub fn folded(n: usize) -> impl Fn(usize) -> usize + Copy {
    move |j| {
        if 2 * j < n {
            2 * j
        } else {
            2 * (n - 1 - j) + 1
        }
    }
}

/// The index at each place of that order.
pub fn unfolded(n: usize) -> impl Fn(usize) -> usize + Copy {
    move |k| {
        if k.is_multiple_of(2) {
            k / 2
        } else {
            n - 1 - k / 2
        }
    }
}

/// A square matrix with rows and columns in an order in which it is banded; for factorizations.
pub(super) struct Band {
    /// Entries below the diagonal in each column, at most.
    pub lower: usize,
    /// Entries to the right of the diagonal in each row that factorizing can fill.
    pub upper: usize,
    /// Row by row, the columns `i − lower ..= i + upper`.
    pub rows: Vec<f64>,
    /// Whether the order is the folded one.
    pub folded: bool,
}

impl Band {
    /// Makes room for the fill-in of factorizations by rows: `lower` more to the right.
    pub(super) fn new(matrix: &Banded) -> Self {
        let n = matrix.rows();
        let (cyclic, fold) = (matrix.is_cyclic(), folded(n));
        let entries = || {
            matrix
                .entries()
                .filter(|&(.., value)| value != 0.0)
                .map(|(i, j, value)| (fold(i), fold(j), value))
        };
        // How far to the right of the diagonal there is something, or to the left.
        let filled = || matrix.diagonals().filter(|it| !order::is_zero(it.values));
        let reach = |sign: i64| match cyclic {
            true => entries()
                .map(|(i, j, _)| sign * (j as i64 - i as i64))
                .max(),
            false => filled().map(|it| sign * it.offset).max(),
        };
        let right = reach(1).unwrap_or(0).max(0) as usize;
        let lower = reach(-1).unwrap_or(0).max(0) as usize;
        let mut band = Self {
            lower,
            upper: right + lower,
            rows: vec![0.0; n * (2 * lower + right + 1)],
            folded: cyclic,
        };
        if cyclic {
            for (i, j, value) in entries() {
                *band.at(i, j) += value;
            }
        } else {
            let width = band.width();
            for Diagonal {
                offset,
                start,
                values,
            } in filled()
            {
                let first = start * width + (offset + lower as i64) as usize;
                let places = band.rows[first..].iter_mut().step_by(width);
                places
                    .zip(values)
                    .for_each(|(place, value)| *place = *value);
            }
        }
        band
    }

    pub(super) fn width(&self) -> usize {
        self.lower + self.upper + 1
    }

    /// The entry in row `i` and column `j`, which lie within the band.
    pub(super) fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        let width = self.width();
        &mut self.rows[i * width + j + self.lower - i]
    }
}
