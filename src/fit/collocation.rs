//! The collocation matrix `B[i][j] = B_j(t_i)` as an operator.
//!
//! A direction has one matrix, banded for B-splines and dense for polynomial bases: a row for each
//! data point, a column for each free control point.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

use super::bands;
use super::direction::Direction;
use super::linear::Inverse;
use super::linear::banded::Banded;
use super::linear::columns::Columns;
use super::linear::qr::Orthogonal;

/// Eigenvalues of matrices with more columns are approximate.
pub const LONG: usize = 1000;

/// The collocation matrix of one direction.
#[derive(Clone, Debug)]
pub enum Collocation {
    /// Local basis: few entries in each row.
    Banded(Banded),
    /// Global basis.
    Dense {
        /// The matrix.
        matrix: DMatrix<f64>,
        /// Its transpose.
        transposed: DMatrix<f64>,
    },
}

impl Collocation {
    /// The matrix of a direction with respect to its free control points: the columns of end
    /// copies are added to the column of the control point that they copy.
    pub fn new(direction: &Direction) -> Self {
        if direction.basis.is_local() {
            Self::Banded(bands::banded(direction))
        } else {
            let matrix = dense(direction);
            let transposed = matrix.transpose();
            Self::Dense { matrix, transposed }
        }
    }

    /// The matrix, if it is banded.
    pub fn as_banded(&self) -> Option<&Banded> {
        match self {
            Self::Banded(banded) => Some(banded),
            Self::Dense { .. } => None,
        }
    }

    /// Bytes of the matrix of a direction.
    pub fn memory(direction: &Direction) -> usize {
        let (rows, columns) = (direction.parameters.len(), direction.free());
        if direction.basis.is_local() {
            // One zero more where that makes rows alike.
            let width = (direction.basis.support_width() + 1).min(columns);
            rows * width * size_of::<f64>()
        } else {
            2 * rows * columns * size_of::<f64>()
        }
    }

    /// The number of rows, one for each data point.
    pub fn rows(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.rows(),
            Self::Dense { matrix, .. } => matrix.nrows(),
        }
    }

    /// The number of columns, one for each free control point.
    pub fn columns(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.columns(),
            Self::Dense { matrix, .. } => matrix.ncols(),
        }
    }

    /// The number of entries that are stored: multiplications of applying the matrix to a line.
    pub fn entries(&self) -> usize {
        match self {
            Self::Banded(banded) => banded.rows() * banded.width(),
            Self::Dense { matrix, .. } => matrix.len(),
        }
    }

    /// `Y = X Bᵀ`: applies B to each line of `x`, a row-major grid with as many columns as B has.
    pub fn apply_to_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => {
                let lines = x.chunks_exact(banded.columns());
                for (x, y) in lines.zip(y.chunks_exact_mut(banded.rows())) {
                    banded.apply(x, y);
                }
            }
            Self::Dense { matrix, .. } => multiply_lines(matrix, x, y),
        }
    }

    /// `Y = X B`: applies Bᵀ to each line of `x`, a row-major grid with as many columns as B has rows.
    pub fn apply_transposed_to_lines(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Banded(banded) => {
                let lines = x.chunks_exact(banded.rows());
                for (x, y) in lines.zip(y.chunks_exact_mut(banded.columns())) {
                    banded.apply_transposed(x, y);
                }
            }
            Self::Dense { transposed, .. } => multiply_lines(transposed, x, y),
        }
    }

    /// `Y = B X`: applies B across the lines of `x`, a row-major grid with as many rows as B has
    /// columns.
    pub fn apply_across_lines(&self, x: &[f64], y: &mut [f64]) {
        let line = x.len() / self.columns();
        match self {
            Self::Banded(banded) => banded.apply_across(x, y, line),
            Self::Dense { transposed, .. } => multiply_across(transposed, x, y, line),
        }
    }

    /// `Y = Bᵀ X`: applies Bᵀ across the lines of `x`, a row-major grid with as many rows as B has.
    pub fn apply_transposed_across_lines(&self, x: &[f64], y: &mut [f64]) {
        let line = x.len() / self.rows();
        match self {
            Self::Banded(banded) => banded.apply_transposed_across(x, y, line),
            Self::Dense { matrix, .. } => multiply_across(matrix, x, y, line),
        }
    }

    /// The entries by columns.
    pub(super) fn by_columns(&self) -> Columns {
        match self {
            Self::Banded(banded) => Columns::new(banded.columns(), banded.entries()),
            Self::Dense { matrix, .. } => {
                let row = |i| (0..matrix.ncols()).map(move |j| (i, j, matrix[(i, j)]));
                Columns::new(matrix.ncols(), (0..matrix.nrows()).flat_map(row))
            }
        }
    }

    /// The eigenvalues, if they can be read off.
    pub fn diagonal_if_triangular(&self) -> Option<Vec<f64>> {
        match self {
            Self::Banded(banded) => banded.diagonal_if_triangular(),
            Self::Dense { .. } => None,
        }
    }

    /// `B⁻¹`, for a square matrix.
    pub fn inverse(&self) -> Inverse {
        match self {
            Self::Banded(banded) => Inverse::of_collocation(banded),
            Self::Dense { matrix, .. } => Inverse::of_dense(matrix),
        }
    }

    /// `(σ B − I)⁻¹`, for a square matrix and σ above 1/λ_min: `exact` if it is near, of matrices that
    /// are not long.
    pub fn shifted_inverse(&self, sigma: f64, exact: bool) -> Option<Inverse> {
        match self {
            Self::Banded(banded) if exact && banded.columns() <= LONG => {
                banded.shifted(sigma).as_ref().map(Inverse::of_banded)
            }
            Self::Banded(banded) => Inverse::of_shifted(banded, sigma),
            Self::Dense { matrix, .. } => {
                let identity = DMatrix::identity(matrix.nrows(), matrix.ncols());
                Some(Inverse::of_dense(&(matrix * sigma - identity)))
            }
        }
    }

    /// `H Qᵀ`, for a square matrix (Deng13 (9)).
    pub fn orthogonal(&self) -> Orthogonal {
        match self {
            Self::Banded(banded) => Orthogonal::of_banded(banded),
            Self::Dense { matrix, .. } => Orthogonal::of_dense(matrix),
        }
    }
}

/// A row-major grid is the column-major matrix of its transpose: `Yᵀ = M Xᵀ`.
fn multiply_lines(matrix: &DMatrix<f64>, x: &[f64], y: &mut [f64]) {
    let lines = x.len() / matrix.ncols();
    let x = DMatrixView::from_slice(x, matrix.ncols(), lines);
    DMatrixViewMut::from_slice(y, matrix.nrows(), lines).gemm(1.0, matrix, &x, 0.0);
}

/// `Yᵀ = Xᵀ Mᵀ`, with the transpose given.
fn multiply_across(transposed: &DMatrix<f64>, x: &[f64], y: &mut [f64], line: usize) {
    let x = DMatrixView::from_slice(x, line, transposed.nrows());
    DMatrixViewMut::from_slice(y, line, transposed.ncols()).gemm(1.0, &x, transposed, 0.0);
}

fn dense(direction: &Direction) -> DMatrix<f64> {
    let columns = direction.free();
    let mut values = vec![0.0; columns];
    let mut matrix = DMatrix::zeros(direction.parameters.len(), columns);
    for (i, &t) in direction.parameters.iter().enumerate() {
        direction.evaluate(t, &mut values);
        for (j, &value) in values.iter().enumerate() {
            matrix[(i, j)] = value;
        }
    }
    matrix
}

#[cfg(test)]
pub(super) mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fit::basis::{Polynomial, knots::Knots};
    use crate::fit::direction::{BasisChoice, DirectionChoice};
    use crate::fit::invalid::Axis;
    use crate::fit::linear::LineMap;
    use crate::fit::parameters::Parametrization;
    use crate::fit::points::{Grid, Points};

    impl Collocation {
        /// The matrix itself, by applying the operator to the unit vectors.
        pub(crate) fn to_matrix(&self) -> DMatrix<f64> {
            let (rows, columns) = (self.rows(), self.columns());
            let identity = DMatrix::identity(columns, columns);
            let mut lines = vec![0.0; rows * columns];
            self.apply_to_lines(identity.as_slice(), &mut lines);
            DMatrix::from_column_slice(rows, columns, &lines)
        }
    }

    fn direction(basis: BasisChoice, t: Vec<f64>, closed: bool) -> Direction {
        let rows = t.len() - usize::from(closed);
        let grid = Grid { rows, columns: 1 };
        let choice = DirectionChoice {
            basis,
            parameters: Parametrization::Explicit(Arc::new(t)),
            closed,
            control_points: None,
            weights: None,
        };
        Direction::new(choice, &Points::zeros(1, rows), grid, None, Axis::U).unwrap()
    }

    fn polynomial(kind: Polynomial, n: usize) -> Direction {
        let t = (0..=n).map(|i| i as f64 / n as f64).collect();
        direction(BasisChoice::Polynomial(kind), t, false)
    }

    fn bernstein(n: usize) -> Direction {
        polynomial(Polynomial::Bernstein, n)
    }

    fn at_data(t: Vec<f64>, degree: usize) -> Direction {
        let knots = Knots::Data;
        direction(BasisChoice::BSpline { degree, knots }, t, false)
    }

    fn averaged(t: Vec<f64>, degree: usize) -> Direction {
        let knots = Knots::Averaged;
        direction(BasisChoice::BSpline { degree, knots }, t, false)
    }

    fn closed(n: usize, degree: usize) -> Direction {
        let knots = Knots::Data;
        direction(BasisChoice::BSpline { degree, knots }, uneven(n + 1), true)
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
        let mut all = vec![bernstein(n - 1), polynomial(Polynomial::SaidBall, n - 1)];
        for degree in 1..=5 {
            all.push(at_data(uneven(n), degree));
            if degree < n {
                all.push(averaged(uneven(n), degree));
            }
        }
        all
    }

    /// Those, and bases that are not totally positive.
    pub(in crate::fit) fn all_directions(n: usize) -> Vec<Direction> {
        let mut all = directions(n);
        all.push(polynomial(Polynomial::WangBall, n - 1));
        all.extend((1..n.min(6)).map(|degree| closed(n, degree)));
        all
    }

    pub(in crate::fit) fn matrix(direction: &Direction) -> DMatrix<f64> {
        Collocation::new(direction).to_matrix()
    }

    #[test]
    fn rows_sum_to_one() {
        for n in [2, 3, 6, 20] {
            for direction in all_directions(n) {
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
        assert_eq!(cubic.width(), 3);
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

    /// Columns of end copies and periods are where they belong: the functions reproduce constants
    /// and, on the period, are shifted copies of each other for uniform knots.
    #[test]
    fn uniform_closed_matrices_are_circulant() {
        for degree in 1..=6 {
            let t = (0..=9).map(f64::from).collect();
            let knots = Knots::Data;
            let matrix = matrix(&direction(BasisChoice::BSpline { degree, knots }, t, true));
            for i in 0..9 {
                for j in 0..9 {
                    let shifted = matrix[((i + 1) % 9, (j + 1) % 9)];
                    assert!((matrix[(i, j)] - shifted).abs() < 1e-14);
                    assert!((matrix[(i, j)] - matrix[(j, i)]).abs() < 1e-14);
                }
                assert!(matrix[(i, i)] >= matrix.row(i).max());
            }
        }
    }

    #[test]
    fn inverses_and_orthogonal_transforms_are_what_they_say() {
        for n in [2, 3, 6, 9] {
            for direction in all_directions(n) {
                let collocation = Collocation::new(&direction);
                let matrix = collocation.to_matrix();
                // Columns of B as lines: their images are the columns of B⁻¹ B and U B.
                let mut lines = matrix.as_slice().to_vec();
                collocation.inverse().apply(&mut lines);
                let identity = DMatrix::from_column_slice(n, n, &lines);
                let deviation = (identity - DMatrix::<f64>::identity(n, n)).amax();
                assert!(deviation < 1e-9, "{:?}: {deviation}", direction.basis);
                let mut lines = matrix.as_slice().to_vec();
                collocation.orthogonal().apply(&mut lines);
                let upper = DMatrix::from_column_slice(n, n, &lines);
                // Closed curves are factorized in a folded order.
                let fold = crate::fit::linear::folded(n);
                let wraps = matches!(&collocation, Collocation::Banded(b) if b.is_cyclic());
                let place = |i| if wraps { fold(i) } else { i };
                for i in 0..n {
                    assert!((upper[(i, i)] - 1.0).abs() < 1e-10);
                    for j in (0..n).filter(|&j| place(j) < place(i)) {
                        assert!(upper[(i, j)].abs() < 1e-9, "{:?}", direction.basis);
                    }
                }
            }
        }
    }

    /// Several lines side by side, by elimination with and without pivots, of the longest from both
    /// ends.
    #[test]
    fn long_matrices_are_solved() {
        for (n, degree) in [300, 100_001]
            .into_iter()
            .flat_map(|n| (1..=8).map(move |p| (n, p)))
        {
            for direction in [at_data(uneven(n), degree), averaged(uneven(n), degree)] {
                let collocation = Collocation::new(&direction);
                for lines in (1..=6).step_by(if n > 300 { 3 } else { 1 }) {
                    let x: Vec<f64> = (0..lines * n).map(|i| (i as f64 * 0.7).sin()).collect();
                    let mut y = vec![0.0; x.len()];
                    collocation.apply_to_lines(&x, &mut y);
                    let mut onto = y.clone();
                    let inverse = collocation.inverse();
                    inverse.apply_each(&mut y.chunks_mut(n).collect::<Vec<_>>());
                    if let Inverse::Positive(solver) = inverse {
                        let others: Vec<&[f64]> = x.chunks(n).collect();
                        solver.apply_onto(&mut onto.chunks_mut(n).collect::<Vec<_>>(), &others);
                        let sums = y.iter().zip(&x).map(|(y, x)| y + x);
                        assert!(sums.eq(onto), "{n}, degree {degree}, {lines} lines");
                    }
                    // The condition numbers of the highest degrees are near 1e5.
                    let far = x.iter().zip(&y).map(|(x, y)| (x - y).abs());
                    let far = far.fold(0.0, f64::max);
                    assert!(far < 1e-9, "{n}, degree {degree}, {lines} lines: {far}");
                }
            }
        }
    }
}
