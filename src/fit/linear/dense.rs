//! Dense matrices: as linear maps, and their LU decomposition with partial pivoting, `P B = L U`.
//!
//! The decomposition takes `2/3 n³` operations, solving for a line `2 n²`. Polynomial bases have
//! such matrices, of degrees for which that is little.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, Dyn};

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
