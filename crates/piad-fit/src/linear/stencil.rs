//! Symmetric matrices over the functions of a grid, each of which meets those within p lines and q columns.
//!
//! There are (2p + 1)(2q + 1) diagonals, and a product with them runs along lines. Around a closed direction the first
//! p functions follow the last ones once more, as a margin: an entry is at one of its places, and products with a
//! vector whose margin repeats its beginning are added up at the end.

use rayon::prelude::*;

/// Lines that one thread takes at least.
const LINES: usize = 8;

/// One direction of the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// The number of functions, with the margin of a closed direction.
    pub count: usize,
    /// How far the functions are apart that meet.
    pub degree: usize,
    /// True if the last `degree` functions are the first ones again.
    pub is_closed: bool,
}

impl Reach {
    fn width(self) -> usize {
        2 * self.degree + 1
    }

    /// The first of two functions that meet, at a place from which the other one is within reach, and by how much more
    /// than `-degree` this comes after it.
    fn place(self, one: usize, other: usize) -> (usize, usize) {
        let (p, mut apart) = (self.degree as isize, other as isize - one as isize);
        let period = (self.count - self.degree) as isize;
        if self.is_closed && apart.abs() > p {
            apart -= apart.signum() * period;
        }
        let is_before = one as isize + apart < 0;
        let one = if is_before {
            one + period as usize
        } else {
            one
        };
        (one, (apart + p).max(0) as usize)
    }
}

/// The matrix.
#[derive(Debug)]
pub(crate) struct Stencil {
    u: Reach,
    v: Reach,
    /// For each line its diagonals, each with a number for each function of v.
    values: Vec<f64>,
}

impl Stencil {
    /// The number of numbers.
    pub(crate) fn numbers([u, v]: [Reach; 2]) -> usize {
        u.count * u.width() * v.width() * v.count
    }

    /// Without an entry.
    pub(crate) fn zeros([u, v]: [Reach; 2]) -> Self {
        let values = vec![0.0; Self::numbers([u, v])];
        Self { u, v, values }
    }

    /// The diagonals of each line from a function, which several threads call.
    pub(crate) fn by_lines(reach: [Reach; 2], fill: impl Fn(usize, &mut [f64]) + Sync) -> Self {
        let mut all = Self::zeros(reach);
        let line = all.line();
        let lines = all.values.par_chunks_mut(line).enumerate();
        lines.for_each(|(k, diagonals)| fill(k, diagonals));
        all
    }

    fn line(&self) -> usize {
        self.u.width() * self.v.width() * self.v.count
    }

    /// Adds to the entry of two functions, by their lines and columns without margins.
    pub(crate) fn add(&mut self, one: [usize; 2], other: [usize; 2], value: f64) {
        let (row, line) = self.u.place(one[0], other[0]);
        let (column, offset) = self.v.place(one[1], other[1]);
        let diagonal = (row * self.u.width() + line) * self.v.width() + offset;
        self.values[diagonal * self.v.count + column] += value;
    }

    /// All entries that can differ from zero, by the lines and columns of two functions, which can be in the margin.
    pub(crate) fn each_entry(&self, mut visit: impl FnMut([usize; 2], [usize; 2], f64)) {
        let (widths, columns) = ([self.u.width(), self.v.width()], self.v.count);
        for (at, diagonal) in self.values.chunks_exact(columns).enumerate() {
            let (line, offset) = (at / widths[1], at % widths[1]);
            let (k, offset_u) = (line / widths[0], line % widths[0]);
            let Some(m) = (k + offset_u)
                .checked_sub(self.u.degree)
                .filter(|m| *m < self.u.count)
            else {
                continue;
            };
            for (l, &entry) in diagonal.iter().enumerate() {
                let other = (l + offset).checked_sub(self.v.degree);
                if let Some(n) = other.filter(|n| *n < columns) {
                    visit([k, l], [m, n], entry);
                }
            }
        }
    }

    /// The product with a vector that has margins; the sums are to be added up where it repeats.
    pub(crate) fn product(&self, x: &[f64]) -> Vec<f64> {
        let (p, q, columns) = (self.u.degree, self.v.degree, self.v.count);
        // Beyond the first and the last function there are zeros.
        let stride = columns + 2 * q;
        let mut around = vec![0.0; (self.u.count + 2 * p) * stride];
        let lines = around[p * stride..].chunks_exact_mut(stride);
        for (around, x) in lines.zip(x.chunks_exact(columns)) {
            around[q..q + columns].copy_from_slice(x);
        }
        let mut sums = vec![0.0; self.u.count * columns];
        let lines = sums.par_chunks_mut(columns).with_min_len(LINES);
        let values = self.values.par_chunks(self.line());
        lines.zip(values).enumerate().for_each(|(k, (sums, line))| {
            let mut diagonals = line.chunks_exact(columns);
            for row in k..=k + 2 * p {
                for (column, diagonal) in (0..=2 * q).zip(&mut diagonals) {
                    let x = &around[row * stride + column..][..columns];
                    let terms = diagonal.iter().zip(x);
                    let pairs = sums.iter_mut().zip(terms);
                    pairs.for_each(|(sum, (a, x))| *sum += a * x);
                }
            }
        });
        sums
    }

    /// The same with the absolute values of all entries and a vector of ones.
    pub(crate) fn sums_of_absolute_values(&self) -> Vec<f64> {
        let columns = self.v.count;
        let mut sums = vec![0.0; self.u.count * columns];
        let lines = self.values.chunks_exact(self.line());
        for (sums, line) in sums.chunks_exact_mut(columns).zip(lines) {
            for diagonal in line.chunks_exact(columns) {
                let pairs = sums.iter_mut().zip(diagonal);
                pairs.for_each(|(sum, a)| *sum += a.abs());
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A product is that of the whole matrix, also around closed directions with few functions.
    #[test]
    fn products_are_those_of_all_entries() {
        for (free, is_closed) in [
            ([7, 5], [false, false]),
            ([7, 4], [true, false]),
            ([4, 9], [true, true]),
        ] {
            let degrees = [2, 3];
            let reach = [0, 1].map(|axis| Reach {
                count: free[axis] + if is_closed[axis] { degrees[axis] } else { 0 },
                degree: degrees[axis],
                is_closed: is_closed[axis],
            });
            let meet = |axis: usize, i: usize, j: usize| {
                let apart = i.abs_diff(j);
                let around = free[axis] - apart;
                apart.min(if is_closed[axis] { around } else { apart }) <= degrees[axis]
            };
            let [rows, columns] = free;
            let mut stencil = Stencil::zeros(reach);
            let x = |i: usize, j: usize| ((3 * i + 5 * j) % 7) as f64 - 2.0;
            let mut expected = vec![0.0; rows * columns];
            for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
                for (k, l) in (0..rows).flat_map(|k| (0..columns).map(move |l| (k, l))) {
                    if meet(0, i, k) && meet(1, j, l) {
                        let value = (1 + i * k + j * l) as f64;
                        stencil.add([i, j], [k, l], value);
                        expected[i * columns + j] += value * x(k, l);
                    }
                }
            }
            let width = reach[1].count;
            let places = (0..reach[0].count * width).map(|at| (at / width, at % width));
            let places: Vec<_> = places.map(|(i, j)| (i % rows, j % columns)).collect();
            let around: Vec<f64> = places.iter().map(|&(i, j)| x(i, j)).collect();
            let mut product = vec![0.0; rows * columns];
            for (&(i, j), sum) in places.iter().zip(stencil.product(&around)) {
                product[i * columns + j] += sum;
            }
            assert_eq!(product, expected);
        }
    }
}
