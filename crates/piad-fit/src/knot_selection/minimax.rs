//! A smaller largest distance over the same knots, by weights that grow with the distances (Lawson
//! 1961).
//!
//! ```text
//! w_i ← w_i (e_i / max e + ε)
//! ```
//!
//! The weighted least-squares fits converge to the one with the smallest largest distance, slowly
//! and not monotonically; a few steps bring most of the gain, a tenth to a third.

/// Keeps weights of points that the curve goes through from vanishing.
const LEAST: f64 = 1e-3;

/// The weights of data points.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    values: Vec<f64>,
}

impl Weights {
    /// All alike.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            values: vec![1.0; count],
        }
    }

    /// Raises those of points that are far away.
    pub(crate) fn raise(&mut self, distances: &[f64], largest: f64) {
        let mut sum = 0.0;
        for (w, e) in self.values.iter_mut().zip(distances) {
            *w *= e / largest + LEAST;
            sum += *w;
        }
        let mean = sum / self.values.len() as f64;
        // None falls far below the mean: the equations stay determined.
        self.values
            .iter_mut()
            .for_each(|w| *w = (*w / mean).max(1e-6));
    }

    /// One for each data point, one in the mean.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}
