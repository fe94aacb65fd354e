//! The transform U of the update `X ← X + U Δ`: the method of the fit.

use super::points::Points;

/// The method asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Classical PIA, U = I (LBW05 (2.9), DP07 (1)).
    Global,
}

/// The transform U of a method, made for one problem.
#[derive(Clone, Debug)]
pub enum Transform {
    /// `U = ω I`.
    Scale(f64),
}

impl Transform {
    /// The transform of `method`.
    pub fn new(method: Method) -> Self {
        match method {
            Method::Global => Self::Scale(1.0),
        }
    }

    /// `X ← X + U Δ`; returns how many control points were moved.
    pub fn update(&self, control_points: &mut Points, residual: &Points) -> usize {
        let count = control_points.len();
        match self {
            Self::Scale(omega) => {
                for (x, delta) in control_points.lanes_mut().iter_mut().zip(residual.lanes()) {
                    for (x, delta) in x.iter_mut().zip(delta) {
                        *x += omega * delta;
                    }
                }
                count
            }
        }
    }
}
