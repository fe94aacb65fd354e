//! Conjugate gradients of the normal equations (CGLS), preconditioned with D, for each coordinate by
//! itself. With projected gradients all directions are among those that conditions leave free.

use super::objective::Objective;
use crate::data::points::Points;
use crate::linear::conjugate::Conjugate;
use crate::linear::vectors::add;
use crate::method::equations::Equations;
use crate::method::update::State;

/// What conjugate gradients remember.
#[derive(Clone, Debug)]
pub(super) struct Descent {
    /// Those of each coordinate.
    steps: Vec<Conjugate>,
    /// The directions d of the last step, one for each coordinate.
    direction: Points,
    /// `A d`, one coordinate.
    image: Vec<f64>,
}

impl Descent {
    /// Before the first step of so many control points and data points.
    pub(super) fn new(dimension: usize, control_points: usize, data_points: usize) -> Self {
        Self {
            steps: vec![Conjugate::default(); dimension],
            direction: Points::zeros(dimension, control_points),
            image: vec![0.0; data_points],
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
        for (c, (step, unit)) in self.steps.iter_mut().zip(units).enumerate() {
            let direction = &mut self.direction.lanes_mut()[c];
            step.turn(direction, gradient.lane(c), scale, *unit);
            equations
                .collocation
                .apply(direction, &mut self.image, &mut state.scratch);
            if let Some(missing) = equations.setup.missing() {
                missing.clear(&mut self.image);
            }
            let curvature = objective.curvature(direction, &self.image, *unit);
            let alpha = step.length(curvature).unwrap_or(0.0);
            add(&mut state.control_points.lanes_mut()[c], alpha, direction);
            add(&mut state.residual.lanes_mut()[c], -alpha, &self.image);
        }
    }
}
