//! Square matrices before their factorization: cyclic ones are folded flat.
//!
//! The matrix of a closed curve has entries around the corners, which elimination would spread over
//! whole columns. If its indices are ordered 0, n−1, 1, n−2, …, as on a circle that is pressed
//! flat, neighbours stay within two places of each other, and the matrix is an ordinary banded one
//! of twice the bandwidth:
//!
//! ```text
//! x x · · · x               x x x · · ·
//! x x x · · ·               x x · x · ·
//! · x x x · ·    folded     x · x · x ·
//! · · x x x ·   ────────►   · x · x · x
//! · · · x x x               · · x · x x
//! x · · · x x               · · · x x x
//! ```

use super::banded::{Banded, Diagonal};
use crate::data::monotonic;

/// The place of each index in the folded order 0, n−1, 1, n−2, … of n rows and columns.
pub(crate) fn folded(n: usize) -> impl Fn(usize) -> usize + Copy {
    move |j| {
        if 2 * j < n {
            2 * j
        } else {
            2 * (n - 1 - j) + 1
        }
    }
}

/// The index at each place of the folded order: the inverse of [`folded`].
pub(super) fn unfolded(n: usize) -> impl Fn(usize) -> usize + Copy {
    move |k| {
        if k.is_multiple_of(2) {
            k / 2
        } else {
            n - 1 - k / 2
        }
    }
}

/// A square matrix of n rows with rows and columns in an order in which it is banded, and with room
/// for what factorizing fills in: n (2 l + r + 1) numbers for l entries below and r to the right of
/// the diagonal.
pub(super) struct Band {
    /// The most entries below the diagonal in a column.
    pub lower: usize,
    /// The most entries to the right of the diagonal in a row, with those that factorizing can fill
    /// in.
    pub upper: usize,
    /// Row by row the entries in columns `i − lower ..= i + upper`.
    pub rows: Vec<f64>,
    /// True if the order is the folded one.
    pub folded: bool,
}

impl Band {
    /// Copies a matrix. Row operations, swaps or rotations, fill in up to `lower` more entries to
    /// the right.
    pub(super) fn new(matrix: &Banded) -> Self {
        let n = matrix.rows();
        let (cyclic, fold) = (matrix.is_cyclic(), folded(n));
        let entries = || {
            matrix
                .entries()
                .filter(|&(.., value)| value != 0.0)
                .map(|(i, j, value)| (fold(i), fold(j), value))
        };
        // The largest distance of an entry that is not zero from the diagonal, on either side.
        let filled = || {
            matrix
                .diagonals()
                .filter(|it| !monotonic::is_zero(it.values))
        };
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

    /// The numbers that are kept of each row.
    pub(super) fn width(&self) -> usize {
        self.lower + self.upper + 1
    }

    /// The entry in row `i` and column `j` of the order, which must lie within the band.
    pub(super) fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        let width = self.width();
        &mut self.rows[i * width + j + self.lower - i]
    }
}
