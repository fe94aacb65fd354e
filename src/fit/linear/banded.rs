//! Matrices whose rows hold a few consecutive entries each, possibly around the end.
//!
//! Nearly everywhere the entries of the next row start one column further on. Such *stretches* of
//! rows are multiplied many rows at a time: entry k of all rows stands in one array, so that each
//! product is one of arrays. The order of the sum is that of a single row, whatever the path.

use std::ops::Range;

/// A matrix with `width` consecutive entries in each row. In matrices of closed curves the columns
/// are cyclic: behind the last one the first follows.
#[derive(Clone, Debug)]
pub struct Banded {
    rows: usize,
    columns: usize,
    width: usize,
    /// The first entries of all rows, then the second ones, …
    entries: Vec<f64>,
    stretches: Vec<Stretch>,
    cyclic: bool,
    reach: usize,
}

/// Rows from `start` on to the next stretch, whose entries start `offset` columns behind the
/// diagonal; not reduced by the period of a cyclic matrix.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    start: u32,
    offset: i32,
}

/// Entries of consecutive rows, each in the column so far behind the diagonal.
pub struct Diagonal<'a> {
    /// The column of an entry is its row and so many; of cyclic matrices not reduced by the period.
    pub offset: i64,
    /// The first row.
    pub start: usize,
    /// The entries.
    pub values: &'a [f64],
}

/// Where a row has entries that are not zero: columns `offset .. offset + length` behind the
/// diagonal.
#[derive(Clone, Copy)]
struct Filled {
    /// The first of them in the row as it is given.
    low: usize,
    length: usize,
    offset: i32,
}

/// Stretches of fewer rows than this, on average, are worth zeros that join them.
const LONG: usize = 64;

/// Shorter parts of stretches are multiplied row by row.
const SHORT: usize = 8;

/// So many stretches are few, whatever their length: rows at the ends have their own.
const FEW: usize = 16;

impl Filled {
    /// Of row `i`, which starts at column `start`.
    fn new(i: usize, row: &[f64], start: usize, columns: usize, cyclic: bool) -> Self {
        let low = row.iter().position(|&x| x != 0.0).unwrap_or(0);
        let high = row.iter().rposition(|&x| x != 0.0).unwrap_or(0);
        let mut offset = ((start + low) % columns) as i32 - i as i32;
        if cyclic {
            // The shorter way around.
            let (columns, half) = (columns as i32, columns as i32 / 2);
            offset = (offset + half).rem_euclid(columns) - half;
        }
        Self {
            low,
            length: high + 1 - low,
            offset,
        }
    }
}

/// Joins rows of equal offsets. With `room`, rows start at that column at the latest and at the
/// first one at the earliest.
fn stretches(offsets: impl Iterator<Item = i32>, room: Option<usize>) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for (i, offset) in offsets.enumerate() {
        let offset = match room {
            Some(room) => (i as i32 + offset).clamp(0, room as i32) - i as i32,
            None => offset,
        };
        if stretches.last().is_none_or(|last| last.offset != offset) {
            let start = i as u32;
            stretches.push(Stretch { start, offset });
        }
    }
    stretches
}

impl Banded {
    /// Packs rows of `support` entries, which start at the given columns, to the width of the
    /// widest: zeros at the ends of rows are left out, unless a few of them make the stretches long.
    pub fn pack(wide: &[f64], support: usize, starts: &[usize], columns: usize) -> Self {
        let rows = starts.len();
        let given = || wide.chunks_exact(support).zip(starts).enumerate();
        let cyclic = given().any(|(i, (row, &start))| {
            let filled = Filled::new(i, row, start % columns, columns, false);
            (i as i32 + filled.offset) as usize + filled.length > columns
        });
        let filled: Vec<Filled> = given()
            .map(|(i, (row, &start))| Filled::new(i, row, start, columns, cyclic))
            .collect();
        let width = filled.iter().map(|it| it.length).max().unwrap_or(1);
        let room = |width| (!cyclic).then(|| columns - width);
        let mut packed = Self {
            rows,
            columns,
            width,
            entries: Vec::new(),
            stretches: stretches(filled.iter().map(|it| it.offset), room(width)),
            cyclic,
            reach: 0,
        };
        let lowest = filled.iter().map(|it| it.offset).min().unwrap_or(0);
        let ends = filled.iter().map(|it| it.offset + it.length as i32);
        let uniform = (ends.max().unwrap_or(1) - lowest) as usize;
        if packed.stretches.len() > FEW + rows / LONG && uniform <= (width + 1).min(columns) {
            packed.width = uniform;
            packed.stretches = stretches(filled.iter().map(|_| lowest), room(uniform));
        }
        let behind = packed.width as i32 - 1;
        let reaches = packed
            .stretches
            .iter()
            .map(|it| (it.offset + behind).max(-it.offset));
        packed.reach = reaches.max().unwrap_or(0).max(0) as usize;
        packed.entries = vec![0.0; rows * packed.width];
        let mut stretches = packed.stretches.iter().peekable();
        let mut first = 0;
        for (i, (filled, (_, (row, _)))) in filled.iter().zip(given()).enumerate() {
            if let Some(stretch) = stretches.next_if(|stretch| stretch.start as usize == i) {
                first = stretch.offset;
            }
            let lead = (filled.offset - first) as usize;
            for (k, value) in row[filled.low..][..filled.length].iter().enumerate() {
                packed.entries[(lead + k) * rows + i] = *value;
            }
        }
        packed
    }

    /// `σ B − I`, if rows have room for the diagonal.
    pub fn shifted(&self, sigma: f64) -> Option<Self> {
        let mut shifted = self.clone();
        shifted.entries.iter_mut().for_each(|x| *x *= sigma);
        let ends = self
            .stretches
            .iter()
            .skip(1)
            .map(|next| next.start as usize);
        for (stretch, end) in self.stretches.iter().zip(ends.chain([self.rows])) {
            let place = usize::try_from(-stretch.offset).ok();
            let place = place.filter(|&place| place < self.width)?;
            let diagonal = &mut shifted.entries[place * self.rows..][stretch.start as usize..end];
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

    /// Whether some row goes around the end.
    pub fn is_cyclic(&self) -> bool {
        self.cyclic
    }

    /// How far the entries of a row reach before and behind the diagonal, at most.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// The column of the first entry of row `i`; in cyclic matrices it can be one before the first
    /// or behind the last column, by a period.
    pub fn first(&self, i: usize) -> i64 {
        i as i64 + i64::from(self.offset(i))
    }

    /// Entry `k` of row `i`.
    pub fn entry(&self, i: usize, k: usize) -> f64 {
        self.entries[k * self.rows + i]
    }

    fn offset(&self, i: usize) -> i32 {
        let behind = self.stretches.partition_point(|it| it.start as usize <= i);
        let stretch = self.stretches.get(behind.wrapping_sub(1));
        stretch.map_or(0, |it| it.offset)
    }

    /// The parts of some rows with equal offsets from the diagonal, and these offsets.
    fn spans(&self, rows: Range<usize>) -> impl Iterator<Item = (i32, Range<usize>)> + Clone + '_ {
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
                values: &self.entries[k * self.rows..][span.clone()],
            })
        })
    }

    /// The entries of row `i`: columns and values.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        self.row_from(i, self.offset(i))
    }

    fn row_from(&self, i: usize, offset: i32) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let first = (i as i64 + i64::from(offset)).rem_euclid(self.columns as i64) as usize;
        (0..self.width).map(move |k| {
            let column = first + k;
            let column = if column < self.columns {
                column
            } else {
                column - self.columns
            };
            (column, self.entries[k * self.rows + i])
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

    /// The diagonal, if all entries on one side of it are zero.
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

    /// `y = B x`.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_rows(0..self.rows, x, 0, y);
    }

    /// `y = B x` for some rows, with the inner loop unrolled for the usual widths. The columns
    /// that these rows need are `x`, which starts with column `base`: a cyclic matrix may need
    /// columns before the first or behind the last one, and wraps around if `x` is all columns.
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

    #[inline(always)]
    fn apply_width<const W: usize>(&self, rows: Range<usize>, x: &[f64], base: i64, y: &mut [f64]) {
        let start = rows.start;
        for (offset, span) in self.spans(rows) {
            let (length, width) = (x.len() as i64, W as i64);
            // Rows whose columns lie within x: all, but for the ends of cyclic matrices.
            let inside = |i: i64| i.clamp(span.start as i64, span.end as i64);
            let low = inside(base - i64::from(offset)) as usize;
            let high =
                inside(base - i64::from(offset) + length - width + 1).max(low as i64) as usize;
            for i in (span.start..low).chain(high..span.end) {
                y[i - start] = self.dot_row(i, offset, x, base);
            }
            if high - low < SHORT {
                for i in low..high {
                    let x = &x[(i as i64 + i64::from(offset) - base) as usize..];
                    let entry = |k| self.entries[k * self.rows + i] * x[k];
                    y[i - start] = (1..W).fold(entry(0), |sum, k| sum + entry(k));
                }
            } else {
                let x = &x[(low as i64 + i64::from(offset) - base) as usize..];
                let b: [&[f64]; W] = std::array::from_fn(|k| &self.entries[k * self.rows + low..]);
                multiply(b, x, &mut y[low - start..high - start]);
            }
        }
    }

    /// The entries of some rows, as arrays along the diagonals, and the columns of x that they are
    /// multiplied with, from the first one of the first row on: if the rows lie in one stretch and
    /// these columns within x, which starts with column `base`.
    #[inline(always)]
    pub fn stretch<'a, const W: usize>(
        &'a self,
        rows: Range<usize>,
        x: &'a [f64],
        base: i64,
    ) -> Option<([&'a [f64]; W], &'a [f64])> {
        let (offset, span) = self.spans(rows.clone()).next()?;
        if span != rows || W != self.width {
            return None;
        }
        let first = usize::try_from(rows.start as i64 + i64::from(offset) - base).ok()?;
        let columns = x.get(first..first + rows.len() + W - 1)?;
        Some((
            std::array::from_fn(|k| &self.entries[k * self.rows..][rows.clone()]),
            columns,
        ))
    }

    fn dot_row(&self, i: usize, offset: i32, x: &[f64], base: i64) -> f64 {
        let first = i as i64 + i64::from(offset) - base;
        let dot = |x: &mut dyn Iterator<Item = f64>| {
            let entries = self.entries[i..].iter().step_by(self.rows);
            let products = entries.zip(x).map(|(b, x)| b * x);
            products.reduce(|sum, product| sum + product).unwrap_or(0.0)
        };
        match usize::try_from(first)
            .ok()
            .and_then(|first| x.get(first..first + self.width))
        {
            Some(x) => dot(&mut x.iter().copied()),
            None => {
                let column = |k| (first + k as i64).rem_euclid(x.len() as i64) as usize;
                dot(&mut (0..self.width).map(|k| x[column(k)]))
            }
        }
    }

    /// `y = Bᵀ x`.
    pub fn apply_transposed(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (i, j, value) in self.entries() {
            y[j] += value * x[i];
        }
    }

    /// `Y = B X` for a row-major X with lines of the given length.
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

    /// `Y = Bᵀ X` for a row-major X with lines of the given length.
    pub fn apply_transposed_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        y.fill(0.0);
        for (i, x) in x.chunks_exact(line).enumerate() {
            for (j, value) in self.row(i) {
                add_multiple(&mut y[j * line..(j + 1) * line], value, x);
            }
        }
    }
}

/// `y_r = Σ_k b_k,r x_{r+k}`.
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

fn add_multiple(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
