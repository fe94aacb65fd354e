//! The collocation matrix of any problem: of points in a grid, or of scattered ones.
//!
//! | data | matrix | multiplications of `B x` |
//! |---|---|---|
//! | a curve, a grid | [`Tensor`]: a tensor product | n m (p + q + 2) |
//! | scattered points | [`Sparse`]: (p + 1)(q + 1) entries a row | n (p + 1)(q + 2) |
//!
//! The loop and the updates need no more than `B x` and `Bᵀ x`.

use std::sync::Arc;

use super::collocation::Collocation;
use super::sparse::Sparse;
use super::tensor::Tensor;
use crate::data::grid::Grid;
use crate::data::points::Points;

/// The collocation matrix B, which is shared by problems that have the same one.
#[derive(Clone, Debug)]
pub enum Operator {
    /// Of a curve or a grid of points.
    Tensor(Arc<Tensor>),
    /// Of scattered points.
    Sparse(Arc<Sparse>),
}

impl Operator {
    /// The matrices of both directions, if it is their tensor product.
    pub fn tensor(&self) -> Option<&Tensor> {
        match self {
            Self::Tensor(tensor) => Some(tensor),
            Self::Sparse(_) => None,
        }
    }

    /// The arrangement of the data points.
    pub(crate) fn data_grid(&self) -> Grid {
        match self {
            Self::Tensor(tensor) => tensor.data_grid(),
            Self::Sparse(sparse) => Grid {
                rows: sparse.rows(),
                columns: 1,
            },
        }
    }

    /// The scratch space, in numbers, that the maps of this matrix need.
    pub fn scratch(&self) -> usize {
        match self {
            Self::Tensor(tensor) => tensor.scratch(),
            Self::Sparse(sparse) => sparse.control_grid().count(),
        }
    }

    /// `y = B x` for one coordinate x of all free control points: y is that of the curve or surface
    /// at the parameters of all data points.
    pub fn apply(&self, x: &[f64], y: &mut [f64], scratch: &mut [f64]) {
        match self {
            Self::Tensor(tensor) => tensor.apply(x, y, scratch),
            Self::Sparse(sparse) => sparse.apply(x, y),
        }
    }

    /// The same for all coordinates.
    pub(crate) fn apply_to_all(&self, x: &Points, y: &mut Points, scratch: &mut [f64]) {
        let of_curve = self.tensor().filter(|tensor| tensor.v.is_none());
        if let Some(Collocation::Dense(dense)) = of_curve.map(|tensor| &tensor.u) {
            let x: Vec<&[f64]> = x.lanes().iter().map(|lane| &lane[..]).collect();
            dense.apply(&x, y.lanes_mut().iter_mut().map(|lane| &mut lane[..]));
            return;
        }
        for (x, y) in x.lanes().iter().zip(y.lanes_mut()) {
            self.apply(x, y, scratch);
        }
    }

    /// `y = Bᵀ x` for one coordinate x of all data points; y has a number for each free control
    /// point.
    pub fn apply_transposed(&self, x: &[f64], y: &mut [f64], scratch: &mut [f64]) {
        match self {
            Self::Tensor(tensor) => tensor.apply_transposed(x, y, scratch),
            Self::Sparse(sparse) => sparse.apply_transposed(x, y),
        }
    }
}
