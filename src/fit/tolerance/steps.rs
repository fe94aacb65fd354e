//! Steps towards the least-squares fit over fixed knots, by conjugate gradients.
//!
//! The same step as that of least-squares PIA ([`crate::fit::method::least_squares`]), with fixed
//! ends: CGLS for each coordinate, preconditioned with the diagonal 1 / column sums of A. It starts
//! from any curve, so that a fit goes on after knots were inserted.

use super::equations::fixed_ends;
use super::line::KnotLine;
use super::values::Values;
use crate::fit::points::{Points, normalizing_scale};

/// Conjugate gradients over some knots.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    /// The preconditioner: zero for control points that stay.
    scale: Vec<f64>,
    /// Brings squares to the order of one.
    unit: f64,
    /// `P − A X`.
    residual: Points,
    /// The directions of the last step.
    direction: Points,
    /// `gᵀ D g` of each coordinate in the last step.
    gamma: Vec<f64>,
    gradient: Vec<f64>,
    image: Vec<f64>,
}

impl Steps {
    /// Starts from a curve.
    pub(crate) fn new(
        line: &KnotLine,
        values: &Values,
        control_points: &Points,
        points: &Points,
    ) -> Self {
        let (count, data) = (line.control_points(), points.len());
        let mut scale = vec![0.0; count];
        values.apply_transposed(line, &vec![1.0; data], &mut scale);
        scale
            .iter_mut()
            .for_each(|sum| *sum = if *sum > 0.0 { 1.0 / *sum } else { 0.0 });
        let fixed = fixed_ends(line);
        scale[..fixed].fill(0.0);
        scale[count - fixed..].fill(0.0);
        let lanes = control_points.lanes().iter().zip(points.lanes());
        let residual = Points::from_lanes(lanes.map(|(x, data)| {
            let mut fit = vec![0.0; data.len()];
            values.apply(line, x, &mut fit);
            fit.iter_mut()
                .zip(&**data)
                .for_each(|(fit, data)| *fit = data - *fit);
            fit
        }));
        Self {
            scale,
            unit: normalizing_scale(points.magnitude()),
            residual,
            direction: Points::zeros(points.dimension(), count),
            gamma: vec![0.0; points.dimension()],
            gradient: vec![0.0; count],
            image: vec![0.0; data],
        }
    }

    /// One step for each coordinate.
    pub(crate) fn step(&mut self, line: &KnotLine, values: &Values, control_points: &mut Points) {
        for (c, x) in control_points.lanes_mut().iter_mut().enumerate() {
            let residual = &mut self.residual.lanes_mut()[c];
            let direction = &mut self.direction.lanes_mut()[c];
            values.apply_transposed(line, residual, &mut self.gradient);
            let weighed = self.gradient.iter().zip(&self.scale);
            let gamma: f64 = weighed
                .map(|(g, d)| (g * self.unit) * d * (g * self.unit))
                .sum();
            let beta = if self.gamma[c] > 0.0 {
                gamma / self.gamma[c]
            } else {
                0.0
            };
            self.gamma[c] = gamma;
            for ((direction, g), d) in direction.iter_mut().zip(&self.gradient).zip(&self.scale) {
                *direction = d * g + beta * *direction;
            }
            values.apply(line, direction, &mut self.image);
            let curvature: f64 = self
                .image
                .iter()
                .map(|q| (q * self.unit) * (q * self.unit))
                .sum();
            if curvature > 0.0 {
                let alpha = gamma / curvature;
                x.iter_mut()
                    .zip(&**direction)
                    .for_each(|(x, d)| *x += alpha * d);
                residual
                    .iter_mut()
                    .zip(&self.image)
                    .for_each(|(r, q)| *r -= alpha * q);
            }
        }
    }
}
