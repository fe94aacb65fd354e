//! Tests of collocation matrices and their factorizations.

use std::sync::Arc;

use super::*;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::{Polynomial, knots::Knots};
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::invalid::Axis;
use crate::linear::LineMap;
use crate::parameters::Parametrization;

/// A direction of a basis at these parameters; of a closed one the last is the end of the period.
fn direction(basis: BasisChoice, t: Vec<f64>, closed: bool) -> Direction {
    let rows = t.len() - usize::from(closed);
    let grid = Grid { rows, columns: 1 };
    let choice = DirectionChoice {
        closed,
        ..DirectionChoice::new(basis, Parametrization::Explicit(Arc::new(t)))
    };
    Direction::new(choice, &Points::zeros(1, rows), grid, None, Axis::U).unwrap()
}

/// A polynomial basis of degree n at n + 1 uniform parameters.
fn polynomial(kind: Polynomial, n: usize) -> Direction {
    let t = (0..=n).map(|i| i as f64 / n as f64).collect();
    direction(BasisChoice::Polynomial(kind), t, false)
}

/// The Bernstein basis of degree n at n + 1 uniform parameters.
fn bernstein(n: usize) -> Direction {
    polynomial(Polynomial::Bernstein, n)
}

/// B-splines with knots at the data.
fn at_data(t: Vec<f64>, degree: usize) -> Direction {
    let knots = Knots::Data;
    direction(BasisChoice::BSpline { degree, knots }, t, false)
}

/// B-splines with averaged knots.
fn averaged(t: Vec<f64>, degree: usize) -> Direction {
    let knots = Knots::Averaged;
    direction(BasisChoice::BSpline { degree, knots }, t, false)
}

/// Closed B-splines with n control points.
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

/// All totally positive bases at n parameters, B-splines of degrees 1 to 5.
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

/// All of these, and bases that are not totally positive: Wang–Ball and closed B-splines.
pub(crate) fn all_directions(n: usize) -> Vec<Direction> {
    let mut all = directions(n);
    all.push(polynomial(Polynomial::WangBall, n - 1));
    all.extend((1..n.min(6)).map(|degree| closed(n, degree)));
    all
}

/// The collocation matrix of a direction.
pub(crate) fn matrix(direction: &Direction) -> DMatrix<f64> {
    Collocation::new(direction).to_dense()
}

/// Bases are normalized.
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

/// Cubics: tridiagonal, with identity rows at both ends (LBW05 (3.2)).
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

/// Columns of end copies and periods are where they belong: the functions reproduce constants and,
/// on the period, are shifted copies of each other for uniform knots.
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

/// `B⁻¹ B = I`, and `U B` is upper triangular with ones on its diagonal (Deng13 (9)).
#[test]
fn inverses_and_orthogonal_transforms_are_what_they_say() {
    for n in [2, 3, 6, 9] {
        for direction in all_directions(n) {
            let collocation = Collocation::new(&direction);
            let matrix = collocation.to_dense();
            // Columns of B as lines: their images are the columns of B⁻¹ B and U B.
            let mut lines = matrix.as_slice().to_vec();
            collocation.inverse().apply(&mut lines);
            let identity = DMatrix::from_column_slice(n, n, &lines);
            let deviation = (identity - DMatrix::<f64>::identity(n, n)).amax();
            assert!(deviation < 1e-9, "{:?}: {deviation}", direction.basis);
            let mut lines = matrix.as_slice().to_vec();
            collocation.orthogonal().apply(&mut lines);
            let upper = DMatrix::from_column_slice(n, n, &lines);
            for i in 0..n {
                assert!((upper[(i, i)] - 1.0).abs() < 1e-10);
                for j in (0..n).filter(|&j| j < i) {
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

/// Row by row `H Qᵀ` of the dense QR decomposition in the order of the columns.
fn transform_of_dense(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let qr = matrix.clone().qr();
    let (q, r) = (qr.q(), qr.r());
    let mut transform = q.transpose();
    for i in 0..matrix.nrows() {
        transform.row_mut(i).unscale_mut(r[(i, i)]);
    }
    transform
}

/// The transform of the extended method is that of the thin QR decomposition in the natural order of
/// the columns, whatever the basis.
#[test]
fn the_orthogonal_transform_is_that_of_the_natural_order() {
    let mut directions = vec![bernstein(9)];
    for degree in 1..=9 {
        for n in [degree + 1, degree + 2, 13, 40] {
            if n > degree {
                directions.push(averaged(uneven(n), degree));
                directions.push(closed(n, degree));
            }
            directions.push(at_data(uneven(n), degree));
        }
    }
    for direction in directions {
        let collocation = Collocation::new(&direction);
        let matrix = collocation.to_dense();
        let n = matrix.nrows();
        let mut columns = DMatrix::<f64>::identity(n, n);
        collocation.orthogonal().apply(columns.as_mut_slice());
        let expected = transform_of_dense(&matrix);
        let wrong = (&columns - &expected).norm() / expected.norm();
        assert!(wrong < 1e-10, "{n}, {:?}: {wrong}", direction.basis);
    }
}
