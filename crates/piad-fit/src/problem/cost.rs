//! The cost of a fit: control points, memory and multiplications.

use super::{Problem, adaptive_knots, first};
use crate::ends::offsets::Offsets;
use crate::matrix::collocation::Collocation;
use crate::matrix::sparse::Sparse;
use crate::parameters::Scattered;

/// The bytes for each point that it takes to find an outline: its parameters and its place, and at most 16 cells.
const BYTES_OF_OUTLINE: usize = 192;

impl Problem {
    /// The most free control points that a level can have.
    pub fn most_control_points(&self) -> usize {
        let Some((settings, _)) = self.method().automatic() else {
            return self.control_grid().count();
        };
        if let Some((alone, _)) = self.alone() {
            return alone.most_control_points();
        }
        if let Some(most) = self.most_control_points_of_pieces() {
            return settings.u.min(most);
        }
        let grid = self.grid();
        let columns = self.v().map_or(1, |_| settings.v.min(grid.columns));
        let rows = match self.v() {
            None => self.most_beside_data(grid.rows),
            Some(_) => grid.rows,
        };
        let most = settings.u.min(rows).saturating_mul(columns);
        most.max(self.most_of_sections().unwrap_or_default())
            .max(self.control_grid().count())
    }

    /// The number of bytes to iterate this problem once, the data included: vectors of n points, collocation matrices
    /// and their factorizations. It is an upper bound by what the method demands, for admission.
    pub fn memory(&self) -> usize {
        let points = self.grid().count();
        let demand = self.method().algorithm().demand();
        // Data, control points, residual and what the method needs besides; scratch on surfaces.
        let given = usize::from(self.is_homogeneous()) + usize::from(self.start().is_some());
        let shifted = usize::from(self.offsets().is_some());
        let vectors = 3 + given + shifted + demand.vectors;
        let scratch = usize::from(self.v().is_some());
        let arrays = (vectors * self.data().dimension() + scratch) * points * size_of::<f64>();
        let outline = self.request.trim.map_or(0, |_| BYTES_OF_OUTLINE * points);
        let arrays = arrays + outline;
        let arrays = arrays + self.request.scattered.as_ref().map_or(0, Scattered::bytes);
        if let Some((alone, _)) = self.alone() {
            return arrays + alone.memory();
        }
        if let Some((settings, _)) = self.method().automatic() {
            let most = self.most_control_points();
            return arrays + first::memory(self, settings, most) + demand.bytes;
        }
        if let (true, Some(v)) = (self.is_scattered(), self.v()) {
            let matrix = Sparse::memory(self.u(), v);
            return arrays + matrix + demand.bytes;
        }
        let directions = self.directions().map(|direction| {
            2 * direction.parameters.len() * size_of::<f64>()
                + demand.matrices * Collocation::memory(direction)
        });
        let offsets = self.offsets().map_or(0, Offsets::numbers) * size_of::<f64>();
        let knots = adaptive_knots::memory(&self.request, &self.setup);
        directions.sum::<usize>() + arrays + offsets + demand.bytes + knots
    }

    /// Multiplications of one iteration: the measure of how long a step takes, for fair shares of
    /// time.
    pub fn step_cost(&self) -> usize {
        self.residual_cost() + self.method().algorithm().step_cost(self)
    }

    /// The approximate number of multiplications before the first iteration: bases, factorizations, eigenvalues.
    pub fn start_cost(&self) -> usize {
        let method = self.method().algorithm().start_cost(self);
        let placing = adaptive_knots::cost(&self.request, &self.setup);
        self.preparation_cost()
            .saturating_add(method)
            .saturating_add(placing)
    }
}
