//! The QR decomposition of a banded matrix with entries around its corners, in the natural order of
//! its columns.
//!
//! The matrix of a closed curve has rows that go around the end. Made upper triangular column by
//! column from the left, these rows fill in as they are rotated with all others, and with them the
//! last columns of R:
//!
//! ```text
//! x x · · · · x               r r r · · r r
//! x x x · · · ·               · r r r · r r
//! · x x x · · ·               · · r r r r r
//! · · x x x · ·   ────────►   · · · r r r r
//! · · · x x x ·               · · · · r r r
//! · · · · x x x               · · · · · r r
//! x · · · · x x               · · · · · · r
//! ```
//!
//! So a row is kept as a *window* of the columns from the pivot on and a *border* of the last
//! columns, and only the rows that the pivot meets are kept: with at most l entries on the left of
//! the diagonal, r on its right and m rows that go around the end these are l + m, so that the
//! decomposition takes `O(n (l + m) (l + r + m))` operations, and `O(n (l + m))` numbers for the
//! rotations.

use std::collections::VecDeque;

use super::banded::Banded;

/// A plane rotation of the pivot row and another one.
#[derive(Clone, Copy, Debug)]
struct Rotation {
    /// The other row.
    row: u32,
    cosine: f64,
    sine: f64,
}

/// The rotations that make a matrix upper triangular, pivot by pivot from the left.
#[derive(Debug)]
pub struct BorderedRotations {
    rotations: Vec<Rotation>,
    /// For each pivot, the number of rotations up to its last one.
    ends: Vec<usize>,
    /// The diagonal of R.
    diagonal: Vec<f64>,
}

/// Where the entries of a matrix stand.
struct Shape {
    /// The number of rows and columns.
    n: usize,
    /// The most entries on the left of the diagonal.
    left: usize,
    /// The number of columns of a window.
    window: usize,
    /// The number of rows at the bottom that have entries around the corner.
    wrapped: usize,
    /// The first column of the border.
    core: usize,
}

/// A row as far as it is not zero, from the column of the pivot on.
struct Row {
    /// Its index.
    index: u32,
    /// The columns from the pivot on that are not in the border.
    window: VecDeque<f64>,
    /// The last columns.
    border: Vec<f64>,
}

impl Shape {
    /// Of the entries that are not zero.
    fn new(matrix: &Banded) -> Self {
        let n = matrix.rows();
        let (mut left, mut right) = (0, 0);
        let (mut wrapped, mut behind, mut before) = (0, 0, 0);
        for (i, j, _) in matrix.entries().filter(|&(.., value)| value != 0.0) {
            match (i + n / 2 < j, j + n / 2 < i) {
                (true, _) => behind = behind.max(n - j),
                (_, true) => (wrapped, before) = (wrapped.max(n - i), before.max(j + 1)),
                _ => {
                    (left, right) = (
                        left.max(i.saturating_sub(j)),
                        right.max(j.saturating_sub(i)),
                    )
                }
            }
        }
        Self {
            n,
            left,
            window: (left + right + 1).max(before),
            wrapped,
            core: n - behind.max(wrapped + left).min(n),
        }
    }

    /// A row of the matrix when `pivot` is the first column that matters: it has no entries in
    /// columns before it.
    fn row(&self, matrix: &Banded, index: usize, pivot: usize) -> Row {
        let mut row = Row {
            index: index as u32,
            window: VecDeque::from(vec![0.0; self.window]),
            border: vec![0.0; self.n - self.core],
        };
        for (j, value) in matrix.row(index).filter(|&(_, value)| value != 0.0) {
            match j.checked_sub(self.core) {
                Some(place) => row.border[place] += value,
                None => row.window[j - pivot] += value,
            }
        }
        row
    }
}

impl Row {
    /// Rotates a part of this row and of another one.
    fn rotate<'a>(
        (cosine, sine): (f64, f64),
        own: impl Iterator<Item = &'a mut f64>,
        other: impl Iterator<Item = &'a mut f64>,
    ) {
        for (x, y) in own.zip(other) {
            (*x, *y) = (cosine * *x + sine * *y, cosine * *y - sine * *x);
        }
    }
}

impl BorderedRotations {
    /// Of a square matrix that may be cyclic.
    pub(super) fn new(matrix: &Banded) -> Self {
        let shape = Shape::new(matrix);
        let n = shape.n;
        let mut found = Self {
            rotations: Vec::with_capacity(n * (shape.left + shape.wrapped)),
            ends: Vec::with_capacity(n),
            diagonal: Vec::with_capacity(n),
        };
        let inner = n - shape.wrapped;
        let mut around: Vec<Row> = (inner..n).map(|i| shape.row(matrix, i, 0)).collect();
        let mut active = VecDeque::new();
        let mut next = 0;
        for pivot in 0..shape.core {
            while next < inner && next <= pivot + shape.left {
                active.push_back(shape.row(matrix, next, pivot));
                next += 1;
            }
            let Some(mut first) = active.pop_front() else {
                return found;
            };
            for other in active.iter_mut().chain(&mut around) {
                found.annihilate(&mut first, other);
            }
            found.end_pivot(first.window[0]);
            for row in active.iter_mut().chain(&mut around) {
                row.window.pop_front();
                row.window.push_back(0.0);
            }
        }
        active.extend((next..inner).map(|i| shape.row(matrix, i, shape.core)));
        let rest = active.into_iter().chain(around).collect();
        found.eliminate_border(rest);
        found
    }

    /// Rotates so that the entry of the other row in the column of the pivot vanishes.
    fn annihilate(&mut self, first: &mut Row, other: &mut Row) {
        let Some(rotation) = self.rotation(first.window[0], other.window[0], other.index) else {
            return;
        };
        Row::rotate(rotation, first.window.iter_mut(), other.window.iter_mut());
        Row::rotate(rotation, first.border.iter_mut(), other.border.iter_mut());
    }

    /// Cosine and sine of the rotation after which `b` of another row has vanished, unless it is
    /// zero already.
    fn rotation(&mut self, a: f64, b: f64, row: u32) -> Option<(f64, f64)> {
        if b == 0.0 {
            return None;
        }
        let length = a.hypot(b);
        let (cosine, sine) = (a / length, b / length);
        let rotation = Rotation { row, cosine, sine };
        self.rotations.push(rotation);
        Some((cosine, sine))
    }

    /// Notes that a pivot is done, with its entry on the diagonal of R.
    fn end_pivot(&mut self, diagonal: f64) {
        self.ends.push(self.rotations.len());
        self.diagonal.push(diagonal);
    }

    /// The last rows, of which only the columns of the border are left: a dense matrix.
    fn eliminate_border(&mut self, mut rows: Vec<Row>) {
        for pivot in 0..rows.len() {
            let (done, others) = rows.split_at_mut(pivot + 1);
            let first = &mut done[pivot];
            for other in others {
                let (a, b) = (first.border[pivot], other.border[pivot]);
                if let Some(rotation) = self.rotation(a, b, other.index) {
                    let (own, other) = (&mut first.border[pivot..], &mut other.border[pivot..]);
                    Row::rotate(rotation, own.iter_mut(), other.iter_mut());
                }
            }
            let diagonal = first.border[pivot];
            self.end_pivot(diagonal);
        }
    }

    /// The number of rows.
    pub(super) fn rows(&self) -> usize {
        self.diagonal.len()
    }

    /// Applies `H Qᵀ` to a line in place.
    pub(super) fn transform(&self, x: &mut [f64]) {
        let mut begin = 0;
        for (k, (&end, diagonal)) in self.ends.iter().zip(&self.diagonal).enumerate() {
            for rotation in &self.rotations[begin..end] {
                let Rotation { row, cosine, sine } = *rotation;
                let j = row as usize;
                (x[k], x[j]) = (cosine * x[k] + sine * x[j], cosine * x[j] - sine * x[k]);
            }
            x[k] /= diagonal;
            begin = end;
        }
    }
}
