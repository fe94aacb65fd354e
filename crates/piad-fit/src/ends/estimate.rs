//! Derivatives at an end, from the points there.
//!
//! A polynomial through the points f_0, f_1, … at s_0 = 0 < s_1 < … in Newton's form has divided
//! differences as its coefficients, among them those of the end repeated, `f[0, …, 0] = a_r`, where
//! derivatives are given. Differences of parameters are taken between neighbours, as those to a far
//! end would lose their digits.

/// The Taylor coefficients `a_1 … a_k` at the first parameter, of one coordinate, where the first
/// ones are `given`: those of the polynomial of degree k + 1 that has them and goes through the
/// `values` at these `parameters`, of a lower degree if there are fewer. Coefficients belong to
/// powers of `(t − t_0) / unit`.
pub(super) fn taylor(
    parameters: &[f64],
    unit: f64,
    values: &[f64],
    given: &[f64],
    count: usize,
) -> Vec<f64> {
    let known = given.len().min(count);
    // The end comes once more for each derivative that is given.
    let places = parameters.len().min(count + 2 - known) + known;
    let place = |i: usize| i.saturating_sub(known);
    let gap = |i: usize, j: usize| (parameters[place(j)] - parameters[place(i)]) / unit;
    let mut newton: Vec<f64> = (0..places).map(|i| values[place(i)]).collect();
    for order in 1..places {
        for i in (order..places).rev() {
            newton[i] = match place(i) {
                0 => given[order - 1],
                _ => (newton[i] - newton[i - 1]) / gap(i - order, i),
            };
        }
    }
    let nodes = (0..places).map(|i| gap(0, i)).collect();
    let mut coefficients = monomials(nodes, &newton);
    coefficients.resize(count + 1, 0.0);
    coefficients.split_off(1)
}

/// The coefficients of the powers of s, from those of Newton's form, by Horner's rule.
fn monomials(nodes: Vec<f64>, newton: &[f64]) -> Vec<f64> {
    let mut powers = vec![0.0; newton.len()];
    for (node, coefficient) in nodes.into_iter().zip(newton).rev() {
        for i in (1..powers.len()).rev() {
            powers[i] = powers[i - 1] - node * powers[i];
        }
        if let Some(constant) = powers.first_mut() {
            *constant = coefficient - node * *constant;
        }
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of the requested degree are reproduced, with given or estimated coefficients;
    /// gaps of 0.05 between nodes multiply rounding by some hundreds.
    #[test]
    fn polynomials_are_reproduced() {
        let nodes = [1.0, 1.4, 1.6, 2.4, 2.5, 3.0];
        let exact = [2.0, -1.0, 0.5, 3.0];
        let at = |t: &f64| {
            let s = (t - 1.0) / 2.0;
            4.0 + exact.iter().rev().fold(0.0, |sum, a| (sum + a) * s)
        };
        let values: Vec<f64> = nodes.iter().map(at).collect();
        for known in 0..=3 {
            let found = taylor(&nodes, 2.0, &values, &exact[..known], 3);
            assert_eq!(found.len(), 3);
            for (found, exact) in found.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-12, "{known}: {found} {exact}");
            }
        }
    }

    /// Three points give Bessel's end derivative, two the chord, one nothing.
    #[test]
    fn fewer_points_give_lower_degrees() {
        let slope = |nodes: &[f64], values: &[f64]| taylor(nodes, 1.0, values, &[], 2);
        assert_eq!(slope(&[0.0, 1.0, 2.0], &[0.0, 1.0, 4.0]), [0.0, 1.0]);
        assert_eq!(slope(&[3.0, 5.0], &[1.0, 5.0]), [2.0, 0.0]);
        assert_eq!(slope(&[7.0], &[1.0]), [0.0, 0.0]);
    }

    /// Points that are close to each other and far from the end.
    #[test]
    fn far_ends_keep_their_digits() {
        let found = taylor(&[1e300, 2.8, 1.4], -1e300, &[1.0, 3.0, 2.0], &[], 1);
        // Twice the slope to the end, less that between the other two.
        assert!((found[0] / (1e300 / 1.4) - 1.0).abs() < 1e-14, "{found:?}");
    }
}
