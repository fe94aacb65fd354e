//! The generalized Ball bases: polynomials that are cheaper to evaluate than Bernstein's.
//!
//! Both generalize the cubic that Ball used in aircraft design, `(1−t)², 2t(1−t)², 2t²(1−t), t²`,
//! to any degree m, with the same span as the Bernstein polynomials of degree m. They differ in the
//! middle functions.

use crate::kind_info::KindInfo;

/// The entry of the Said–Ball basis in the table of bases.
pub(super) const SAID_BALL: KindInfo = KindInfo {
    name: "said_ball",
    title: "Said–Ball basis",
    summary: "A generalized Ball basis of degree control points − 1, totally positive and cheaper to evaluate than Bernstein polynomials.",
    source: "DP07, Definition 7",
};

/// The entry of the Wang–Ball basis in the table of bases.
pub(super) const WANG_BALL: KindInfo = KindInfo {
    name: "wang_ball",
    title: "Wang–Ball basis",
    summary: "A generalized Ball basis of degree control points − 1, not totally positive from degree 4 on, for the extended method.",
    source: "Deng13, example 2",
};

/// Writes the Said–Ball basis of degree m at `t` into `values` (m + 1 numbers); 0 ≤ t ≤ 1.
///
/// With f = ⌊m/2⌋ (DP07, Definition 7):
///
/// ```text
/// S_i(t) = C(f+i, i) tⁱ (1−t)^(f+1)     i ≤ ⌊(m−1)/2⌋
/// S_f(t) = C(m, f) t^f (1−t)^f          in the middle, if m is even
/// S_i(t) = S_{m−i}(1 − t)               i ≥ f + 1
/// ```
///
/// The basis is normalized totally positive, so that PIA converges, more slowly than with Bernstein
/// polynomials. It takes O(m); values below 1e-308 become zero.
pub(crate) fn said_ball(degree: usize, t: f64, values: &mut [f64]) {
    let half = degree / 2;
    let left = degree.div_ceil(2);
    let s = 1.0 - t;
    let (mut up, mut down) = (power(s, half + 1), power(t, half + 1));
    for i in 0..left {
        values[i] = up;
        values[degree - i] = down;
        let ratio = (half + i + 1) as f64 / (i + 1) as f64;
        up *= ratio * t;
        down *= ratio * s;
    }
    if degree.is_multiple_of(2) {
        // C(m, f) t^f (1−t)^f as a product of factors near one, which cannot overflow.
        let middle = (1..=half).fold(1.0, |product, i| {
            product * ((half + i) as f64 / i as f64) * (t * s)
        });
        values[half] = middle;
    }
}

/// Writes the Wang–Ball basis of degree m at `t` into `values` (m + 1 numbers); 0 ≤ t ≤ 1.
///
/// With f = ⌊m/2⌋ and c = ⌈m/2⌉ (Deng13, example 2):
///
/// ```text
/// W_i(t) = (2t)ⁱ (1−t)^(i+2)     i < f
/// W_f(t) = (2t)^f (1−t)^c
/// W_i(t) = W_{m−i}(1 − t)        i ≥ c, i > f
/// ```
///
/// Degree 4: `(1−t)², 2t(1−t)³, 4t²(1−t)², 2t³(1−t), t²`. It is not totally positive from degree 4
/// on: classical PIA is slow with uniform parameters and may diverge with others, and the extended
/// method always works. It takes O(m); values below 1e-308 become zero.
pub(crate) fn wang_ball(degree: usize, t: f64, values: &mut [f64]) {
    let half = degree / 2;
    let s = 1.0 - t;
    let mut product = 1.0;
    for i in 0..half {
        values[i] = product * s * s;
        values[degree - i] = product * t * t;
        product *= 2.0 * t * s;
    }
    if degree.is_multiple_of(2) {
        values[half] = product;
    } else {
        values[half] = product * s;
        values[half + 1] = product * t;
    }
}

/// `x` to the power of a whole number, by repeated multiplication.
fn power(x: f64, exponent: usize) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All values of a basis at a parameter.
    fn row(basis: fn(usize, f64, &mut [f64]), degree: usize, t: f64) -> Vec<f64> {
        let mut values = vec![0.0; degree + 1];
        basis(degree, t, &mut values);
        values
    }

    /// All values differ by less than 1e-15.
    fn assert_close(values: &[f64], expected: &[f64]) {
        assert_eq!(values.len(), expected.len());
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15, "{values:?} {expected:?}");
        }
    }

    /// Degrees 1, 3 and 4, written out.
    #[test]
    fn low_degrees_equal_their_formulas() {
        for t in [0.0_f64, 0.3, 0.5, 0.9, 1.0] {
            let s = 1.0 - t;
            let cubic = [s * s, 2.0 * t * s * s, 2.0 * t * t * s, t * t];
            assert_close(&row(said_ball, 3, t), &cubic);
            assert_close(&row(wang_ball, 3, t), &cubic);
            assert_close(
                &row(said_ball, 4, t),
                &[
                    s.powi(3),
                    3.0 * t * s.powi(3),
                    6.0 * t * t * s * s,
                    3.0 * t.powi(3) * s,
                    t.powi(3),
                ],
            );
            assert_close(
                &row(wang_ball, 4, t),
                &[
                    s * s,
                    2.0 * t * s.powi(3),
                    4.0 * t * t * s * s,
                    2.0 * t.powi(3) * s,
                    t * t,
                ],
            );
            assert_close(&row(wang_ball, 1, t), &[s, t]);
            assert_close(&row(said_ball, 1, t), &[s, t]);
        }
    }

    /// Both bases are normalized and not negative at every degree that is accepted.
    #[test]
    fn functions_sum_to_one_up_to_degree_1000() {
        for degree in [1, 2, 3, 4, 5, 10, 29, 100, 999, 1000] {
            for step in 0..=50 {
                let t = f64::from(step) / 50.0;
                for basis in [said_ball, wang_ball] {
                    let values = row(basis, degree, t);
                    let sum: f64 = values.iter().sum();
                    assert!((sum - 1.0).abs() < 1e-12, "degree {degree}, t = {t}: {sum}");
                    assert!(values.iter().all(|&value| value >= 0.0));
                }
            }
        }
    }
}
