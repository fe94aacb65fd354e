//! Grids of data points with holes, for least-squares fits.
//!
//! Scanned surfaces have points without a measurement. They stay in the grid, as rows and columns
//! have parameters in common, but their residuals are zero, so that they have no effect in `X ← X +
//! D Aᵀ Δ`. Parameters by distance leave out steps from and to them. Control points in whose
//! support all data are missing stay where they start.

use std::collections::VecDeque;

use super::grid::Grid;
use super::points::Points;

/// Which points of a grid are missing: one flag for each, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing(Vec<bool>);

impl Missing {
    /// Marks the points with these indices as missing; `None` if there are none.
    pub fn new(indices: &[usize], count: usize) -> Option<Self> {
        let mut missing = vec![false; count];
        for &index in indices {
            missing[index] = true;
        }
        (!indices.is_empty()).then_some(Self(missing))
    }

    /// Returns true if point `index` is missing.
    pub fn contains(&self, index: usize) -> bool {
        self.0[index]
    }

    /// True for each point that is there.
    pub fn present(&self) -> Vec<bool> {
        self.0.iter().map(|missing| !missing).collect()
    }

    /// Sets the values of missing points to zero: they have no residual.
    pub fn clear(&self, values: &mut [f64]) {
        for (value, &missing) in values.iter_mut().zip(&self.0) {
            if missing {
                *value = 0.0;
            }
        }
    }

    /// Gives missing points the place of the nearest one that is there, counted in steps of the
    /// grid (a breadth-first search), so that control points that start there start near the data.
    /// O(n) for n points.
    pub fn fill(&self, points: &mut Points, grid: Grid) {
        let mut known = self.present();
        let mut front: VecDeque<usize> = (0..known.len()).filter(|&index| known[index]).collect();
        while let Some(index) = front.pop_front() {
            let (i, j) = (index / grid.columns, index % grid.columns);
            let neighbours = [
                (i > 0).then(|| index - grid.columns),
                (i + 1 < grid.rows).then(|| index + grid.columns),
                (j > 0).then(|| index - 1),
                (j + 1 < grid.columns).then(|| index + 1),
            ];
            for next in neighbours.into_iter().flatten() {
                if !known[next] {
                    known[next] = true;
                    for lane in points.lanes_mut() {
                        lane[next] = lane[index];
                    }
                    front.push_back(next);
                }
            }
        }
    }
}
