//! Conjugate gradients of the normal equations (CGLS), preconditioned with D, for each coordinate
//! by itself. With projected gradients all directions satisfy the conditions.

use super::objective::Objective;
use crate::data::points::Points;
use crate::method::equations::Equations;
use crate::method::update::State;

/// The state of conjugate gradients.
#[derive(Clone, Debug)]
pub(super) struct Conjugate {
    /// The directions d of the last step, one for each coordinate.
    direction: Points,
    /// `A d`, one coordinate.
    image: Vec<f64>,
    /// `gᵀ D g` of each coordinate.
    gamma: Vec<f64>,
    /// True if there was a step.
    begun: bool,
}

impl Conjugate {
    /// The state before the first step, for these numbers of control points and data points.
    pub(super) fn new(dimension: usize, control_points: usize, data_points: usize) -> Self {
        Self {
            direction: Points::zeros(dimension, control_points),
            image: vec![0.0; data_points],
            gamma: vec![0.0; dimension],
            begun: false,
        }
    }

    /// CGLS, preconditioned with D, for each coordinate by itself.
    pub(super) fn update(
        &mut self,
        (equations, objective): (&Equations, &Objective),
        state: &mut State,
        gradient: &Points,
        scale: &[f64],
        units: &[f64],
    ) {
        for ((c, gradient), unit) in gradient.lanes().iter().enumerate().zip(units) {
            let direction = &mut self.direction.lanes_mut()[c];
            let squares = gradient.iter().zip(scale);
            let gamma: f64 = squares.map(|(g, d)| (g * unit) * d * (g * unit)).sum();
            let beta = if self.begun && self.gamma[c] > 0.0 {
                gamma / self.gamma[c]
            } else {
                0.0
            };
            self.gamma[c] = gamma;
            for ((direction, g), d) in direction.iter_mut().zip(gradient).zip(scale) {
                *direction = d * g + beta * *direction;
            }
            equations
                .collocation
                .apply(direction, &mut self.image, &mut state.scratch);
            if let Some(missing) = equations.setup.missing() {
                missing.clear(&mut self.image);
            }
            let curvature = objective.curvature(direction, &self.image, *unit);
            // At the minimum there is no direction.
            let alpha = if curvature > 0.0 {
                gamma / curvature
            } else {
                0.0
            };
            let x = &mut state.control_points.lanes_mut()[c];
            for (x, direction) in x.iter_mut().zip(&*direction) {
                *x += alpha * direction;
            }
            let residual = &mut state.residual.lanes_mut()[c];
            for (residual, image) in residual.iter_mut().zip(&self.image) {
                *residual -= alpha * image;
            }
        }
        self.begun = true;
    }
}
