//! Square matrices on their way into a factorization: cyclic ones are folded flat.

use super::banded::Banded;

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
        let place = |j: usize| if cyclic { fold(j) } else { j };
        let entries = || {
            matrix
                .entries()
                .filter(|&(.., value)| value != 0.0)
                .map(|(i, j, value)| (place(i), place(j), value))
        };
        let lower = entries()
            .map(|(i, j, _)| i.saturating_sub(j))
            .max()
            .unwrap_or(0);
        let right = entries()
            .map(|(i, j, _)| j.saturating_sub(i))
            .max()
            .unwrap_or(0);
        let mut band = Self {
            lower,
            upper: right + lower,
            rows: vec![0.0; n * (2 * lower + right + 1)],
            folded: cyclic,
        };
        for (i, j, value) in entries() {
            *band.at(i, j) += value;
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
