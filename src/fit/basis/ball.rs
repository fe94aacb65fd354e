//! The generalized Ball bases: polynomials that are cheaper to evaluate than Bernstein's.

use crate::fit::about::About;

/// The entry of the Said–Ball basis in the table of bases.
pub(super) const SAID_BALL: About = About {
    name: "said_ball",
    title: "Said–Ball basis",
    summary: "A generalized Ball basis of degree control points − 1, totally positive and cheaper to evaluate than Bernstein polynomials.",
    source: "DP07, Definition 7",
};

/// The entry of the Wang–Ball basis in the table of bases.
pub(super) const WANG_BALL: About = About {
    name: "wang_ball",
    title: "Wang–Ball basis",
    summary: "A generalized Ball basis of degree control points − 1, not totally positive from degree 4 on, for the extended method.",
    source: "Deng13, example 2",
};

/// Writes the Said–Ball basis of degree m at `t` into `values` (m + 1 numbers); 0 ≤ t ≤ 1.
///
/// With f = ⌊m/2⌋ (DP07, Definition 7): `C(f+i, i) t^i (1−t)^(f+1)` for i ≤ ⌊(m−1)/2⌋, the mirror
/// image for i ≥ f + 1, and `C(m, f) t^f (1−t)^f` in the middle if m is even. The basis is
/// normalized totally positive.
pub fn said_ball(degree: usize, t: f64, values: &mut [f64]) {
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
/// With f = ⌊m/2⌋ and c = ⌈m/2⌉: `(2t)^i (1−t)^(i+2)` for i < f, `(2t)^f (1−t)^c` for i = f, and
/// their mirror images. It is not totally positive from degree 4 on: classical PIA may be slow or
/// diverge with it, the extended method always works.
pub fn wang_ball(degree: usize, t: f64, values: &mut [f64]) {
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

fn power(x: f64, exponent: usize) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(basis: fn(usize, f64, &mut [f64]), degree: usize, t: f64) -> Vec<f64> {
        let mut values = vec![0.0; degree + 1];
        basis(degree, t, &mut values);
        values
    }

    fn assert_close(values: &[f64], expected: &[f64]) {
        assert_eq!(values.len(), expected.len());
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15, "{values:?} {expected:?}");
        }
    }

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
