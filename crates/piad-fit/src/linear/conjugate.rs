//! Steps of conjugate gradients towards a minimum of least squares, of one coordinate.

/// What is remembered of the steps before.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Conjugate {
    /// `γ = gᵀ D g` of the last step.
    gamma: f64,
}

impl Conjugate {
    /// `d ← D g + β d` with the quotient β of γ and the one before, where D is the diagonal `scale`. Squares are those of
    /// numbers in this `unit`.
    pub(crate) fn turn(
        &mut self,
        direction: &mut [f64],
        gradient: &[f64],
        scale: &[f64],
        unit: f64,
    ) {
        let pairs = || gradient.iter().zip(scale);
        let gamma: f64 = pairs().map(|(g, d)| (g * unit) * d * (g * unit)).sum();
        self.turn_to(direction, pairs().map(|(g, d)| d * g), gamma);
    }

    /// The same of D g and γ that are known.
    pub(crate) fn turn_to(
        &mut self,
        direction: &mut [f64],
        conditioned: impl Iterator<Item = f64>,
        gamma: f64,
    ) {
        let before = std::mem::replace(&mut self.gamma, gamma);
        let beta = if before > 0.0 { gamma / before } else { 0.0 };
        let pairs = direction.iter_mut().zip(conditioned);
        pairs.for_each(|(d, g)| *d = g + beta * *d);
    }

    /// `α = γ / dᵀ N d`, if the curvature `dᵀ N d` is positive: at the minimum there is nowhere to go.
    pub(crate) fn length(&self, curvature: f64) -> Option<f64> {
        (curvature > 0.0).then(|| self.gamma / curvature)
    }
}
