//! Steps towards the least-squares fit over fixed knots, by conjugate gradients.
//!
//! The same step as that of least-squares PIA ([`crate::method::least_squares`]), with fixed ends:
//! CGLS for each coordinate, preconditioned with the diagonal 1 / column sums of A. It starts from
//! any curve, so that a fit can continue after knots were inserted.

use super::values::Values;
use crate::data::blocks::{LANES, add_up};
use crate::data::distances::Distances;
use crate::data::points::Points;
use crate::linear::conjugate::Conjugate;
use crate::linear::vectors::add;

/// Conjugate gradients over some knots.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    /// The preconditioner D: zero for control points that stay.
    scale: Vec<f64>,
    /// Brings squares to the order of one.
    unit: f64,
    /// `P − A X`.
    residual: Points,
    /// The directions of the last step.
    direction: Points,
    /// What is remembered of each coordinate.
    conjugate: Vec<Conjugate>,
    gradient: Points,
    image: Points,
}

impl Steps {
    /// Starts from a curve.
    pub(crate) fn new(
        values: &Values,
        control_points: &Points,
        points: &Points,
        unit: f64,
    ) -> Self {
        let (count, dimension) = (control_points.len(), points.dimension());
        let mut scale = vec![0.0; count];
        let ones = vec![1.0; points.len()];
        values.apply_transposed(&[ones], &mut [&mut scale[..]]);
        scale
            .iter_mut()
            .for_each(|sum| *sum = if *sum > 0.0 { 1.0 / *sum } else { 0.0 });
        let fixed = values.line().fixed_ends();
        scale[..fixed].fill(0.0);
        scale[count - fixed..].fill(0.0);
        Self {
            scale,
            unit,
            residual: values.residual(control_points, points),
            direction: Points::zeros(dimension, count),
            conjugate: vec![Conjugate::default(); dimension],
            gradient: Points::zeros(dimension, count),
            image: Points::zeros(dimension, points.len()),
        }
    }

    /// The distances of the data from the curve.
    pub(crate) fn distances(&self) -> Distances {
        Distances::of_residual(&self.residual, self.unit)
    }

    /// One step for each coordinate.
    pub(crate) fn step(&mut self, values: &Values, control_points: &mut Points) {
        values.apply_transposed(self.residual.lanes(), self.gradient.lanes_mut());
        for (c, conjugate) in self.conjugate.iter_mut().enumerate() {
            let direction = &mut self.direction.lanes_mut()[c];
            conjugate.turn(direction, self.gradient.lane(c), &self.scale, self.unit);
        }
        values.apply(self.direction.lanes(), self.image.lanes_mut());
        for (c, conjugate) in self.conjugate.iter().enumerate() {
            let (image, direction) = (self.image.lane(c), self.direction.lane(c));
            if let Some(alpha) = conjugate.length(sum_of_squares(image, self.unit)) {
                add(&mut control_points.lanes_mut()[c], alpha, direction);
                add(&mut self.residual.lanes_mut()[c], -alpha, image);
            }
        }
    }
}

/// `Σ (unit q)²`.
fn sum_of_squares(numbers: &[f64], unit: f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let (chunks, rest) = numbers.as_chunks();
    let square = |(lane, q): (&mut f64, &f64)| *lane += (q * unit) * (q * unit);
    for chunk in chunks {
        let chunk: &[f64; LANES] = chunk;
        lanes.iter_mut().zip(chunk).for_each(square);
    }
    lanes.iter_mut().zip(rest).for_each(square);
    add_up(lanes)
}
