//! Bernstein polynomials, stable for high degrees.
//!
//! ```text
//! B_i(t) = C(m, i) tⁱ (1 − t)^(m−i),   i = 0 … m,   0 ≤ t ≤ 1
//! ```
//!
//! They are the normalized B-basis of the polynomials of degree m, with which PIA converges faster
//! than with any other normalized totally positive basis of that space (DP07, Theorem 4). At t_i =
//! i/m the eigenvalues of the collocation matrix are `m! / ((m − i)! mⁱ)`, and the least one is
//! `m!/mᵐ`: slow for high degrees.

use crate::fit::about::About;

/// The entry in the table of bases.
pub(super) const ABOUT: About = About {
    name: "bernstein",
    title: "Bernstein polynomials",
    summary: "The basis of Bézier curves, of degree control points − 1: the fastest of its space.",
    source: "DP07, Theorem 4",
};

/// Writes `B_i(t)`, i = 0 … m, into `values` (m + 1 numbers), for degree m ≤ 1000 and 0 ≤ t ≤ 1, in
/// O(m).
///
/// The product form over- and underflows at m ≈ 1000. Here the largest value, at `i = ⌊(m+1) t⌋`,
/// is set to one, and the others follow from the ratio of neighbours,
///
/// ```text
/// B_{i+1} / B_i = (m − i)/(i + 1) · t/(1 − t)
/// ```
///
/// which falls on both sides. Then all are divided by their sum, because Bernstein polynomials sum
/// to one. The relative error of a value is a few rounding errors times the number of steps from
/// the largest one; values below 1e-308 become zero.
pub(crate) fn evaluate(degree: usize, t: f64, values: &mut [f64]) {
    let m = degree as f64;
    let s = 1.0 - t;
    let peak = (((m + 1.0) * t) as usize).min(degree);
    values[peak] = 1.0;
    for i in peak..degree {
        values[i + 1] = values[i] * ((m - i as f64) * t) / ((i as f64 + 1.0) * s);
    }
    for i in (0..peak).rev() {
        values[i] = values[i + 1] * ((i as f64 + 1.0) * s) / ((m - i as f64) * t);
    }
    // From the small values to the large one, so that the sum is as exact as they are.
    let left: f64 = values[..peak].iter().sum();
    let right: f64 = values[peak..=degree].iter().rev().sum();
    let total = left + right;
    for value in &mut values[..=degree] {
        *value /= total;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bernstein(degree: usize, t: f64) -> Vec<f64> {
        let mut values = vec![0.0; degree + 1];
        evaluate(degree, t, &mut values);
        values
    }

    /// Degree 3 at parameters whose values are exact fractions.
    #[test]
    fn low_degrees_equal_the_product_form() {
        for (t, expected) in [
            (0.0, [1.0, 0.0, 0.0, 0.0]),
            (0.25, [27.0 / 64.0, 27.0 / 64.0, 9.0 / 64.0, 1.0 / 64.0]),
            (0.5, [0.125, 0.375, 0.375, 0.125]),
            (1.0, [0.0, 0.0, 0.0, 1.0]),
        ] {
            for (value, expected) in bernstein(3, t).iter().zip(expected) {
                assert!((value - expected).abs() < 1e-16, "t = {t}");
            }
        }
    }

    /// The mean of the binomial distribution is mt and its variance mt(1 − t): exact facts about
    /// all the values at once, at degrees where C(m, i) has 300 digits.
    #[test]
    fn high_degrees_keep_the_binomial_moments() {
        for degree in [10, 100, 500, 1000] {
            for t in [1e-9, 0.001, 0.1, 0.37, 0.5, 0.9, 0.999_999] {
                let values = bernstein(degree, t);
                let m = degree as f64;
                let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
                    values
                        .iter()
                        .enumerate()
                        .map(|(i, b)| f(i as f64) * b)
                        .sum()
                };
                assert!((moment(&|_| 1.0) - 1.0).abs() < 1e-15);
                assert!((moment(&|i| i) / (m * t) - 1.0).abs() < 1e-12);
                let variance = moment(&|i| (i - m * t).powi(2));
                assert!((variance / (m * t * (1.0 - t)) - 1.0).abs() < 1e-11);
            }
        }
    }

    /// C(1000, 500) / 2^1000, computed with integer arithmetic.
    #[test]
    fn the_middle_of_degree_1000_is_right() {
        let value = bernstein(1000, 0.5)[500];
        assert!((value / 0.025_225_018_178_360_8 - 1.0).abs() < 1e-13);
    }
}
