//! Matrices whose rows hold a few consecutive entries each, possibly around the end.

/// A matrix with `width` consecutive entries in each row. In matrices of closed curves the columns
/// are cyclic: behind the last one the first follows.
#[derive(Clone, Debug)]
pub struct Banded {
    columns: usize,
    width: usize,
    /// The column of the first entry of each row.
    first: Vec<u32>,
    /// The entries, row by row.
    values: Vec<f64>,
}

impl Banded {
    /// Packs rows of `support` entries, which start at the given columns, to the width of the
    /// widest: zeros at the ends of rows are left out.
    pub fn pack(wide: &[f64], support: usize, starts: &[usize], columns: usize) -> Self {
        let rows = || wide.chunks_exact(support).zip(starts);
        let filled = |row: &[f64]| {
            let low = row.iter().position(|&x| x != 0.0).unwrap_or(0);
            let high = row.iter().rposition(|&x| x != 0.0).unwrap_or(0);
            (low, high + 1)
        };
        let width = rows()
            .map(|(row, _)| filled(row))
            .map(|(low, high)| high - low)
            .max()
            .unwrap_or(1);
        let mut packed = Self {
            columns,
            width,
            first: Vec::with_capacity(starts.len()),
            values: Vec::with_capacity(starts.len() * width),
        };
        for (row, &start) in rows() {
            let (low, high) = filled(row);
            // Rows near the end start earlier if that keeps them within the columns.
            let column = (start + low) % columns;
            let fits = column + (high - low) <= columns;
            let first = if fits {
                column.min(columns - width)
            } else {
                column
            };
            let lead = column - first;
            let begin = packed.values.len();
            packed.first.push(first as u32);
            packed.values.resize(begin + width, 0.0);
            packed.values[begin + lead..begin + lead + high - low].copy_from_slice(&row[low..high]);
        }
        packed
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.first.len()
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
        self.first
            .iter()
            .any(|&first| first as usize + self.width > self.columns)
    }

    /// The entries of row `i`: columns and values.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let first = self.first[i] as usize;
        let values = &self.values[i * self.width..(i + 1) * self.width];
        values
            .iter()
            .enumerate()
            .map(move |(k, &value)| ((first + k) % self.columns, value))
    }

    /// The diagonal, if all entries on one side of it are zero.
    pub fn diagonal_if_triangular(&self) -> Option<Vec<f64>> {
        let entries = || {
            let row = |i| self.row(i).map(move |(j, value)| (i, j, value));
            (0..self.rows())
                .flat_map(row)
                .filter(|&(.., value)| value != 0.0)
        };
        let triangular = entries().all(|(i, j, _)| i >= j) || entries().all(|(i, j, _)| i <= j);
        triangular.then(|| {
            let mut diagonal = vec![0.0; self.columns];
            for (i, _, value) in entries().filter(|&(i, j, _)| i == j) {
                diagonal[i] = value;
            }
            diagonal
        })
    }

    /// `y = B x`, with the inner loop unrolled for the usual widths.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        match self.width {
            1 => self.apply_width::<1>(x, y),
            2 => self.apply_width::<2>(x, y),
            3 => self.apply_width::<3>(x, y),
            4 => self.apply_width::<4>(x, y),
            5 => self.apply_width::<5>(x, y),
            6 => self.apply_width::<6>(x, y),
            _ => {
                for (i, y) in y.iter_mut().enumerate() {
                    *y = self.dot_row(i, x);
                }
            }
        }
    }

    fn apply_width<const W: usize>(&self, x: &[f64], y: &mut [f64]) {
        let (rows, _) = self.values.as_chunks::<W>();
        for (i, ((y, row), &first)) in y.iter_mut().zip(rows).zip(&self.first).enumerate() {
            let first = first as usize;
            *y = match x.get(first..first + W) {
                Some(x) => row.iter().zip(x).fold(0.0, |sum, (a, b)| sum + a * b),
                None => self.dot_row(i, x),
            };
        }
    }

    fn dot_row(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).fold(0.0, |sum, (j, value)| sum + value * x[j])
    }

    /// `y = Bᵀ x`.
    pub fn apply_transposed(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (i, x) in x.iter().enumerate() {
            for (j, value) in self.row(i) {
                y[j] += value * x;
            }
        }
    }

    /// `Y = B X` for a row-major X with lines of the given length.
    pub fn apply_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        for (i, y) in y.chunks_exact_mut(line).enumerate() {
            y.fill(0.0);
            for (j, value) in self.row(i) {
                add_multiple(y, value, &x[j * line..(j + 1) * line]);
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

fn add_multiple(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// The entries of a matrix column by column, for updates by single columns.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Where the entries of each column start, and where the last one ends.
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Columns {
    /// Sorts entries (row, column, value) that come row by row.
    pub fn new(columns: usize, entries: impl Iterator<Item = (usize, usize, f64)> + Clone) -> Self {
        let nonzero = || entries.clone().filter(|&(.., value)| value != 0.0);
        let mut starts = vec![0; columns + 1];
        for (_, j, _) in nonzero() {
            starts[j + 1] += 1;
        }
        for j in 0..columns {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let mut sorted = vec![(0, 0.0); starts[columns]];
        for (i, j, value) in nonzero() {
            sorted[next[j]] = (i as u32, value);
            next[j] += 1;
        }
        Self {
            starts,
            entries: sorted,
        }
    }

    /// The entries of column `j`: rows and values.
    pub fn column(&self, j: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[j]..self.starts[j + 1]]
    }

    /// The largest number of entries of a column.
    pub fn longest(&self) -> usize {
        let lengths = self.starts.windows(2).map(|pair| pair[1] - pair[0]);
        lengths.max().unwrap_or(0)
    }
}

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
            (0..n)
                .flat_map(|i| matrix.row(i).map(move |(j, value)| (i, j, value)))
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
