//! Dense matrices: as linear maps, their products with several vectors, and their LU decomposition
//! with partial pivoting, `P B = L U`.
//!
//! The decomposition takes `2/3 n³` operations, solving for a line `2 n²`. Polynomial bases have
//! such matrices, of degrees for which that is little.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, Dyn};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::map::LineMap;

/// A factorized matrix: `2 n²` operations to solve for a line.
#[derive(Debug)]
pub struct DenseLu {
    lu: nalgebra::LU<f64, Dyn, Dyn>,
    /// The number of rows.
    n: usize,
}

impl DenseLu {
    /// Factorizes a square matrix.
    pub(super) fn new(matrix: &DMatrix<f64>) -> Self {
        Self {
            lu: matrix.clone().lu(),
            n: matrix.nrows(),
        }
    }
}

impl LineMap for DenseLu {
    /// Solves `B x = b` for every line. A singular matrix leaves infinite numbers, which end the
    /// iteration.
    fn apply(&self, lines: &mut [f64]) {
        let Self { lu, n } = self;
        let mut view = DMatrixViewMut::from_slice(lines, *n, lines.len() / n);
        if !lu.solve_mut(&mut view) {
            // Singular to working precision: the iteration ends with an overflow.
            view.fill(f64::INFINITY);
        }
    }
}

/// A square matrix as a linear map: n² multiplications for a line.
#[derive(Debug)]
pub(in crate::fit) struct DenseMap {
    matrix: DMatrix<f64>,
}

impl DenseMap {
    /// The map of a square matrix.
    pub(in crate::fit) fn new(matrix: DMatrix<f64>) -> Self {
        Self { matrix }
    }
}

impl LineMap for DenseMap {
    fn apply(&self, lines: &mut [f64]) {
        let n = self.matrix.nrows();
        let image = &self.matrix * DMatrixView::from_slice(lines, n, lines.len() / n);
        lines.copy_from_slice(image.as_slice());
    }
}

/// The rows of a block: 2 KiB of each column.
const ROWS: usize = 256;

/// Products with matrices of more numbers are computed by several threads.
const PARALLEL: usize = 100_000;

/// `y = M x` for several x, for which M is read from memory once. Each number is summed up column by
/// column, whatever the instruction set and the number of threads.
pub(in crate::fit) fn multiply<'a>(
    matrix: &DMatrix<f64>,
    x: &[&[f64]],
    y: impl Iterator<Item = &'a mut [f64]>,
) {
    let mut blocks: Vec<Vec<&mut [f64]>> = Vec::new();
    blocks.resize_with(matrix.nrows().div_ceil(ROWS), Vec::new);
    for y in y {
        let parts = blocks.iter_mut().zip(y.chunks_mut(ROWS));
        parts.for_each(|(block, part)| block.push(part));
    }
    let product = |(index, y): (usize, Vec<&mut [f64]>)| {
        let start = index * ROWS;
        Arch::new().dispatch(Product {
            matrix,
            start,
            x,
            y,
        });
    };
    if matrix.len() < PARALLEL {
        blocks.into_iter().enumerate().for_each(product);
    } else {
        blocks.into_par_iter().enumerate().for_each(product);
    }
}

/// The rows of products from `start` on, compiled for several instruction sets.
struct Product<'a> {
    matrix: &'a DMatrix<f64>,
    start: usize,
    x: &'a [&'a [f64]],
    y: Vec<&'a mut [f64]>,
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    /// Four columns at a time, so that sums are seldom written.
    #[inline(always)]
    fn call(mut self) {
        let rows = self.matrix.nrows();
        for y in &mut self.y {
            y.fill(0.0);
        }
        let groups = self.matrix.as_slice().chunks(4 * rows);
        for (columns, first) in groups.zip((0..).step_by(4)) {
            for (x, y) in self.x.iter().zip(&mut self.y) {
                let count = y.len();
                let part = |k: usize| &columns[k * rows + self.start..][..count];
                match x[first..] {
                    [a, b, c, d, ..] => {
                        let [p, q, r, s] = [0, 1, 2, 3].map(part);
                        for (i, y) in y.iter_mut().enumerate() {
                            *y = (((*y + p[i] * a) + q[i] * b) + r[i] * c) + s[i] * d;
                        }
                    }
                    ref last => {
                        for (k, x) in last.iter().enumerate() {
                            let pairs = y.iter_mut().zip(part(k));
                            pairs.for_each(|(y, entry)| *y += entry * x);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of several vectors at a time, in blocks and by several threads.
    #[test]
    fn products_are_sums_of_columns() {
        for (rows, columns) in [(1, 1), (5, 3), (257, 4), (600, 7), (400, 403)] {
            let matrix = DMatrix::from_fn(rows, columns, |i, j| ((i * 7 + j * 3) as f64).sin());
            let x = [0.3, 0.7, 1.1].map(|a| {
                let numbers = (0..columns).map(|j| (a * j as f64).cos());
                numbers.collect::<Vec<f64>>()
            });
            let mut y = [(); 3].map(|()| vec![f64::NAN; rows]);
            let views = x.each_ref().map(|x| &x[..]);
            multiply(&matrix, &views, y.iter_mut().map(|y| &mut y[..]));
            for (x, y) in x.iter().zip(&y) {
                for (i, y) in y.iter().enumerate() {
                    let sum = (0..columns).fold(0.0, |sum, j| sum + matrix[(i, j)] * x[j]);
                    assert_eq!(*y, sum, "{rows} × {columns}, row {i}");
                }
            }
        }
    }
}
