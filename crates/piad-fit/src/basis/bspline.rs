//! B-splines by the Cox–de Boor recurrence.
//!
//! With knots u_0 ≤ u_1 ≤ …:
//!
//! ```text
//! N_i,0(t) = 1 if u_i ≤ t < u_{i+1}, else 0
//! N_i,r(t) = (t − u_i)/(u_{i+r} − u_i) N_i,r−1(t) + (u_{i+r+1} − t)/(u_{i+r+1} − u_{i+1}) N_{i+1,r−1}(t)
//! ```
//!
//! At a parameter in the span [u_s, u_{s+1}) the p + 1 functions N_{s−p,p} … N_s,p differ from
//! zero. They are computed together, degree by degree, in `3/2 p (p + 1)` divisions and
//! multiplications (the triangular scheme, PT97, algorithm A2.2), for example of degree 2:
//!
//! ```text
//! N_s,0 ──► N_s−1,1 ──► N_s−2,2
//!      ╲──► N_s,1   ──► N_s−1,2
//!                  ╲──► N_s,2
//! ```
//!
//! All terms are sums of nonnegative numbers, so that nothing cancels: each value is accurate to a few times p rounding
//! errors.

use crate::kind_info::KindInfo;

/// The entry in the table of bases.
pub(super) const INFO: KindInfo = KindInfo {
    name: "bspline",
    title: "B-splines",
    summary: "Piecewise polynomials of a degree of one's choice with local support, open or closed.",
    source: "LBW05 (3.1)–(3.2), LWD04 (1)–(2)",
};

/// The knot span that holds `t`: `knots[span] ≤ t < knots[span + 1]`, at the right end of the
/// domain the last span that is not empty (PT97, algorithm A2.1). Bisection, O(log n).
pub fn find_span(degree: usize, knots: &[f64], t: f64) -> usize {
    let last = knots.len() - degree - 2;
    let inside = &knots[degree + 1..=last];
    // Interior knots only: what lies beyond the ends falls into the first or last span.
    let end = knots[last + 1];
    if t >= end {
        return degree + inside.partition_point(|&knot| knot < end);
    }
    degree + inside.partition_point(|&knot| knot <= t)
}

/// Writes the values at `t` of the `degree + 1` B-splines that differ from zero on the span,
/// `N_{span − degree} … N_{span}`, into `values` (PT97, algorithm A2.2).
///
/// The weights of the recurrence are formed as quotients of differences, so that knots of any
/// magnitude are treated alike.
pub fn evaluate(degree: usize, knots: &[f64], span: usize, t: f64, values: &mut [f64]) {
    values[0] = 1.0;
    (1..=degree).for_each(|r| raise(r, knots, span, t, values));
}

/// The same, with the values of degree `degree − 1`, which derivatives need, in `lower`.
pub(crate) fn evaluate_with_lower(
    degree: usize,
    knots: &[f64],
    span: usize,
    t: f64,
    values: &mut [f64],
    lower: &mut [f64],
) {
    let Some(below) = degree.checked_sub(1) else {
        return evaluate(degree, knots, span, t, values);
    };
    evaluate(below, knots, span, t, values);
    lower.copy_from_slice(&values[..degree]);
    raise(degree, knots, span, t, values);
}

/// Makes the values of degree `r` from those of degree `r − 1`.
fn raise(r: usize, knots: &[f64], span: usize, t: f64, values: &mut [f64]) {
    let mut carried = 0.0;
    for j in 0..r {
        let right = knots[span + 1 + j] - t;
        let left = t - knots[span + 1 + j - r];
        let width = right + left;
        let lower = values[j];
        values[j] = carried + right / width * lower;
        carried = left / width * lower;
    }
    values[r] = carried;
}

/// The most parameters of a run: 2 KiB for each function, which stay in the nearest cache.
pub(crate) const BLOCK: usize = 256;

/// Writes the values at each `t_i` of the p + 1 B-splines that differ from zero on span
/// `degree + i` of the given knots: those of function `i + k` to place i of lane k, k = 0 … p. The
/// same numbers as [`evaluate`] computes, for as many parameters at a time as the processor can; at
/// most [`BLOCK`] parameters.
pub(crate) fn evaluate_run(degree: usize, knots: &[f64], t: &[f64], values: &mut [&mut [f64]]) {
    pulp::Arch::new().dispatch(EvaluateRun {
        degree,
        knots,
        t,
        values,
    });
}

/// The same, compiled for several instruction sets.
struct EvaluateRun<'a, 'b> {
    degree: usize,
    knots: &'a [f64],
    t: &'a [f64],
    values: &'a mut [&'b mut [f64]],
}

impl pulp::NullaryFnOnce for EvaluateRun<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            degree,
            knots,
            t,
            values,
        } = self;
        let mut carried = [0.0; BLOCK];
        let carried = &mut carried[..t.len()];
        values[0].fill(1.0);
        for r in 1..=degree {
            carried.fill(0.0);
            for j in 0..r {
                let right = &knots[degree + 1 + j..];
                let left = &knots[degree + 1 + j - r..];
                recur(right, left, t, values[j], carried);
            }
            values[r].copy_from_slice(carried);
        }
    }
}

/// One step of the triangular scheme for many parameters: from N_{j,r−1} in `values` and what its
/// left neighbour has carried on to N_{j,r}, and what it carries on itself.
#[inline(always)]
fn recur(right: &[f64], left: &[f64], t: &[f64], values: &mut [f64], carried: &mut [f64]) {
    let n = t.len();
    let (right, left) = (&right[..n], &left[..n]);
    let (values, carried) = (&mut values[..n], &mut carried[..n]);
    for i in 0..n {
        let right = right[i] - t[i];
        let left = t[i] - left[i];
        let width = right + left;
        let lower = values[i];
        values[i] = carried[i] + right / width * lower;
        carried[i] = left / width * lower;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of all functions at a parameter.
    fn row(degree: usize, knots: &[f64], t: f64) -> Vec<f64> {
        let span = find_span(degree, knots, t);
        let mut local = vec![0.0; degree + 1];
        evaluate(degree, knots, span, t, &mut local);
        let mut all = vec![0.0; knots.len() - degree - 1];
        all[span - degree..=span].copy_from_slice(&local);
        all
    }

    const QUADRATIC: [f64; 8] = [0.0, 0.0, 0.0, 1.0, 2.5, 3.0, 3.0, 3.0];
    const CUBIC: [f64; 12] = [0.0, 0.0, 0.0, 0.0, 0.3, 0.5, 0.5, 1.2, 2.0, 2.0, 2.0, 2.0];
    const QUINTIC: [f64; 14] = [
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.7, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
    ];

    /// Values of `scipy.interpolate.BSpline.design_matrix` (scipy 1.17.1).
    #[test]
    fn values_equal_scipy() {
        let cases: [(usize, &[f64], f64, &[f64]); 4] = [
            (2, &QUADRATIC, 2.75, &[0.0, 0.0, 0.0625, 0.6875, 0.25]),
            (
                3,
                &CUBIC,
                0.4,
                &[
                    0.0,
                    0.02,
                    0.21,
                    0.742_222_222_222_222_3,
                    0.027_777_777_777_777_81,
                ],
            ),
            (
                3,
                &CUBIC,
                0.5,
                &[
                    0.0,
                    0.0,
                    0.0,
                    0.777_777_777_777_777_8,
                    0.222_222_222_222_222_24,
                ],
            ),
            (
                5,
                &QUINTIC,
                0.31,
                &[
                    0.0,
                    0.075_155_517_700_957_92,
                    0.401_161_336_413_473_57,
                    0.364_955_180_764_395_04,
                    0.138_593_124_284_119_9,
                    0.020_056_202_653_459_827,
                    7.863_818_359_374_995e-5,
                ],
            ),
        ];
        for (degree, knots, t, expected) in cases {
            let values = row(degree, knots, t);
            for (j, value) in values.iter().enumerate() {
                let expected = expected.get(j).copied().unwrap_or(0.0);
                assert!(
                    (value - expected).abs() < 1e-15,
                    "degree {degree}, t = {t}, {j}"
                );
            }
        }
    }

    /// Every degree up to 12, with knots that are close together.
    #[test]
    fn functions_sum_to_one_and_are_positive() {
        for degree in 1..=12 {
            let mut knots = vec![-1.0; degree + 1];
            knots.extend([-0.5, 0.1, 0.1001, 0.7]);
            knots.resize(knots.len() + degree + 1, 3.0);
            for step in 0..=400 {
                let t = -1.0 + f64::from(step) / 100.0;
                let values = row(degree, &knots, t);
                assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                assert!(values.iter().all(|&value| value >= 0.0));
            }
        }
    }

    /// The vectorized evaluation computes the same numbers as that of single parameters, to the
    /// last bit.
    #[test]
    fn runs_are_made_of_single_parameters() {
        for degree in 1..=7 {
            let knots: Vec<f64> = (0..120)
                .map(|i| f64::from(i) + 0.4 * f64::from(i * i).sin())
                .collect();
            let t: Vec<f64> = knots[degree..knots.len() - degree - 1]
                .iter()
                .enumerate()
                .map(|(i, knot)| if i % 3 == 0 { *knot } else { knot + 0.1 })
                .collect();
            let mut lanes = vec![vec![0.0; t.len()]; degree + 1];
            let mut values: Vec<&mut [f64]> = lanes.iter_mut().map(Vec::as_mut_slice).collect();
            evaluate_run(degree, &knots, &t, &mut values);
            for (i, &t) in t.iter().enumerate() {
                let mut single = vec![0.0; degree + 1];
                evaluate(degree, &knots, degree + i, t, &mut single);
                let run: Vec<f64> = lanes.iter().map(|lane| lane[i]).collect();
                assert_eq!(run, single, "degree {degree}, {i}");
            }
        }
    }

    /// At the last knot the basis is continuous from the left.
    #[test]
    fn the_right_end_belongs_to_the_last_span() {
        let knots = [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0];
        assert_eq!(row(2, &knots, 2.0), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(row(2, &knots, 0.0), [1.0, 0.0, 0.0, 0.0]);
    }
}
