//! Sums over vectors.

/// `Σ x y`.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// The Euclidean length.
pub(crate) fn length(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// `x ← x + factor y`.
pub(crate) fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
}
