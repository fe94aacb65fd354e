//! The collocation matrix of a surface.
//!
//! It is the tensor product `B_u ⊗ B_v`, applied one direction after the other and never formed:
//! with the points as a row-major grid X of rows × columns
//!
//! ```text
//! (B_u ⊗ B_v) X = B_u X B_vᵀ,      (B_u ⊗ B_v)ᵀ X = B_uᵀ X B_v,      (B_u ⊗ B_v)⁻¹ X = B_u⁻¹ X B_v⁻ᵀ
//! ```
//!
//! On n × m points with degrees p and q that takes `n m (p + q + 2)` multiplications rather than
//! `n m (p + 1)(q + 1)`. Eigenvalues and singular values are the products of those of both
//! directions.

use nalgebra::DMatrix;

use super::collocation::Collocation;
use crate::basis::direction::Direction;
use crate::data::grid::Grid;

/// The collocation matrix of a problem: of a curve, or the tensor product of a surface.
#[derive(Clone, Debug)]
pub struct Tensor {
    /// The arrangement of the data points: the rows of the matrix.
    data: Grid,
    /// The arrangement of the free control points: its columns.
    control: Grid,
    /// The matrix of a curve, or of the u direction.
    pub u: Collocation,
    /// The matrix of the v direction of a surface.
    pub v: Option<Collocation>,
}

impl Tensor {
    /// The collocation matrices of both directions of a grid of data points.
    pub(crate) fn new(data: Grid, u: &Direction, v: Option<&Direction>) -> Self {
        Self {
            data,
            control: Grid {
                rows: u.free(),
                columns: v.map_or(1, Direction::free),
            },
            u: Collocation::new(u),
            v: v.map(Collocation::new),
        }
    }

    /// The entries of the column of control point `index` that differ from zero, rows (increasing)
    /// and values: the data points in the support of its basis function.
    pub(crate) fn column(&self, index: usize) -> Vec<(usize, f64)> {
        let Some(v) = &self.v else {
            return self.u.column(index);
        };
        let columns = self.control.columns;
        let along = self.u.column(index / columns);
        let across = v.column(index % columns);
        let products = along.into_iter().flat_map(|(i, a)| {
            let line = i * self.data.columns;
            across.iter().map(move |&(j, b)| (line + j, a * b))
        });
        products.collect()
    }

    /// The most entries of a row of each direction: multiplications for a point.
    pub(crate) fn widths(&self) -> impl Iterator<Item = usize> {
        self.directions().map(|it| it.entries() / it.rows().max(1))
    }

    /// The arrangement of the data points.
    pub(crate) fn data_grid(&self) -> Grid {
        self.data
    }

    /// One direction or both.
    pub fn directions(&self) -> impl Iterator<Item = &Collocation> + Clone {
        std::iter::once(&self.u).chain(&self.v)
    }

    /// The block `B_II` of the rows and columns of some points I, of a square matrix. `points` are
    /// their indices, and `place` says for each index of the grid where in `points` it stands.
    pub(crate) fn principal_block(
        &self,
        points: &[usize],
        place: &[Option<usize>],
    ) -> DMatrix<f64> {
        let mut block = DMatrix::zeros(points.len(), points.len());
        for (k, &index) in points.iter().enumerate() {
            for (row, value) in self.column(index) {
                if let Some(row) = place[row] {
                    block[(row, k)] += value;
                }
            }
        }
        block
    }

    /// The scratch space, in numbers, that the maps of this matrix need: none of a curve, of a
    /// surface those of the largest grid between both directions.
    pub fn scratch(&self) -> usize {
        self.v.as_ref().map_or(0, |_| {
            let between = |grid: Grid, other: Grid| grid.rows * other.columns;
            let either = between(self.control, self.data).max(between(self.data, self.control));
            // Surfaces that choose their knots can begin with more control points than data.
            either.max(self.data.count()).max(self.control.count())
        })
    }

    /// `y = (B_u ⊗ B_v) x` for one coordinate x of all free control points: y is that of the curve
    /// or surface at the parameters of all data points.
    pub fn apply(&self, x: &[f64], y: &mut [f64], scratch: &mut [f64]) {
        match &self.v {
            None => self.u.apply_to_lines(x, y),
            Some(v) => {
                let scratch = &mut scratch[..self.data.rows * self.control.columns];
                self.u.apply_across_lines(x, scratch);
                v.apply_to_lines(scratch, y);
            }
        }
    }

    /// `y = (B_u ⊗ B_v)ᵀ x` for one coordinate x of all data points; y has a number for each free
    /// control point.
    pub fn apply_transposed(&self, x: &[f64], y: &mut [f64], scratch: &mut [f64]) {
        match &self.v {
            None => self.u.apply_transposed_to_lines(x, y),
            Some(v) => {
                let scratch = &mut scratch[..self.control.rows * self.data.columns];
                self.u.apply_transposed_across_lines(x, scratch);
                v.apply_transposed_to_lines(scratch, y);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::apply_tensor;
    use crate::matrix::collocation::tests::{all_directions, matrix};

    /// Every pair of bases, against matrices that are formed.
    #[test]
    fn tensor_products_equal_kronecker_products() {
        let (rows, columns) = (6, 9);
        let grid = Grid { rows, columns };
        for u in all_directions(rows) {
            for v in all_directions(columns) {
                let kronecker = matrix(&u).kronecker(&matrix(&v));
                let tensor = Tensor {
                    data: grid,
                    control: grid,
                    u: Collocation::new(&u),
                    v: Some(Collocation::new(&v)),
                };
                let x: Vec<f64> = (0..rows * columns)
                    .map(|i| (i as f64 * 0.7).sin())
                    .collect();
                let mut scratch = vec![0.0; tensor.scratch()];
                let mut y = vec![0.0; x.len()];
                let vector = nalgebra::DVector::from_column_slice(&x);
                let assert_equal = |y: &[f64], expected: nalgebra::DVector<f64>, tolerance| {
                    for (y, expected) in y.iter().zip(expected.iter()) {
                        assert!((y - expected).abs() < tolerance);
                    }
                };
                tensor.apply(&x, &mut y, &mut scratch);
                assert_equal(&y, &kronecker * &vector, 1e-14);
                let mut back = y.clone();
                let (inverse_u, inverse_v) = (tensor.u.inverse(), Collocation::new(&v).inverse());
                apply_tensor(
                    &inverse_u,
                    Some(&inverse_v),
                    grid,
                    &mut [&mut back],
                    &mut scratch,
                );
                assert_equal(&back, vector.clone(), 1e-8);
                for (j, column) in kronecker.column_iter().enumerate() {
                    let mut entries = vec![0.0; x.len()];
                    let found = tensor.column(j);
                    assert!(found.is_sorted_by_key(|(i, _)| *i));
                    found.iter().for_each(|(i, value)| entries[*i] += value);
                    assert_equal(&entries, column.clone_owned(), 1e-15);
                }
                tensor.apply_transposed(&x, &mut y, &mut scratch);
                assert_equal(&y, kronecker.transpose() * &vector, 1e-14);
            }
        }
    }
}
