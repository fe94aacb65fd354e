//! The collocation matrix `B[i][j] = B_j(t_i)` as an operator.
//!
//! A direction has one matrix, banded for B-splines and dense for polynomial bases. The matrix of a
//! surface is the tensor product `B_u ⊗ B_v`, applied one direction after the other and never
//! formed: with the points as a grid `X`, `(B_u ⊗ B_v) X` is `B_u X B_vᵀ`.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

use super::basis::Basis;
use super::points::Grid;
use super::problem::{Direction, Problem};

/// The collocation matrix of one direction; square, one row for each parameter.
#[derive(Clone, Debug)]
pub enum Collocation {
    /// Local basis: few entries in each row.
    Banded(Banded),
    /// Global basis.
    Dense(DMatrix<f64>),
}

/// A matrix whose rows hold `width` consecutive entries each.
#[derive(Clone, Debug)]
pub struct Banded {
    width: usize,
    /// The column of the first entry of each row.
    first: Vec<u32>,
    /// The entries, row by row.
    values: Vec<f64>,
}

impl Collocation {
    /// The matrix of a direction with respect to its free control points: the columns of end
    /// copies are added to the column of the control point that they copy.
    pub fn new(direction: &Direction) -> Self {
        match direction.basis {
            Basis::Bernstein { .. } => Self::Dense(dense(direction)),
            Basis::BSpline { .. } => Self::Banded(banded(direction)),
        }
    }

    /// Bytes of the matrix of a direction.
    pub fn memory(direction: &Direction) -> usize {
        let rows = direction.free();
        match direction.basis {
            Basis::Bernstein { .. } => rows * rows * size_of::<f64>(),
            Basis::BSpline { .. } => {
                let width = direction.basis.support_width().min(rows);
                rows * (width * size_of::<f64>() + size_of::<u32>())
            }
        }
    }

    /// `Y = X Bᵀ`: applies B to each line of `x`, a row-major grid with as many columns as B has.
    pub fn apply_to_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => {
                let n = banded.first.len();
                for (x, y) in x.chunks_exact(n).zip(y.chunks_exact_mut(n)) {
                    banded.apply(x, y);
                }
            }
            Self::Dense(matrix) => {
                // A row-major grid is the column-major matrix of its transpose.
                let n = matrix.nrows();
                let lines = x.len() / n;
                let x = DMatrixView::from_slice(x, n, lines);
                DMatrixViewMut::from_slice(y, n, lines).gemm(1.0, matrix, &x, 0.0);
            }
        }
    }

    /// `Y = B X`: applies B across the lines of `x`, a row-major grid with as many rows as B has.
    pub fn apply_across_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => banded.apply_across(x, y),
            Self::Dense(matrix) => {
                let n = matrix.nrows();
                let line = x.len() / n;
                let x = DMatrixView::from_slice(x, line, n);
                DMatrixViewMut::from_slice(y, line, n).gemm(1.0, &x, &matrix.transpose(), 0.0);
            }
        }
    }
}

impl Banded {
    fn row(&self, i: usize) -> (usize, &[f64]) {
        let values = &self.values[i * self.width..(i + 1) * self.width];
        (self.first[i] as usize, values)
    }

    /// `y = B x`, with the inner loop unrolled for the usual widths.
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        match self.width {
            1 => self.apply_width::<1>(x, y),
            2 => self.apply_width::<2>(x, y),
            3 => self.apply_width::<3>(x, y),
            4 => self.apply_width::<4>(x, y),
            5 => self.apply_width::<5>(x, y),
            6 => self.apply_width::<6>(x, y),
            _ => {
                for (i, y) in y.iter_mut().enumerate() {
                    let (first, values) = self.row(i);
                    *y = dot(values, &x[first..]);
                }
            }
        }
    }

    fn apply_width<const W: usize>(&self, x: &[f64], y: &mut [f64]) {
        let (rows, _) = self.values.as_chunks::<W>();
        for ((y, row), &first) in y.iter_mut().zip(rows).zip(&self.first) {
            let first = first as usize;
            *y = dot(row, &x[first..first + W]);
        }
    }

    fn apply_across(&self, x: &[f64], y: &mut [f64]) {
        let line = x.len() / self.first.len();
        for (i, y) in y.chunks_exact_mut(line).enumerate() {
            let (first, values) = self.row(i);
            y.fill(0.0);
            for (k, value) in values.iter().enumerate() {
                let x = &x[(first + k) * line..(first + k + 1) * line];
                for (y, x) in y.iter_mut().zip(x) {
                    *y += value * x;
                }
            }
        }
    }
}

/// The sum of products, from the left.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

fn dense(direction: &Direction) -> DMatrix<f64> {
    let n = direction.free();
    let mut values = vec![0.0; n];
    let mut matrix = DMatrix::zeros(n, n);
    for (i, &t) in direction.parameters.iter().enumerate() {
        direction.basis.evaluate(t, &mut values);
        for (j, &value) in values.iter().enumerate() {
            matrix[(i, j)] = value;
        }
    }
    matrix
}

/// Evaluates the rows, then packs them to the width of the widest: at a simple knot one B-spline
/// fewer differs from zero than elsewhere, and end copies share a column.
fn banded(direction: &Direction) -> Banded {
    let n = direction.free();
    let support = direction.basis.support_width();
    let mut wide = vec![0.0; n * support];
    let mut columns = Vec::with_capacity(n);
    let mut values = vec![0.0; support];
    for (row, &t) in wide.chunks_exact_mut(support).zip(&direction.parameters) {
        let start = direction.basis.evaluate(t, &mut values);
        let first = direction.free_index(start);
        for (k, &value) in values.iter().enumerate() {
            row[direction.free_index(start + k) - first] += value;
        }
        columns.push(first);
    }
    pack(&wide, support, &columns)
}

/// Rows of `support` entries that start at the given columns, without the zeros at their ends.
fn pack(wide: &[f64], support: usize, columns: &[usize]) -> Banded {
    let n = columns.len();
    let rows = || wide.chunks_exact(support).zip(columns);
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
    let mut packed = Banded {
        width,
        first: Vec::with_capacity(n),
        values: Vec::with_capacity(n * width),
    };
    for (row, &column) in rows() {
        let (low, high) = filled(row);
        // Rows near the end start earlier, so that they do not reach beyond the last column.
        let first = (column + low).min(n - width);
        let lead = column + low - first;
        let start = packed.values.len();
        packed.first.push(first as u32);
        packed.values.resize(start + width, 0.0);
        packed.values[start + lead..start + lead + high - low].copy_from_slice(&row[low..high]);
    }
    packed
}

/// The collocation matrix of a problem: of a curve, or the tensor product of a surface.
#[derive(Clone, Debug)]
pub struct Tensor {
    grid: Grid,
    u: Collocation,
    v: Option<Collocation>,
}

impl Tensor {
    /// The collocation matrices of both directions of a problem.
    pub fn new(problem: &Problem) -> Self {
        Self {
            grid: problem.grid(),
            u: Collocation::new(problem.u()),
            v: problem.v().map(Collocation::new),
        }
    }

    /// Numbers of scratch space that [`apply`](Self::apply) needs.
    pub fn scratch(&self) -> usize {
        self.v.as_ref().map_or(0, |_| self.grid.count())
    }

    /// `y = (B_u ⊗ B_v) x` for one coordinate of all points.
    pub fn apply(&self, x: &[f64], y: &mut [f64], scratch: &mut [f64]) {
        match &self.v {
            None => self.u.apply_to_lines(x, y),
            Some(v) => {
                v.apply_to_lines(x, scratch);
                self.u.apply_across_lines(scratch, y);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::basis::knots;

    impl Collocation {
        /// The matrix itself, by applying the operator to the unit vectors.
        pub(crate) fn to_matrix(&self, n: usize) -> DMatrix<f64> {
            let identity = DMatrix::identity(n, n);
            let mut lines = vec![0.0; n * n];
            self.apply_to_lines(identity.as_slice(), &mut lines);
            DMatrix::from_row_slice(n, n, &lines).transpose()
        }
    }

    fn bernstein(n: usize) -> Direction {
        Direction {
            basis: Basis::Bernstein { degree: n },
            parameters: (0..=n).map(|i| i as f64 / n as f64).collect(),
            front_copies: 0,
        }
    }

    fn at_data(t: Vec<f64>, degree: usize) -> Direction {
        Direction {
            basis: Basis::BSpline {
                degree,
                knots: knots::at_data(&t, degree),
            },
            parameters: t,
            front_copies: degree / 2,
        }
    }

    fn averaged(t: Vec<f64>, degree: usize) -> Direction {
        Direction {
            basis: Basis::BSpline {
                degree,
                knots: knots::averaged(&t, degree),
            },
            parameters: t,
            front_copies: 0,
        }
    }

    /// Uneven parameters: 0, 1, 1.5, 3.5, 3.75, …
    fn uneven(n: usize) -> Vec<f64> {
        let steps = [1.0, 0.5, 2.0, 0.25];
        (0..n)
            .scan(0.0, |t, i| {
                let now = *t;
                *t += steps[i % 4];
                Some(now)
            })
            .collect()
    }

    fn directions(n: usize) -> Vec<Direction> {
        let mut all = vec![bernstein(n - 1)];
        for degree in 1..=5 {
            all.push(at_data(uneven(n), degree));
            if degree < n {
                all.push(averaged(uneven(n), degree));
            }
        }
        all
    }

    fn matrix(direction: &Direction) -> DMatrix<f64> {
        Collocation::new(direction).to_matrix(direction.free())
    }

    #[test]
    fn rows_sum_to_one() {
        for n in [2, 3, 6, 20] {
            for direction in directions(n) {
                for row in matrix(&direction).row_iter() {
                    assert!((row.sum() - 1.0).abs() < 1e-14, "{:?}", direction.basis);
                }
            }
        }
    }

    #[test]
    fn data_knots_of_odd_degree_give_p_diagonals_and_identity_at_the_ends() {
        let Collocation::Banded(cubic) = Collocation::new(&at_data(uneven(12), 3)) else {
            panic!("a B-spline collocation is banded");
        };
        assert_eq!(cubic.width, 3);
        let cubic = matrix(&at_data(uneven(12), 3));
        assert_eq!(cubic[(0, 0)], 1.0);
        assert_eq!(cubic[(11, 11)], 1.0);
        assert!(cubic[(5, 3)] == 0.0 && cubic[(5, 4)] > 0.0 && cubic[(5, 6)] > 0.0);
    }

    /// Every minor of every order of a totally positive matrix is at least zero (LBW05, section 2).
    #[test]
    fn small_matrices_are_totally_positive() {
        for direction in directions(5) {
            let matrix = matrix(&direction);
            for rows in 1_usize..32 {
                for columns in 1_usize..32 {
                    if rows.count_ones() != columns.count_ones() {
                        continue;
                    }
                    let pick = |set: usize| (0..5).filter(move |i| set >> i & 1 == 1);
                    let minor = matrix
                        .select_rows(&pick(rows).collect::<Vec<_>>())
                        .select_columns(&pick(columns).collect::<Vec<_>>());
                    assert!(minor.determinant() > -1e-15, "{:?}", direction.basis);
                }
            }
        }
    }

    /// The eigenvalues of the Bernstein operator are `m! / ((m − i)! m^i)`; the least is `m!/m^m`.
    #[test]
    fn eigenvalues_of_the_bernstein_operator() {
        for m in 2..=8_usize {
            let mut values: Vec<f64> = matrix(&bernstein(m))
                .complex_eigenvalues()
                .iter()
                .map(|value| value.re)
                .collect();
            values.sort_by(f64::total_cmp);
            let mut exact = vec![1.0];
            for i in 0..m {
                exact.push(exact[i] * (m - i) as f64 / m as f64);
            }
            exact.sort_by(f64::total_cmp);
            for (value, exact) in values.iter().zip(&exact) {
                assert!((value - exact).abs() < 1e-9, "m = {m}: {value} {exact}");
            }
        }
    }

    /// Uniform cubic, n = 10: global PIA contracts by 1 − λ_min = .6551.
    #[test]
    fn rate_of_the_uniform_cubic() {
        let t = (0..=10).map(f64::from).collect();
        let least = matrix(&at_data(t, 3))
            .complex_eigenvalues()
            .iter()
            .map(|value| value.re)
            .fold(f64::INFINITY, f64::min);
        assert!((1.0 - least - 0.6551).abs() < 5e-5);
    }

    #[test]
    fn tensor_products_equal_kronecker_products() {
        let (rows, columns) = (6, 9);
        for u in directions(rows) {
            for v in directions(columns) {
                let kronecker = matrix(&u).kronecker(&matrix(&v));
                let tensor = Tensor {
                    grid: Grid { rows, columns },
                    u: Collocation::new(&u),
                    v: Some(Collocation::new(&v)),
                };
                let x: Vec<f64> = (0..rows * columns)
                    .map(|i| (i as f64 * 0.7).sin())
                    .collect();
                let mut y = vec![0.0; x.len()];
                tensor.apply(&x, &mut y, &mut vec![0.0; tensor.scratch()]);
                let expected = kronecker * nalgebra::DVector::from_vec(x);
                for (y, expected) in y.iter().zip(expected.iter()) {
                    assert!((y - expected).abs() < 1e-14);
                }
            }
        }
    }
}
