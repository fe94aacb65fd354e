//! The methods that are special cases of a given transform, and refused matrices.

use nalgebra::{Complex, DMatrix};

use super::*;
use crate::basis::Polynomial;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::invalid::{Axis, Place};
use crate::iteration::Iteration;
use crate::iteration::system::System;
use crate::linear::LineMap;
use crate::matrix::spectrum;
use crate::method::{Local, Method, Omega, Weighted};
use crate::parameters::Parametrization;
use crate::problem::Problem;
use crate::problem::request::{Request, Tolerance};

/// Cubic B-splines with knots at the data.
fn cubic() -> BasisChoice {
    let knots = Knots::Data;
    BasisChoice::BSpline { degree: 3, knots }
}

/// Uneven points of a wave, a curve if there is one column.
fn request(rows: usize, columns: usize, basis: BasisChoice, method: Method) -> Request {
    let mut points = Points::new(3);
    for i in 0..rows * columns {
        let (x, y) = ((i / columns) as f64, (i % columns) as f64);
        let x = x + 0.3 * (2.0 * x).sin();
        points.push(&[x, y + 0.1 * x.cos(), (0.7 * x).sin() + (0.4 * y).cos()]);
    }
    let direction = || DirectionChoice::new(basis.clone(), Parametrization::ChordLength);
    Request {
        method,
        tolerance: Some(Tolerance::Absolute(1e-13)),
        max_iterations: 100,
        ..Request::new(
            points,
            Grid { rows, columns },
            direction(),
            (columns > 1).then(direction),
        )
    }
}

/// The collocation matrices of that request, `B_u` and `B_v`.
fn collocation(rows: usize, columns: usize) -> Vec<DMatrix<f64>> {
    let problem = Problem::new(request(rows, columns, cubic(), Method::Global)).unwrap();
    let tensor = problem.tensor();
    tensor.directions().map(|b| b.to_dense()).collect()
}

/// The rows of a matrix, as they are given.
fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let row = |i| matrix.row(i).iter().copied().collect();
    (0..matrix.nrows()).map(row).collect()
}

/// The method with one matrix for each direction.
fn custom(matrices: &[DMatrix<f64>]) -> Method {
    let v = matrices.get(1).map(rows);
    Method::Custom(Custom::new(rows(&matrices[0]), v))
}

/// Level 0.
fn start(request: Request) -> Iteration {
    let problem = Problem::new(request).unwrap();
    Iteration::start(Arc::new(System::new(Arc::new(problem))))
}

/// Takes 12 levels with both methods, whose control points may differ by `tolerance`, if any.
fn assert_alike(one: Request, other: Request, tolerance: f64) {
    let (mut one, mut other) = (start(one), start(other));
    for level in 0..12 {
        let (a, b) = (one.control_points(), other.control_points());
        for (a, b) in a.lanes().iter().flatten().zip(b.lanes().iter().flatten()) {
            assert!((a - b).abs() <= tolerance, "level {level}: {a} {b}");
        }
        one.step();
        other.step();
    }
}

/// A curve and a surface.
const GRIDS: [(usize, usize); 2] = [(30, 1), (9, 7)];

/// An identity for each direction, times the number of each.
fn scaled(sizes: (usize, usize), factors: [f64; 2]) -> Vec<DMatrix<f64>> {
    let identity = |n, factor| DMatrix::<f64>::identity(n, n) * factor;
    let mut all = vec![identity(sizes.0, factors[0])];
    if sizes.1 > 1 {
        all.push(identity(sizes.1, factors[1]));
    }
    all
}

/// To the last bit.
#[test]
fn the_identity_is_classical_pia() {
    for (n, m) in GRIDS {
        let given = request(n, m, cubic(), custom(&scaled((n, m), [1.0, 1.0])));
        assert_alike(given, request(n, m, cubic(), Method::Global), 0.0);
    }
}

/// To the last bit.
#[test]
fn multiples_of_the_identity_are_weighted_pia() {
    for (n, m) in GRIDS {
        let omega = Some(1.25);
        let given = request(n, m, cubic(), custom(&scaled((n, m), [1.25, 1.0])));
        let weighted = Method::Weighted(Weighted { omega });
        assert_alike(given, request(n, m, cubic(), weighted), 0.0);
    }
}

/// To rounding.
#[test]
fn the_inverse_is_direct() {
    for (n, m) in GRIDS {
        let inverses = collocation(n, m).into_iter().map(|b| b.try_inverse());
        let inverses: Vec<_> = inverses.map(Option::unwrap).collect();
        let given = request(n, m, cubic(), custom(&inverses));
        assert_alike(given, request(n, m, cubic(), Method::Direct), 1e-12);
    }
}

/// To rounding; of a surface each direction has its own ρ.
#[test]
fn the_scaled_transpose_is_transpose() {
    for (n, m) in GRIDS {
        let problem = Problem::new(request(n, m, cubic(), Method::Global)).unwrap();
        let tensor = problem.tensor();
        let scaled = tensor
            .directions()
            .map(|b| b.to_dense().transpose() / spectrum::largest_singular_value_squared(b));
        let given = request(n, m, cubic(), custom(&scaled.collect::<Vec<_>>()));
        assert_alike(given, request(n, m, cubic(), Method::Transpose), 1e-13);
    }
}

/// A selection has eigenvalues 0: its spectral radius is one, and it does not diverge.
#[test]
fn a_selection_is_local() {
    for ((n, m), omega) in GRIDS.into_iter().flat_map(|it| [(it, 1.0), (it, 1.3)]) {
        let adjusted = |i: usize| i % 3 == 1 || i == 2;
        let factor = if m > 1 { f64::sqrt(omega) } else { omega };
        let select = |n| {
            let chosen = |i, j| i == j && adjusted(i);
            DMatrix::from_fn(n, n, |i, j| if chosen(i, j) { factor } else { 0.0 })
        };
        let matrices = if m > 1 {
            vec![select(n), select(m)]
        } else {
            vec![select(n)]
        };
        let mut local = request(
            n,
            m,
            cubic(),
            Method::Local(Local {
                omega: Omega::Given(omega),
                ..Local::default()
            }),
        );
        let selected = (0..n * m).filter(|k| adjusted(k / m) && (m == 1 || adjusted(k % m)));
        local.selected = Some(selected.collect());
        assert_alike(request(n, m, cubic(), custom(&matrices)), local, 1e-13);
    }
}

/// Level after level the error is that of `(I − U B)ᵏ`, also with a matrix that is not symmetric.
#[test]
fn errors_follow_the_powers_of_the_iteration_matrix() {
    let b = collocation(12, 1).remove(0);
    let u = DMatrix::from_fn(12, 12, |i, j| match i as i32 - j as i32 {
        0 => 1.1,
        1 => -0.2,
        -2 => 0.05,
        _ => 0.0,
    });
    let mut iteration = start(request(12, 1, cubic(), custom(std::slice::from_ref(&u))));
    let residual =
        |it: &Iteration| DMatrix::from_column_slice(12, 1, it.residual().unwrap().lane(2));
    let mut expected = residual(&iteration);
    let step = DMatrix::<f64>::identity(12, 12) - &b * &u;
    for _ in 0..10 {
        assert!((residual(&iteration) - &expected).amax() < 1e-13);
        iteration.step();
        expected = &step * expected;
    }
}

/// On square grids; on others the second direction is named.
#[test]
fn one_matrix_serves_both_directions() {
    let matrix = rows(&(DMatrix::<f64>::identity(8, 8) * 1.1));
    let one = Method::Custom(Custom::new(matrix.clone(), None));
    let two = Method::Custom(Custom::new(matrix.clone(), Some(matrix)));
    assert_alike(
        request(8, 8, cubic(), one.clone()),
        request(8, 8, cubic(), two),
        0.0,
    );
    let error = Problem::new(request(8, 7, cubic(), one)).unwrap_err();
    assert_eq!(error.place, Place::Transform(Axis::V));
}

/// Every validation error names its location.
#[test]
fn wrong_matrices_are_refused() {
    let identity = rows(&DMatrix::identity(30, 30));
    let refuse = |change: &dyn Fn(&mut Vec<Vec<f64>>)| {
        let mut matrix = identity.clone();
        change(&mut matrix);
        let method = Method::Custom(Custom::new(matrix, None));
        Problem::new(request(30, 1, cubic(), method))
            .unwrap_err()
            .place
    };
    let u = Axis::U;
    assert_eq!(refuse(&|rows| rows.truncate(29)), Place::Transform(u));
    assert_eq!(refuse(&|rows| rows[4].push(0.0)), Place::TransformRow(u, 4));
    for bad in [f64::NAN, f64::INFINITY] {
        let place = refuse(&|rows| rows[7][3] = bad);
        assert_eq!(place, Place::TransformEntry(u, 7, 3));
    }
    let second = Method::Custom(Custom::new(identity.clone(), Some(identity.clone())));
    let error = Problem::new(request(30, 1, cubic(), second)).unwrap_err();
    assert_eq!(error.place, Place::Transform(Axis::V));
    let large = Method::Custom(Custom::new(vec![Vec::new(); LARGEST + 1], None));
    let error = Problem::new(request(LARGEST + 1, 1, cubic(), large)).unwrap_err();
    assert!(error.to_string().contains("501 rows"), "{error}");
}

/// The rate that a curve, or a surface, is refused with, to the three decimals of the message.
fn refused(matrices: &[DMatrix<f64>]) -> Option<f64> {
    let columns = matrices.get(1).map_or(1, |v| v.nrows());
    match Problem::new(request(
        matrices[0].nrows(),
        columns,
        cubic(),
        custom(matrices),
    )) {
        Ok(_) => None,
        Err(error) => {
            let detail = error.to_string();
            let (_, rest) = detail.split_once("spectral radius of I − U B is ").unwrap();
            Some(rest.split(',').next().unwrap().parse().unwrap())
        }
    }
}

/// Cubics have 1 among their eigenvalues: `|1 − ω|` is the rate of the part that overshoots.
#[test]
fn diverging_transforms_are_refused() {
    for grid in GRIDS {
        assert_eq!(refused(&scaled(grid, [1.99, 1.0])), None);
        for omega in [2.0, 2.1, 3.5] {
            let rate = refused(&scaled(grid, [omega, 1.0])).unwrap();
            assert!((rate - (omega - 1.0)).abs() < 1e-3, "{omega}: {rate}");
        }
        assert!(refused(&scaled(grid, [-0.01, 1.0])).unwrap() > 1.0);
        assert!(grid.1 == 1 || refused(&scaled(grid, [1.5, 1.4])).is_some());
    }
}

/// `I − U B` is a rotation times a number: eigenvalues are complex, and the number is the rate.
#[test]
fn rotations_are_distinguished_from_spirals() {
    let n = 30;
    let inverse = collocation(n, 1).remove(0).try_inverse().unwrap();
    let turn = Complex::from_polar(1.0, 1.0);
    let rotation = DMatrix::from_fn(n, n, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
        (false, ..) => 0.0,
        (true, 0, 1) => -turn.im,
        (true, 1, 0) => turn.im,
        (true, ..) => turn.re,
    });
    let with = |rate: f64| {
        let identity = DMatrix::<f64>::identity(n, n);
        refused(&[(identity - &rotation * rate) * &inverse])
    };
    assert_eq!((with(0.5), with(0.999_999)), (None, None));
    assert!((with(1.001).unwrap() - 1.001).abs() < 1e-3);
    assert!((with(2.0).unwrap() - 2.0).abs() < 1e-3);
}

/// The transform of extended PIA: all eigenvalues of `U B` are one in a single Jordan block, and as
/// computed they are anywhere.
#[test]
fn nilpotent_iterations_are_accepted() {
    for n in [10, 60, 150] {
        let bases = [cubic(), BasisChoice::Polynomial(Polynomial::Bernstein)];
        for basis in bases.into_iter().take(if n < 60 { 2 } else { 1 }) {
            let problem = Problem::new(request(n, 1, basis.clone(), Method::Global)).unwrap();
            let mut lines = DMatrix::<f64>::identity(n, n);
            let transform = problem.tensor().u.orthogonal();
            transform.apply(lines.as_mut_slice());
            let problem = Problem::new(request(n, 1, basis, custom(&[lines])));
            assert!(problem.is_ok(), "{n}: {:?}", problem.err());
        }
    }
}
