//! The coefficients of the Chebyshev semi-iteration.

/// The two-term recurrence of the Chebyshev semi-iteration on an interval [a, 1] of eigenvalues
/// (Golub, Varga 1961). With the centre `θ = (1 + a)/2`, the half-width `δ = (1 − a)/2` and
/// `σ = θ/δ`:
///
/// ```text
/// d⁰ = Δ⁰ / θ,   ρ⁰ = 1/σ
/// X ← X + d
/// ρ' = 1 / (2σ − ρ),   d ← ρ' ρ d + (2 ρ'/δ) Δ
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recurrence {
    /// The centre of the interval.
    theta: f64,
    /// Its half-width.
    delta: f64,
    /// ρ of the last step.
    rho: f64,
    /// True if there was a step.
    begun: bool,
}

impl Recurrence {
    /// Before the first update, for the interval from `least` to 1.
    pub(super) fn new(least: f64) -> Self {
        // All eigenvalues are one if B = I; the interval must not be empty.
        let delta = ((1.0 - least) / 2.0).max(f64::EPSILON);
        let theta = f64::midpoint(1.0, least);
        Self {
            theta,
            delta,
            rho: delta / theta,
            begun: false,
        }
    }

    /// Moves on to the next update: the factors of the last step and of the residual.
    pub(super) fn advance(&mut self) -> (f64, f64) {
        if !self.begun {
            self.begun = true;
            return (0.0, 1.0 / self.theta);
        }
        let next = 1.0 / (2.0 * self.theta / self.delta - self.rho);
        let coefficients = (next * self.rho, 2.0 * next / self.delta);
        self.rho = next;
        coefficients
    }
}
