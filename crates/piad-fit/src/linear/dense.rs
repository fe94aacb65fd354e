//! Dense matrices: as linear maps, the products of those that have zeros at the ends of their rows,
//! and their LU decomposition with partial pivoting, `P B = L U`.
//!
//! The decomposition takes `2/3 n³` operations, solving for a line `2 n²`. Polynomial bases have
//! such matrices, of degrees for which that is little.

use std::ops::Range;
use std::sync::OnceLock;

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
    pub(super) fn new(matrix: DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        Self { lu: matrix.lu(), n }
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
pub(crate) struct DenseMap {
    matrix: DMatrix<f64>,
}

impl DenseMap {
    /// The map of a square matrix.
    pub(crate) fn new(matrix: DMatrix<f64>) -> Self {
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

/// The matrix of a polynomial direction, row by row. Products read nothing of a row but its support,
/// outside of which its entries are zero.
#[derive(Clone, Debug)]
pub struct Dense {
    /// Column i is row i of the matrix.
    transposed: DMatrix<f64>,
    /// The columns of the support of each row.
    supports: Vec<Range<usize>>,
    /// The matrix itself, once a surface needs it: then products run along columns.
    matrix: OnceLock<DMatrix<f64>>,
}

/// The rows of a block: 512 bytes of a product.
const ROWS: usize = 64;

/// Products of matrices with more entries are computed by several threads.
const PARALLEL: usize = 100_000;

/// From this number of lines on, products are those of matrices with matrices.
const LINES: usize = 8;

impl Dense {
    /// The matrix whose transpose this is.
    pub fn new(transposed: DMatrix<f64>) -> Self {
        let rows = transposed.as_slice().chunks_exact(transposed.nrows());
        let support = |row: &[f64]| {
            let mut nonzero = row.iter().map(|&entry| entry != 0.0);
            let first = nonzero.clone().position(|nonzero| nonzero);
            let last = nonzero.rposition(|nonzero| nonzero);
            first
                .zip(last)
                .map_or(0..0, |(first, last)| first..last + 1)
        };
        let supports = rows.map(support).collect();
        Self {
            transposed,
            supports,
            matrix: OnceLock::new(),
        }
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.transposed.ncols()
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.transposed.nrows()
    }

    /// The number of entries, with those that are zero.
    pub fn len(&self) -> usize {
        self.transposed.len()
    }

    /// The entries in the support of a row: columns and values.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let support = self.supports[i].clone();
        let entries = &self.transposed.as_slice()[i * self.columns()..][support.clone()];
        support.zip(entries.iter().copied())
    }

    /// The entries of column `j` that differ from zero: rows, increasing, and values.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let entries = self.transposed.row(j);
        let entries = (0..self.rows()).map(move |i| (i, entries[i]));
        entries.filter(|&(_, value)| value != 0.0)
    }

    /// The matrix in nalgebra's form.
    pub fn to_matrix(&self) -> DMatrix<f64> {
        self.transposed.transpose()
    }

    /// The same, kept for the next time.
    fn matrix(&self) -> &DMatrix<f64> {
        self.matrix.get_or_init(|| self.to_matrix())
    }

    /// `y = B x` for several x. The terms of a number are added up in an order that depends neither
    /// on the instruction set nor on the number of threads.
    pub fn apply<'a>(&self, x: &[&[f64]], y: impl Iterator<Item = &'a mut [f64]>) {
        let mut blocks: Vec<Vec<&mut [f64]>> = Vec::new();
        blocks.resize_with(self.rows().div_ceil(ROWS), Vec::new);
        for y in y {
            let parts = blocks.iter_mut().zip(y.chunks_mut(ROWS));
            parts.for_each(|(block, part)| block.push(part));
        }
        let product = |(index, y): (usize, Vec<&mut [f64]>)| {
            let first = index * ROWS;
            Arch::new().dispatch(Product {
                matrix: self,
                first,
                x,
                y,
            });
        };
        if self.len() < PARALLEL {
            blocks.into_iter().enumerate().for_each(product);
        } else {
            blocks.into_par_iter().enumerate().for_each(product);
        }
    }

    /// `Y = X Bᵀ`: B is applied to each line of `x`. A row-major grid is the column-major matrix of
    /// its transpose: `Yᵀ = B Xᵀ`.
    pub fn apply_to_lines(&self, x: &[f64], y: &mut [f64]) {
        let (rows, columns) = (self.rows(), self.columns());
        let lines = x.len() / columns;
        if lines < LINES {
            let x: Vec<&[f64]> = x.chunks_exact(columns).collect();
            self.apply(&x, y.chunks_exact_mut(rows));
        } else {
            let x = DMatrixView::from_slice(x, columns, lines);
            DMatrixViewMut::from_slice(y, rows, lines).gemm(1.0, self.matrix(), &x, 0.0);
        }
    }

    /// `Y = X B`: Bᵀ is applied to each line of `x`.
    pub fn apply_transposed_to_lines(&self, x: &[f64], y: &mut [f64]) {
        let (rows, columns) = (self.rows(), self.columns());
        let lines = x.len() / rows;
        let x = DMatrixView::from_slice(x, rows, lines);
        DMatrixViewMut::from_slice(y, columns, lines).gemm(1.0, &self.transposed, &x, 0.0);
    }

    /// `Y = B X`: B is applied across the lines of `x`; `Yᵀ = Xᵀ Bᵀ`.
    pub fn apply_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        let x = DMatrixView::from_slice(x, line, self.columns());
        DMatrixViewMut::from_slice(y, line, self.rows()).gemm(1.0, &x, &self.transposed, 0.0);
    }

    /// `Y = Bᵀ X`: Bᵀ is applied across the lines of `x`; `Yᵀ = Xᵀ B`.
    pub fn apply_transposed_across(&self, x: &[f64], y: &mut [f64], line: usize) {
        let x = DMatrixView::from_slice(x, line, self.rows());
        DMatrixViewMut::from_slice(y, line, self.columns()).gemm(1.0, &x, self.matrix(), 0.0);
    }
}

/// The rows of products from `first` on, compiled for several instruction sets.
struct Product<'a> {
    matrix: &'a Dense,
    first: usize,
    x: &'a [&'a [f64]],
    y: Vec<&'a mut [f64]>,
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Dense {
            transposed,
            supports,
            ..
        } = self.matrix;
        let columns = transposed.nrows();
        for (x, y) in self.x.iter().zip(self.y) {
            let rows = transposed.as_slice()[self.first * columns..].chunks_exact(columns);
            let rows = rows.zip(&supports[self.first..]);
            for (y, (row, support)) in y.iter_mut().zip(rows) {
                *y = product(&row[support.clone()], &x[support.clone()]);
            }
        }
    }
}

/// The number of sums that are added up side by side: the numbers of the widest vector.
const SUMS: usize = 8;

/// `Σ a_j b_j`
#[inline(always)]
fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (a, rest) = a.as_chunks::<SUMS>();
    let (b, other) = b.as_chunks::<SUMS>();
    for (a, b) in a.iter().zip(b) {
        for k in 0..SUMS {
            sums[k] += a[k] * b[k];
        }
    }
    for ((sum, a), b) in sums.iter_mut().zip(rest).zip(other) {
        *sum += a * b;
    }
    let mut half = SUMS / 2;
    while half > 0 {
        for k in 0..half {
            sums[k] += sums[k + half];
        }
        half /= 2;
    }
    sums[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of few and of many lines, in blocks and by several threads, with and without zeros at the
    /// ends of rows, against nalgebra's products.
    #[test]
    fn products_equal_those_of_the_matrix() {
        for (rows, columns) in [(1, 1), (5, 3), (65, 4), (600, 7), (400, 403)] {
            for half in [2, columns] {
                let entry = |i: usize, j: usize| {
                    let away = (i * columns).abs_diff(j * rows);
                    let value = ((i * 7 + j * 3) as f64).sin();
                    if away <= half * rows { value } else { 0.0 }
                };
                let matrix = DMatrix::from_fn(rows, columns, entry);
                let dense = Dense::new(matrix.transpose());
                assert_eq!(dense.to_matrix(), matrix);
                for lines in [1, 3, LINES] {
                    let grid = |rows, columns| {
                        DMatrix::from_fn(rows, columns, |i, j| (0.7 * (i + 3 * j) as f64).cos())
                    };
                    let check = |what: &str, y: &DMatrix<f64>, expected: DMatrix<f64>| {
                        let apart = (y - expected).amax();
                        assert!(apart < 1e-12, "{what} {rows} × {columns}, {lines}: {apart}");
                    };
                    let (x, mut y) = (grid(columns, lines), DMatrix::zeros(rows, lines));
                    dense.apply_to_lines(x.as_slice(), y.as_mut_slice());
                    check("B", &y, &matrix * &x);
                    let (x, mut y) = (grid(rows, lines), DMatrix::zeros(columns, lines));
                    dense.apply_transposed_to_lines(x.as_slice(), y.as_mut_slice());
                    check("Bᵀ", &y, matrix.tr_mul(&x));
                    let (x, mut y) = (grid(lines, columns), DMatrix::zeros(lines, rows));
                    dense.apply_across(x.as_slice(), y.as_mut_slice(), lines);
                    check("B across", &y, &x * matrix.transpose());
                    let (x, mut y) = (grid(lines, rows), DMatrix::zeros(lines, columns));
                    dense.apply_transposed_across(x.as_slice(), y.as_mut_slice(), lines);
                    check("Bᵀ across", &y, &x * &matrix);
                }
            }
        }
    }

    /// A row without any entry is zero, and rows are what they were made of.
    #[test]
    fn rows_are_their_supports() {
        let transposed = DMatrix::from_column_slice(3, 2, &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
        let dense = Dense::new(transposed);
        assert_eq!(dense.row(0).count(), 0);
        assert_eq!(dense.row(1).collect::<Vec<_>>(), [(1, 2.0)]);
        let mut y = [f64::NAN; 2];
        dense.apply_to_lines(&[1.0, 3.0, 5.0], &mut y);
        assert_eq!(y, [0.0, 6.0]);
    }
}
