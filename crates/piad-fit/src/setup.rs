//! What is fitted, independent of the method: data, parameters, bases, and when to stop.

use std::sync::Arc;

use super::ends::offsets::Offsets;
use crate::basis::direction::Direction;
use crate::data::bounds::Extent;
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::points::{self, Points};
use crate::matrix::operator::Operator;
use crate::matrix::sparse::Sparse;
use crate::matrix::tensor::Tensor;
use crate::parameters::Domain;

/// The number of eliminations counted for the preparation of a fit: λ_min takes some, and the method one more.
const ELIMINATIONS: usize = 8;

/// A validated fitting problem but for its method, which is a [`Method`](super::method::Method).
///
/// With n rows and m columns of data points (m = 1 of a curve) and as many free control points
/// (fewer of a least-squares fit), `B X = P` has n · m rows, one for each data point, and a column
/// for each free control point.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The data points, where missing ones have the place of a neighbour.
    pub(super) points: Arc<Points>,
    /// The arrangement of the data points, rows × columns.
    pub(super) grid: Grid,
    /// The data in homogeneous coordinates.
    pub(super) lifted: Option<Arc<Points>>,
    /// The constants of control points at the ends, if there are some.
    pub(super) offsets: Option<Arc<Offsets>>,
    /// The data without the share of these constants.
    pub(super) target: Arc<Points>,
    /// The extent of each coordinate of the data, lifted if they are.
    pub(super) extents: Vec<Extent>,
    /// Which points are missing or left out, for least-squares fits.
    pub(super) missing: Option<Missing>,
    /// The extents of both directions if the points of the surface are scattered.
    pub(super) scattered: Option<[Domain; 2]>,
    /// The numbers of points of the sections, if the surface has sections.
    pub(super) sections: Option<Arc<Vec<usize>>>,
    /// True if the edges between the points of the curve are data, too.
    pub(super) polyline: bool,
    /// The direction of a curve, or u of a surface.
    pub(super) u: Direction,
    /// The second direction of a surface.
    pub(super) v: Option<Direction>,
    /// Local fits: the control points that may move; `None` means all.
    pub(super) selected: Option<Arc<[usize]>>,
    /// The given free control points of level 0.
    pub(super) start: Option<Arc<Points>>,
    /// λ_min of the collocation matrix, if it is known from another fit.
    pub(super) lambda_min: Option<f64>,
    /// The tolerance, in data units.
    pub(super) tolerance: f64,
    /// The last level that is computed.
    pub(super) max_iterations: usize,
    /// The diagonal of the bounding box of the data, in data units.
    pub(super) diagonal: f64,
    /// True if eigenvalues of the collocation matrix may nearly coincide.
    pub(super) clustered: bool,
}

impl Setup {
    /// The collocation matrix.
    pub(super) fn collocation(&self) -> Operator {
        match &self.v {
            Some(v) if self.is_scattered() => Operator::Sparse(Arc::new(Sparse::new(&self.u, v))),
            _ => Operator::Tensor(Arc::new(self.tensor())),
        }
    }

    /// The collocation matrices of the directions of a curve or a grid.
    pub fn tensor(&self) -> Tensor {
        Tensor::new(self.grid, &self.u, self.v.as_ref())
    }

    /// The points that the curve approaches; of a surface row by row. In homogeneous fits they
    /// are `(w_i P_i, w_i)`, with one coordinate more than the data.
    pub fn data(&self) -> &Arc<Points> {
        self.lifted.as_ref().unwrap_or(&self.points)
    }

    /// What `B X` approaches: the data without the share of the constants g of control points
    /// `c = E x + g`, `P − N g`.
    pub(super) fn target(&self) -> &Arc<Points> {
        &self.target
    }

    /// The constants of control points at the ends, if there are some.
    pub(super) fn offsets(&self) -> Option<&Offsets> {
        self.offsets.as_deref()
    }

    /// The extent of each coordinate of [`data`](Self::data).
    pub(super) fn extents(&self) -> &[Extent] {
        &self.extents
    }

    /// Returns true if the last coordinate of data and control points is a weight.
    pub fn is_homogeneous(&self) -> bool {
        self.lifted.is_some()
    }

    /// The missing points.
    pub fn missing(&self) -> Option<&Missing> {
        self.missing.as_ref()
    }

    /// Returns true if the points of the surface are scattered: then the grid has one column, and directions have a
    /// parameter for each point, in any order.
    pub fn is_scattered(&self) -> bool {
        self.scattered.is_some()
    }

    /// The most control points of a surface through sections: twice the number of points of the longest section, in
    /// each direction.
    pub(super) fn most_of_sections(&self) -> Option<usize> {
        let counts = self.sections.as_ref()?;
        let most = counts.iter().max().copied().unwrap_or_default();
        Some(counts.len().saturating_mul(2 * most))
    }

    /// The ends of v that are poles, where all control points coincide.
    pub(crate) fn poles(&self) -> [bool; 2] {
        self.scattered.map_or([false; 2], |[_, v]| v.poles())
    }

    /// The number of coordinates of the data points.
    pub fn dimension(&self) -> usize {
        self.points.dimension()
    }

    /// The arrangement of the data points.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The arrangement of the free control points.
    pub fn control_grid(&self) -> Grid {
        Grid {
            rows: self.u.free(),
            columns: self.v.as_ref().map_or(1, Direction::free),
        }
    }

    /// The direction of a curve, or u of a surface.
    pub fn u(&self) -> &Direction {
        &self.u
    }

    /// The second direction of a surface.
    pub fn v(&self) -> Option<&Direction> {
        self.v.as_ref()
    }

    /// The data of a curve without outliers, or all rows of a grid.
    pub(super) fn rows(&self) -> Vec<usize> {
        let missing = self.missing().filter(|_| self.v.is_none());
        let is_there = |row: &usize| missing.is_none_or(|missing| !missing.contains(*row));
        (0..self.grid.rows).filter(is_there).collect()
    }

    /// The first and the last data point of a curve that are not missing.
    pub(super) fn ends(&self) -> [usize; 2] {
        let last = self.grid.count() - 1;
        let is_there = |index: &usize| self.missing().is_none_or(|it| !it.contains(*index));
        let first = (0..=last).find(is_there).unwrap_or(0);
        [first, (0..=last).rfind(is_there).unwrap_or(last)]
    }

    /// The parameters (u, v) of a data point; v of a curve is zero.
    pub(super) fn parameters_of(&self, index: usize) -> [f64; 2] {
        let Some(v) = &self.v else {
            return [self.u.parameters[index], 0.0];
        };
        let (row, column) = match self.is_scattered() {
            true => (index, index),
            false => (index / self.grid.columns, index % self.grid.columns),
        };
        [self.u.parameters[row], v.parameters[column]]
    }

    /// One direction or both.
    pub fn directions(&self) -> impl Iterator<Item = &Direction> + Clone {
        std::iter::once(&self.u).chain(&self.v)
    }

    /// Local fits: the indices of the control points that move; `None` means all.
    pub fn selected(&self) -> Option<&[usize]> {
        self.selected.as_deref()
    }

    /// The given free control points of level 0.
    pub fn start(&self) -> Option<&Arc<Points>> {
        self.start.as_ref()
    }

    /// The least eigenvalue of the collocation matrix, if it was known beforehand.
    pub(super) fn lambda_min(&self) -> Option<f64> {
        self.lambda_min
    }

    /// The largest allowed distance of the curve from a data point, in data units.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The last level that is computed.
    pub fn max_iterations(&self) -> usize {
        self.max_iterations
    }

    /// The diagonal of the data's bounding box, in data units.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// The length of rounding errors of the data.
    pub(super) fn rounding(&self) -> f64 {
        let dimension = self.extents.len() as f64;
        points::magnitude(&self.extents) * points::ROUNDING * dimension.sqrt()
    }

    /// Returns true if eigenvalues of the collocation matrix may nearly coincide, so that its eigenvectors are nearly
    /// parallel: those of polynomial bases, and of open B-splines of even degree unless their knots are averaged.
    pub(super) fn is_clustered(&self) -> bool {
        self.clustered
    }

    /// Multiplications of the residual `P − B X`, of all coordinates.
    pub(super) fn residual_cost(&self) -> usize {
        let widths = self
            .directions()
            .map(|direction| direction.basis.support_width());
        let width = match self.is_scattered() {
            true => widths.product::<usize>(),
            false => widths.sum(),
        };
        self.data().dimension() * self.grid().count() * width
    }

    /// The approximate number of multiplications before the first iteration: evaluating the basis, and the eliminations
    /// that the spectrum and the method need.
    pub(super) fn preparation_cost(&self) -> usize {
        let each = self.directions().map(|direction| {
            let width = direction.basis.support_width();
            let elimination = direction.parameters.len().saturating_mul(width * width);
            elimination.saturating_mul(ELIMINATIONS)
        });
        each.fold(0, usize::saturating_add)
    }
}
