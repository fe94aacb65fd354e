//! Knots of B-splines: where they are placed.
//!
//! With n + 1 parameters `t_0 < … < t_n` and degree p an open B-spline has *clamped* knots: the
//! first and the last p + 1 are equal to the ends of the parameters, so that the curve begins and
//! ends at control points. The choices differ in the knots between:
//!
//! - at the data (LBW05 (3.1)): the parameters between, and n + p control points of which n + 1 are
//!   free;
//! - averaged (PT97 (9.8)): means of p successive parameters, and n + 1 control points;
//! - spread, for least squares: at equal shares of the parameters' indices, so that there is a parameter in every span,
//!   and reversed parameters have reversed knots;
//! - adaptive, for least squares: first spread, then placed by the data (`knot_selection::adaptive`);
//! - for as few control points as a tolerance needs (PT97 (9.68)–(9.69)): about as many parameters in
//!   every span, of which the first ones have fewer;
//! - periodic: at or midway between the parameters, repeated with their period.
//!
//! For parameters 0, 1, 3, 4, 6, 10 and degree 3:
//!
//! ```text
//! at the data   0 0 0 0   1   3   4   6   10 10 10 10     8 control points, 6 of them free
//! averaged      0 0 0 0    8/3   13/3     10 10 10 10     6 control points
//! ```
//!
//! Functions with knots at the data are centred on the data points for odd degrees, which makes
//! their collocation matrix well conditioned; for even degrees they lie between. Averaged knots are
//! well conditioned for every degree, and what most CAD systems use.

use std::sync::Arc;

use crate::data::quantiles::Position;

/// How the knots of a B-spline direction are chosen.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Knots {
    /// The default of the method and the degree: at the data for odd degrees, averaged for even ones, and spread for
    /// open least-squares fits.
    Usual,
    /// Interior knots are the interior parameters (LBW05 (3.1), LWD04 (1)).
    Data,
    /// Interior knots are averages of `degree` successive parameters (PT97 (9.8)).
    Averaged,
    /// At equal shares of the parameters' indices; open least-squares fits.
    Spread,
    /// Placed by the data, at equal shares of their distances; least-squares fits of curves.
    Adaptive,
    /// Given knots, clamped at both ends.
    Explicit(Arc<Vec<f64>>),
}

/// Interior knots at the interior parameters, ends of multiplicity p + 1 (LBW05 (3.1)): n + 2 p + 1 knots for n + 1
/// parameters, and n + p functions. Any degree is possible, even one above n.
pub(crate) fn at_data(t: &[f64], degree: usize) -> Vec<f64> {
    clamped(t, degree, t[1..t.len() - 1].iter().copied())
}

/// `u_{j+p} = (t_j + … + t_{j+p−1}) / p`, j = 1 … n − p, ends of multiplicity p + 1 (PT97 (9.8)):
/// n + p + 2 knots for n + 1 parameters, and n + 1 functions. The collocation matrix is
/// nonsingular. Needs p ≤ n.
pub(crate) fn averaged(t: &[f64], degree: usize) -> Vec<f64> {
    let interior = t[1..t.len() - 1]
        .windows(degree)
        .map(|window| window.iter().sum::<f64>() / degree as f64);
    clamped(t, degree, interior)
}

/// Knots for n + 1 control points, of m + 1 ≥ n + 1 data points, at equal shares of the indices of the
/// parameters: `u_{p+j}` is the parameter at `j m / (n − p + 1)`, j = 1 … n − p, interpolated
/// between its neighbours.
///
/// Shares are at least one index long, as m ≥ n and p ≥ 1: each span holds a parameter, and the
/// parameters nearest to `k m / n`, k = 0 … n, fulfil the condition of Schoenberg and Whitney, so that
/// `AᵀA` is nonsingular. The knots of reversed parameters are reversed. Needs p ≤ n.
pub(crate) fn spread(t: &[f64], degree: usize, control_points: usize) -> Vec<f64> {
    let (spans, last) = (control_points - degree, t.len() - 1);
    let knot = |j| Position::new(j, spans, last).between(|i| t[i]);
    clamped(t, degree, (1..spans).map(knot))
}

/// Knots for n + 1 control points, fewer than the m + 1 data points (PT97 (9.68)–(9.69)):
///
/// ```text
/// d = (m + 1) / (n − p + 1),   i = ⌊j d⌋,   α = j d − i
/// u_{p+j} = (1 − α) t_{i−1} + α t_i,   j = 1 … n − p
/// ```
///
/// There is a parameter in every span, so that `AᵀA` is nonsingular. Reversed parameters have other
/// knots. Needs p ≤ n.
pub(crate) fn piegl_tiller(t: &[f64], degree: usize, control_points: usize) -> Vec<f64> {
    let spans = control_points - degree;
    let d = t.len() as f64 / spans as f64;
    let interior = (1..spans).map(|j| {
        let x = j as f64 * d;
        let i = (x as usize).clamp(1, t.len() - 1);
        let alpha = x - i as f64;
        (1.0 - alpha) * t[i - 1] + alpha * t[i]
    });
    clamped(t, degree, interior)
}

/// Knots of a closed B-spline with the requested number of control points: those of a period, from the start of the
/// domain, and p more on either side.
///
/// The sites are the parameters, or with fewer control points than parameters interpolated between
/// them at equal distances. Odd degrees have their knots at the sites, even degrees half a
/// parameter before them: at the sites the collocation matrix of an even number of points would be
/// singular, and further away the last parameters would lie outside of the domain.
pub(crate) fn periodic(t: &[f64], period: f64, degree: usize, control_points: usize) -> Vec<f64> {
    let before = if degree.is_multiple_of(2) { 0.5 } else { 0.0 };
    let knot = |j: isize| -> f64 {
        let n = control_points as isize;
        let mut turns = j.div_euclid(n) as f64;
        let mut x = j.rem_euclid(n) as f64 * t.len() as f64 / n as f64 - before;
        if x < 0.0 {
            (x, turns) = (x + t.len() as f64, turns - 1.0);
        }
        let i = x as usize;
        let alpha = x - i as f64;
        let next = t.get(i + 1).copied().unwrap_or(t[0] + period);
        let site = if alpha == 0.0 {
            t[i]
        } else {
            (1.0 - alpha) * t[i] + alpha * next
        };
        site + turns * period
    };
    let p = degree as isize;
    (-p..=control_points as isize + p).map(knot).collect()
}

/// Knots of a curve in pieces that meet at corners, from the parameters of the data and the number of control points of
/// each piece.
///
/// Those between two corners are averaged with a control point for each data point, and spread with fewer; none where
/// there are at most p. A corner has p knots.
pub(crate) fn in_pieces(degree: usize, pieces: &[(&[f64], usize)]) -> Vec<f64> {
    let mut knots = Vec::new();
    for (t, count) in pieces {
        if knots.is_empty() {
            knots.resize(degree + 1, t[0]);
        }
        if *count > degree {
            let whole = match *count == t.len() {
                true => averaged(t, degree),
                false => spread(t, degree, *count),
            };
            knots.extend(&whole[degree + 1..*count]);
        }
        knots.resize(knots.len() + degree, t[t.len() - 1]);
    }
    knots.extend(knots.last().copied());
    knots
}

/// The interior knots between both ends of the parameters, each p + 1 times.
fn clamped(t: &[f64], degree: usize, interior: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut knots = Vec::with_capacity(t.len() + 2 * degree);
    knots.resize(degree + 1, t[0]);
    knots.extend(interior);
    knots.resize(knots.len() + degree + 1, t[t.len() - 1]);
    knots
}

#[cfg(test)]
mod tests {
    use super::super::given_knots::{check, check_schoenberg_whitney};
    use super::*;
    use crate::invalid::Axis;

    const T: [f64; 6] = [0.0, 1.0, 3.0, 4.0, 6.0, 10.0];

    /// Knots at the data and averaged ones of uneven parameters.
    #[test]
    fn both_choices_follow_their_formulas() {
        assert_eq!(
            at_data(&T, 2),
            [0.0, 0.0, 0.0, 1.0, 3.0, 4.0, 6.0, 10.0, 10.0, 10.0]
        );
        let third = 1.0 / 3.0;
        let expected = [
            0.0,
            0.0,
            0.0,
            0.0,
            8.0 * third,
            13.0 * third,
            10.0,
            10.0,
            10.0,
            10.0,
        ];
        for (knot, expected) in averaged(&T, 3).iter().zip(expected) {
            assert!((knot - expected).abs() < 1e-15);
        }
        assert_eq!(averaged(&T, 5).len(), 12);
    }

    /// Parameters with steps of up to four magnitudes.
    fn uneven(count: usize) -> Vec<f64> {
        let step = |i: usize| [1.0, 0.01, 3.0, 1e-3, 0.3, 10.0, 0.1][i * i % 7];
        let steps = (0..count).scan(-2.0, |t, i| {
            *t += step(i);
            Some(*t)
        });
        steps.collect()
    }

    /// Of every size: each span holds a parameter, the parameters determine the control points, and
    /// reversed ones have reversed knots.
    #[test]
    fn spread_knots_suit_all_sizes() {
        let sizes = (1..=9).flat_map(|p| (p + 1..28).map(move |n| (p, n)));
        for (degree, control_points) in sizes {
            for count in (control_points..3 * control_points).chain([97, 128, 1000]) {
                let t = uneven(count);
                let knots = spread(&t, degree, control_points);
                let what = format!("degree {degree}, {control_points} of {count}");
                assert!(
                    check(&knots, degree, control_points, Axis::U).is_ok(),
                    "{what}"
                );
                let breaks = &knots[degree..=control_points];
                for span in breaks.windows(2) {
                    let within = |x: &f64| (span[0]..span[1]).contains(x);
                    assert!(t.iter().any(within), "{what}");
                }
                let (last, parts) = (count - 1, control_points - 1);
                let nearest = |k: usize| t[(2 * k * last + parts) / (2 * parts)];
                let chosen: Vec<f64> = (0..control_points).map(nearest).collect();
                let good = check_schoenberg_whitney(&knots, degree, &chosen, Axis::U);
                assert!(good.is_ok(), "{what}");
                let back: Vec<f64> = t.iter().rev().map(|t| -t).collect();
                let largest = t[0].abs().max(t[last]);
                let back = spread(&back, degree, control_points);
                for (a, b) in knots.iter().zip(back.iter().rev()) {
                    assert!((a + b).abs() <= 1e-15 * largest, "{what}");
                }
            }
        }
    }

    /// Knots of least squares for the parameters above.
    #[test]
    fn knots_of_least_squares_follow_their_formulas() {
        // Three spans of five steps, and of six parameters.
        let interior = |knots: Vec<f64>| knots[2..4].to_vec();
        let expected = [1.0 + 2.0 * (2.0 / 3.0), 4.0 + 2.0 / 3.0];
        for (knot, expected) in interior(spread(&T, 1, 4)).iter().zip(expected) {
            assert!((knot - expected).abs() < 1e-15);
        }
        assert_eq!(interior(piegl_tiller(&T, 1, 4)), [1.0, 4.0]);
    }
}
