//! Where large arrays of numbers come from: any part of them, at any time.

use std::sync::Arc;

use crate::fit::direction::Direction;
use crate::fit::invalid::Axis;
use crate::fit::points::Points;
use crate::fit::problem::Problem;

/// An array of numbers. It is shared by threads and lives as long as somebody may send it.
pub trait Source: Send + Sync + 'static {
    /// The numbers from `start` on, as many as there is room for.
    fn fill(&self, start: usize, numbers: &mut [f64]);
}

impl Source for Vec<f64> {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        numbers.copy_from_slice(&self[start..start + numbers.len()]);
    }
}

/// The coordinates of points, point by point.
impl Source for Points {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        let dimension = self.dimension();
        for (k, numbers) in numbers.chunks_mut(dimension).enumerate() {
            let point = self.point(start / dimension + k);
            numbers.iter_mut().zip(point).for_each(|(to, x)| *to = x);
        }
    }
}

/// The complete control net of a level, end copies included: the coordinates of its points.
pub struct Net {
    /// What was fitted.
    pub problem: Arc<Problem>,
    /// The free control points.
    pub control_points: Arc<Points>,
}

impl Net {
    /// Calls `visit` with the free control point at each place of the net from `start` on.
    fn each(&self, start: usize, count: usize, mut visit: impl FnMut(usize, usize)) {
        let u = self.problem.u();
        let Some(v) = self.problem.v() else {
            return (0..count).for_each(|k| visit(k, u.free_index(start + k)));
        };
        let (across, free) = (v.basis.functions(), self.problem.control_grid().columns);
        let (mut row, mut column) = (start / across, start % across);
        for k in 0..count {
            visit(k, u.free_index(row) * free + v.free_index(column));
            column += 1;
            if column == across {
                (row, column) = (row + 1, 0);
            }
        }
    }
}

impl Source for Net {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        let dimension = self.problem.dimension();
        let lanes = self.control_points.lanes();
        let weights = lanes.last().filter(|_| self.problem.is_homogeneous());
        let count = numbers.len() / dimension;
        self.each(start / dimension, count, |k, index| {
            let place = &mut numbers[k * dimension..][..dimension];
            for (x, lane) in place.iter_mut().zip(lanes) {
                *x = lane[index];
            }
            if let Some(weights) = weights {
                place.iter_mut().for_each(|x| *x /= weights[index]);
            }
        });
    }
}

/// The weights of the control net of a homogeneous fit.
pub struct NetWeights(pub Net);

impl Source for NetWeights {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        let Self(net) = self;
        if let Some(weights) = net.control_points.lanes().last() {
            net.each(start, numbers.len(), |k, index| numbers[k] = weights[index]);
        }
    }
}

/// Numbers of a direction: its parameters, knots or weights.
pub struct Along {
    /// What was fitted.
    pub problem: Arc<Problem>,
    /// The direction.
    pub axis: Axis,
    /// Which numbers.
    pub numbers: fn(&Direction) -> &[f64],
}

impl Along {
    fn all(&self) -> &[f64] {
        let v = self.problem.v().filter(|_| self.axis == Axis::V);
        (self.numbers)(v.unwrap_or(self.problem.u()))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all().len()
    }
}

impl Source for Along {
    fn fill(&self, start: usize, numbers: &mut [f64]) {
        numbers.copy_from_slice(&self.all()[start..start + numbers.len()]);
    }
}
