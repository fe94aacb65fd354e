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

use crate::kind_info::KindInfo;

/// The entry in the table of bases.
pub(super) const INFO: KindInfo = KindInfo {
    name: "bernstein",
    title: "Bernstein polynomials",
    summary: "The basis of Bézier curves, of degree control points − 1: the fastest of its space.",
    source: "DP07, Theorem 4",
};

/// 2^-200, 6e-61. A value as small adds less than rounding to a point of a curve, unless its
/// control points differ in size by more than 1e44.
const NEGLIGIBLE: f64 = f64::from_bits((1023 - 200) << 52);

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
/// the largest one; those beyond the first below 2^-200 are zero: of degree 1000, three of five.
pub(crate) fn evaluate(degree: usize, t: f64, values: &mut [f64]) {
    let m = degree as f64;
    let s = 1.0 - t;
    let peak = (((m + 1.0) * t) as usize).min(degree);
    values[peak] = 1.0;
    let (mut first, mut end) = (peak, peak + 1);
    while end <= degree && values[end - 1] > NEGLIGIBLE {
        let i = (end - 1) as f64;
        values[end] = values[end - 1] * ((m - i) * t) / ((i + 1.0) * s);
        end += 1;
    }
    while first > 0 && values[first] > NEGLIGIBLE {
        first -= 1;
        let i = first as f64;
        values[first] = values[first + 1] * ((i + 1.0) * s) / ((m - i) * t);
    }
    values[..first].fill(0.0);
    values[end..=degree].fill(0.0);
    // Summed from small to large values, for accuracy.
    let left: f64 = values[first..peak].iter().sum();
    let right: f64 = values[peak..end].iter().rev().sum();
    let total = left + right;
    for value in &mut values[first..end] {
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
