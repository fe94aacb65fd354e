//! Matrices whose rows hold a few consecutive entries each, possibly around the end.
//!
//! Nearly everywhere the entries of the next row start one column further on. Such *stretches* of
//! rows are multiplied many rows at a time: entry k of all rows is in one array, a *diagonal*, so
//! that each product is one of arrays:
//!
//! ```text
//! row i:   columns i + s … i + s + W − 1,   offset s of its stretch
//! y_i   =  Σ_k e_k,i x_{i+s+k},             k = 0 … W − 1, from the first on
//! ```
//!
//! The order of the sum is that of a single row, whatever the path, so that results are the same to
//! the last bit. A matrix takes n W numbers and a product n W multiplications.

use std::ops::Range;

use crate::data::aligned::Lane;

/// A matrix with `width` consecutive entries in each row. In matrices of closed curves the columns
/// are cyclic: the last one is followed by the first.
#[derive(Clone, Debug)]
pub struct Banded {
    rows: usize,
    columns: usize,
    width: usize,
    /// The first entries of all rows, the second ones, and so on: `width` lanes of `rows` numbers.
    entries: Vec<Lane>,
    /// Increasing by their first row; the first one starts with row 0.
    stretches: Vec<Stretch>,
    /// True if some row goes around the end.
    cyclic: bool,
    /// The largest distance of an entry from the diagonal.
    reach: usize,
}

/// Consecutive rows, up to the next stretch, whose entries start at the same distance from the
/// diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The first row.
    pub start: u32,
    /// The column of entry k of row i is `i + offset + k`, in cyclic matrices but for whole
    /// periods.
    pub offset: i32,
}

/// Entries of consecutive rows along a parallel to the diagonal.
pub struct Diagonal<'a> {
    /// The column of the entry of row i is `i + offset`, in cyclic matrices but for whole periods.
    pub offset: i64,
    /// The first row.
    pub start: usize,
    /// The entries, one for each row.
    pub values: &'a [f64],
}

/// Stretches with fewer rows are multiplied row by row.
const SHORT: usize = 8;

impl Banded {
    /// A matrix of its entries: the first ones of all rows, the second ones, and so on.
    pub(super) fn new(
        entries: Vec<Lane>,
        columns: usize,
        stretches: Vec<Stretch>,
        cyclic: bool,
    ) -> Self {
        let behind = entries.len() as i32 - 1;
        let reaches = stretches
            .iter()
            .map(|it| (it.offset + behind).max(-it.offset));
        Self {
            rows: entries.first().map_or(0, |lane| lane.len()),
            columns,
            width: entries.len(),
            reach: reaches.max().unwrap_or(0).max(0) as usize,
            entries,
            stretches,
            cyclic,
        }
    }

    /// `σ B − I`, or `None` if the diagonal lies outside of the band in some row.
    pub fn shifted(&self, sigma: f64) -> Option<Self> {
        let mut shifted = self.clone();
        let entries = shifted.entries.iter_mut().flatten();
        entries.for_each(|x| *x *= sigma);
        let ends = self
            .stretches
            .iter()
            .skip(1)
            .map(|next| next.start as usize);
        for (stretch, end) in self.stretches.iter().zip(ends.chain([self.rows])) {
            let place = usize::try_from(-stretch.offset).ok();
            let place = place.filter(|&place| place < self.width)?;
            let diagonal = &mut shifted.entries[place][stretch.start as usize..end];
            diagonal.iter_mut().for_each(|x| *x -= 1.0);
        }
        Some(shifted)
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The number of entries of each row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns true if some row goes around the end.
    pub fn is_cyclic(&self) -> bool {
        self.cyclic
    }

    /// The largest distance of an entry from the diagonal, in columns.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// The column of the first entry of row `i`. In cyclic matrices it can lie before the first
    /// column or behind the last one, by a period.
    pub fn first(&self, i: usize) -> i64 {
        i as i64 + i64::from(self.offset(i))
    }

    /// Entry `k` of row `i`.
    pub fn entry(&self, i: usize, k: usize) -> f64 {
        self.entries[k][i]
    }

    /// The offset of the stretch of row `i`, found by bisection.
    fn offset(&self, i: usize) -> i32 {
        let behind = self.stretches.partition_point(|it| it.start as usize <= i);
        let stretch = self.stretches.get(behind.wrapping_sub(1));
        stretch.map_or(0, |it| it.offset)
    }

    /// The stretches of some rows: their offsets, and which of the rows belong to each.
    pub fn spans(
        &self,
        rows: Range<usize>,
    ) -> impl Iterator<Item = (i32, Range<usize>)> + Clone + '_ {
        let behind = self
            .stretches
            .partition_point(|it| it.start as usize <= rows.start);
        let stretches = &self.stretches[behind.saturating_sub(1)..];
        let ends = stretches.iter().skip(1).map(|next| next.start as usize);
        let ends = ends.chain(std::iter::once(self.rows));
        stretches
            .iter()
            .zip(ends)
            .map(move |(stretch, end)| {
                let start = rows.start.max(stretch.start as usize);
                (stretch.offset, start..end.min(rows.end))
            })
            .take_while(|(_, span)| !span.is_empty())
    }

    /// All entries, along the diagonals.
    pub fn diagonals(&self) -> impl Iterator<Item = Diagonal<'_>> + '_ {
        self.spans(0..self.rows).flat_map(move |(offset, span)| {
            (0..self.width).map(move |k| Diagonal {
                offset: i64::from(offset) + k as i64,
                start: span.start,
                values: &self.entries[k][span.clone()],
            })
        })
    }

    /// The entries of row `i`: columns and values.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        self.row_from(i, self.offset(i))
    }

    /// The same, if the offset is known.
    fn row_from(&self, i: usize, offset: i32) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let first = (i as i64 + i64::from(offset)).rem_euclid(self.columns as i64) as usize;
        (0..self.width).map(move |k| {
            let column = first + k;
            let column = if column < self.columns {
                column
            } else {
                column - self.columns
            };
            (column, self.entries[k][i])
        })
    }

    /// All entries, row by row: rows, columns and values.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + Clone + '_ {
        self.spans(0..self.rows).flat_map(move |(offset, span)| {
            span.flat_map(move |i| {
                self.row_from(i, offset)
                    .map(move |(j, value)| (i, j, value))
            })
        })
    }

    /// The entries of column `j` that differ from zero: rows, increasing, and values. Only rows
    /// near it are examined, as far from the diagonal as entries reach.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (rows, columns) = (self.rows as i64, self.columns as i64);
        let (low, high) = (j as i64 - self.reach as i64, (j + self.reach + 1) as i64);
        // A period to the left, and one to the right, of what goes around the end.
        let shifts = match self.cyclic {
            true if high - low >= rows => [Some(-low), None, None],
            true => [Some(-rows), Some(0), Some(rows)],
            false => [Some(0), None, None],
        };
        let near = shifts.into_iter().flatten().map(move |shift| {
            let row = |i: i64| (i + shift).clamp(0, rows) as usize;
            row(low)..row(high)
        });
        let spans = near.flat_map(|rows| self.spans(rows));
        let places = spans.flat_map(|(offset, span)| span.map(move |i| (i, offset)));
        let entries = places.flat_map(move |(i, offset)| {
            let first = j as i64 - i as i64 - i64::from(offset);
            let places = (first.rem_euclid(columns) as usize..self.width).step_by(self.columns);
            places.map(move |k| (i, self.entries[k][i]))
        });
        entries.filter(|&(_, value)| value != 0.0)
    }

    /// The diagonal, which holds the eigenvalues, if all entries on one side of it are zero.
    pub fn diagonal_if_triangular(&self) -> Option<Vec<f64>> {
        let entries = || self.entries().filter(|&(.., value)| value != 0.0);
        let triangular = entries().all(|(i, j, _)| i >= j) || entries().all(|(i, j, _)| i <= j);
        triangular.then(|| {
            let mut diagonal = vec![0.0; self.columns];
            for (i, _, value) in entries().filter(|&(i, j, _)| i == j) {
                diagonal[i] = value;
            }
            diagonal
        })
    }

    /// `y = B x` for a line x of `columns` numbers and y of `rows` numbers.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_rows(0..self.rows, x, 0, y);
    }

    /// `y = B x` for some rows, with the inner loop unrolled for the usual widths. `x` holds the
    /// columns that these rows need, from column `base` on: a cyclic matrix may need columns before
    /// the first or behind the last one, and wraps around if `x` holds all columns. y has a number
    /// for each of the rows.
    #[inline(always)]
    pub fn apply_rows(&self, rows: Range<usize>, x: &[f64], base: i64, y: &mut [f64]) {
        match self.width {
            1 => self.apply_width::<1>(rows, x, base, y),
            2 => self.apply_width::<2>(rows, x, base, y),
            3 => self.apply_width::<3>(rows, x, base, y),
            4 => self.apply_width::<4>(rows, x, base, y),
            5 => self.apply_width::<5>(rows, x, base, y),
            6 => self.apply_width::<6>(rows, x, base, y),
            7 => self.apply_width::<7>(rows, x, base, y),
            _ => {
                let start = rows.start;
                for (offset, span) in self.spans(rows) {
                    for i in span {
                        y[i - start] = self.dot_row(i, offset, x, base);
                    }
                }
            }
        }
    }

    /// The same with W entries in each row.
    #[inline(always)]
    fn apply_width<const W: usize>(&self, rows: Range<usize>, x: &[f64], base: i64, y: &mut [f64]) {
        let start = rows.start;
        for (offset, span) in self.spans(rows) {
            let Range {
                start: low,
                end: high,
            } = self.inside(offset, span.clone(), x.len(), base);
            for i in (span.start..low).chain(high..span.end) {
                y[i - start] = self.dot_row(i, offset, x, base);
            }
            if high - low < SHORT {
                for i in low..high {
                    let x = &x[(i as i64 + i64::from(offset) - base) as usize..];
                    let entry = |k: usize| self.entries[k][i] * x[k];
                    y[i - start] = (1..W).fold(entry(0), |sum, k| sum + entry(k));
                }
            } else {
                let x = &x[(low as i64 + i64::from(offset) - base) as usize..];
                let b: [&[f64]; W] = std::array::from_fn(|k| &self.entries[k][low..]);
                multiply(b, x, &mut y[low - start..high - start]);
            }
        }
    }

    /// Entry `k` of some consecutive rows.
    pub fn diagonal(&self, k: usize, rows: Range<usize>) -> &[f64] {
        &self.entries[k][rows]
    }

    /// The rows of a span whose columns all lie among `columns` columns from column `base` on:
    /// every row but those at the ends of cyclic matrices.
    pub fn inside(
        &self,
        offset: i32,
        span: Range<usize>,
        columns: usize,
        base: i64,
    ) -> Range<usize> {
        let inside = |i: i64| i.clamp(span.start as i64, span.end as i64) as usize;
        let low = base - i64::from(offset);
        let start = inside(low);
        start..inside(low + columns as i64 - self.width as i64 + 1).max(start)
    }

    /// The product of row `i`, in a stretch of this offset, with x, which starts with column
    /// `base`.
    pub fn dot_row(&self, i: usize, offset: i32, x: &[f64], base: i64) -> f64 {
        let first = i as i64 + i64::from(offset) - base;
        let inside = usize::try_from(first).ok();
        let inside = inside.and_then(|first| x.get(first..first + self.width));
        let product = |k: usize| {
            let x = match inside {
                Some(x) => x[k],
                None => x[(first + k as i64).rem_euclid(x.len() as i64) as usize],
            };
            self.entries[k][i] * x
        };
        (1..self.width).fold(product(0), |sum, k| sum + product(k))
    }

    /// `y = Bᵀ x` for a line x of `rows` numbers and y of `columns` numbers.
    pub fn apply_transposed(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (offset, span) in self.spans(0..self.rows) {
            for i in span {
                let factor = x[i];
                let first = (i as i64 + i64::from(offset)) as usize;
                // A row that does not go around the end; of others `first` can be far beyond it.
                let place = first..first.saturating_add(self.width);
                if let Some(y) = y.get_mut(place) {
                    for (y, lane) in y.iter_mut().zip(&self.entries) {
                        *y += lane[i] * factor;
                    }
                } else {
                    for (j, value) in self.row_from(i, offset) {
                        y[j] += value * factor;
                    }
                }
            }
        }
    }

    /// `Y = B X` for a row-major X of `columns` lines of the given length: a line of Y is a sum of
    /// multiples of lines of X.
    pub fn apply_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        for (i, y) in y.chunks_exact_mut(line).enumerate() {
            for (k, (j, value)) in self.row(i).enumerate() {
                let x = &x[j * line..(j + 1) * line];
                if k == 0 {
                    y.iter_mut().zip(x).for_each(|(y, x)| *y = value * x);
                } else {
                    add_multiple(y, value, x);
                }
            }
        }
    }

    /// `Y = Bᵀ X` for a row-major X of `rows` lines of the given length.
    pub fn apply_transposed_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        y.fill(0.0);
        for (i, x) in x.chunks_exact(line).enumerate() {
            for (j, value) in self.row(i) {
                add_multiple(&mut y[j * line..(j + 1) * line], value, x);
            }
        }
    }
}

/// `y_r = Σ_k b_k,r x_{r+k}`, summed up from k = 0 on: all rows of a stretch at a time.
#[inline(always)]
fn multiply<const W: usize>(b: [&[f64]; W], x: &[f64], y: &mut [f64]) {
    let n = y.len();
    let b: [&[f64]; W] = std::array::from_fn(|k| &b[k][..n]);
    let x: [&[f64]; W] = std::array::from_fn(|k| &x[k..k + n]);
    for r in 0..n {
        let mut sum = b[0][r] * x[0][r];
        for k in 1..W {
            sum += b[k][r] * x[k][r];
        }
        y[r] = sum;
    }
}

/// `y ← y + factor x`.
fn add_multiple(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
