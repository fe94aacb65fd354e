//! PIA with any transform, given as a matrix.
//!
//! ```text
//! X⁰ = P,   X ← X + U (P − B X),   U given
//! ```
//!
//! (Deng13, Theorem 2.1). It converges to the interpolating curve for every P exactly if
//! `ρ(I − U B) < 1`, by that factor in each level in the long run. Other methods are special cases:
//! U = I is classical PIA, ω I weighted PIA, a diagonal of ones and zeros local PIA, B⁻¹ the direct
//! solution, Bᵀ/ρ(B Bᵀ) the transpose. On surfaces `U = U_u ⊗ U_v`, with one matrix for both
//! directions or one for each.
//!
//! Fits of up to 100 points in a direction that certainly diverge are refused ([`stability`] says how that is decided).
//! A singular U, such as a selection, has `ρ = 1` and is accepted: the fit converges, though not to the data.
//!
//! U is n × n of n control points in a direction, at most [`LARGEST`]. A level of a curve costs n²
//! multiplications for each coordinate, one of an n × m surface `n m (n + m)`.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::algorithm::{Algorithm, Demand, Scope};
use super::equations::Equations;
use super::linear::Linear;
use super::update::Update;
use crate::invalid::{Axis, Invalid, Place};
use crate::kind_info::KindInfo;
use crate::linear::DenseMap;
use crate::matrix::forecast::Forecast;
use crate::matrix::stability;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "custom",
    title: "PIA with a given transform",
    summary: "Difference vectors are multiplied with any given matrix U, with which ρ(I − U B) < 1.",
    source: "Deng13, Theorem 2.1",
};

/// The most rows and columns of a matrix.
pub const LARGEST: usize = 500;

/// Up to this number of rows all eigenvalues are computed, to refuse what diverges and to forecast the rate: this takes
/// some milliseconds for 100 rows, and a second for 500.
const SMALL: usize = 100;

/// The multiplications of finding all eigenvalues of an n × n matrix are about this number times
/// n³.
const EIGENVALUES: usize = 25;

/// PIA with given matrices. Clones share them.
///
/// ```
/// use piad_fit::method::{Custom, Method};
///
/// // 1.5 I for a curve of three points, or a surface of 3 × 3.
/// let rows = |n: usize| -> Vec<Vec<f64>> {
///     let row = |i| (0..n).map(|j| if i == j { 1.5 } else { 0.0 }).collect();
///     (0..n).map(row).collect()
/// };
/// let weighted = Method::Custom(Custom::new(rows(3), None));
/// assert_eq!(weighted.name(), "custom");
///
/// // One for each direction of a surface of 3 × 4.
/// let surface = Custom::new(rows(3), Some(rows(4)));
/// assert_eq!((surface.u().len(), surface.v().map(<[_]>::len)), (3, Some(4)));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Custom {
    u: Arc<Vec<Vec<f64>>>,
    v: Option<Arc<Vec<Vec<f64>>>>,
}

impl Custom {
    /// The method with the rows of U, or of U_u and U_v; on surfaces `u` is for both directions if there is no `v`. The
    /// matrices are checked together with a problem.
    pub fn new(u: Vec<Vec<f64>>, v: Option<Vec<Vec<f64>>>) -> Self {
        Self {
            u: Arc::new(u),
            v: v.map(Arc::new),
        }
    }

    /// The rows of the matrix of a curve, of direction u, or of both directions.
    pub fn u(&self) -> &[Vec<f64>] {
        &self.u
    }

    /// The rows of the matrix of direction v, if it has one of its own.
    pub fn v(&self) -> Option<&[Vec<f64>]> {
        self.v.as_ref().map(|rows| &rows[..])
    }

    /// The rows for the second direction of a surface.
    fn across(&self) -> &[Vec<f64>] {
        self.v().unwrap_or(&self.u)
    }

    /// `U B` of each direction.
    fn products(&self, setup: &Setup, collocation: &Tensor) -> Vec<DMatrix<f64>> {
        let u = matrix(&self.u) * collocation.u.to_dense();
        let v = collocation.v.as_ref().filter(|_| setup.v().is_some());
        let v = v.map(|v| matrix(self.across()) * v.to_dense());
        std::iter::once(u).chain(v).collect()
    }
}

/// Returns true if all eigenvalues are computed.
fn is_small(setup: &Setup) -> bool {
    let grid = setup.grid();
    grid.rows.max(grid.columns) <= SMALL
}

impl Algorithm for Custom {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// The size and the entries of each matrix.
    fn check(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        check_matrix(&self.u, scope.grid.rows, Axis::U)?;
        if scope.is_surface {
            check_matrix(self.across(), scope.grid.columns, Axis::V)
        } else if self.v.is_some() {
            Err(Invalid::at(
                Place::Transform(Axis::V),
                "a curve has one direction, and its transform one matrix",
            ))
        } else {
            Ok(())
        }
    }

    /// By all eigenvalues of `U B`, in each direction, where they are few. Larger fits that diverge fail
    /// when they leave the range of numbers.
    fn check_convergence(&self, setup: &Setup) -> Result<(), Invalid> {
        if !is_small(setup) {
            return Ok(());
        }
        let products = self.products(setup, &setup.tensor());
        match stability::diverging_rate(&products) {
            Some(rate) => Err(Invalid::at(
                Place::Method,
                format!(
                    "the transform U diverges: with this basis and these parameters the spectral radius of I − U B is {rate:.3}, and it must be below 1"
                ),
            )),
            None => Ok(()),
        }
    }

    /// Besides the matrices, their products with the collocation matrices while they are checked.
    fn demand(&self) -> Demand {
        let entries = self.u.len().pow(2) + self.across().len().pow(2);
        Demand {
            vectors: 2,
            matrices: 4,
            bytes: 3 * entries * size_of::<f64>(),
        }
    }

    /// n² for each coordinate of a curve of n points, `n m (n + m)` of a surface.
    fn step_cost(&self, setup: &Setup) -> usize {
        let grid = setup.grid();
        let across = setup.v().map_or(0, |_| grid.columns);
        setup.data().dimension() * grid.count() * (grid.rows + across)
    }

    /// All eigenvalues of `U B`, in each direction, where they are computed.
    fn start_cost(&self, setup: &Setup) -> usize {
        let grid = setup.grid();
        let across = setup.v().map_or(0, |_| grid.columns);
        match is_small(setup) {
            true => EIGENVALUES * (grid.rows.pow(3) + across.pow(3)),
            false => 0,
        }
    }

    /// The rate of small ones; for others the decay of errors predicts the end.
    fn forecast(&self, setup: &Setup, collocation: &Tensor) -> Forecast {
        let rate = || stability::rate(&self.products(setup, collocation));
        Forecast {
            rate: is_small(setup).then(rate).flatten(),
            ..Forecast::default()
        }
    }

    /// Dense maps; one matrix for both directions is used twice.
    fn transform(&self, collocation: &Tensor, _forecast: &Forecast) -> Transform {
        let map = |rows| DenseMap::new(matrix(rows));
        let v = collocation.v.as_ref().map(|_| map(self.across()));
        Transform::Dense(map(&self.u), v)
    }

    fn update(&self, _equations: &Equations) -> Box<dyn Update> {
        Box::new(Linear::endless())
    }

    /// Where eigenvectors are nearly parallel, errors rise before they fall.
    fn rate_is_sharp(&self) -> bool {
        false
    }
}

/// The matrix of these rows.
fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let n = rows.len();
    DMatrix::from_row_iterator(n, n, rows.iter().flatten().copied())
}

/// Refuses matrices that are too large, not square, not of the size of a direction with `expected`
/// control points, or not finite.
fn check_matrix(rows: &[Vec<f64>], expected: usize, axis: Axis) -> Result<(), Invalid> {
    let given = rows.len();
    if given > LARGEST {
        let limit = LARGEST;
        return Err(Invalid::at(
            Place::Transform(axis),
            format!("the transform has {given} rows; it is limited to {limit}"),
        ));
    }
    if given != expected {
        return Err(Invalid::at(
            Place::Transform(axis),
            format!(
                "the transform has {given} rows, but there are {expected} control points: it needs a row and a column for each"
            ),
        ));
    }
    for (row, entries) in rows.iter().enumerate() {
        let given = entries.len();
        if given != expected {
            return Err(Invalid::at(
                Place::TransformRow(axis, row),
                format!(
                    "row {row} of the transform has {given} entries; it needs {expected}, one for each data point"
                ),
            ));
        }
        if let Some(column) = entries.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::at(
                Place::TransformEntry(axis, row, column),
                format!(
                    "entry {column} of row {row} is {value}, which is not a finite number",
                    value = entries[column]
                ),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
