//! Converts control points of the Ball bases to Bézier points of the same degree.
//!
//! CAD kernels know B-splines, which include the Bernstein polynomials, but not the Ball bases.
//! Each Ball function is a multiple of some `t^a (1−t)^b` with `a + b ≤ m`, and with `1 = (t +
//! (1−t))^(m−a−b)`, expanded by the binomial theorem,
//!
//! ```text
//! t^a (1−t)^b = Σ_k C(m−a−b, k−a) / C(m, k) · B_k(t),   k = a … m−b
//! ```
//!
//! So control points of a Ball basis become Bézier points by a matrix without negative entries
//! whose rows sum to one: Bézier points are weighted means of Ball points, which is stable at every
//! degree and keeps weights positive.

use super::Polynomial;

/// The matrix that turns control points of a basis into Bézier points, a row for each of these.
#[derive(Clone, Debug)]
pub(crate) struct ToBezier {
    size: usize,
    entries: Vec<f64>,
}

impl ToBezier {
    /// The matrix for the polynomials of this kind and degree; `None` if they are Bernstein's.
    pub(crate) fn new(kind: Polynomial, degree: usize) -> Option<Self> {
        let terms = match kind {
            Polynomial::Bernstein => return None,
            Polynomial::SaidBall => said_ball(degree),
            Polynomial::WangBall => wang_ball(degree),
        };
        let size = degree + 1;
        let mut entries = vec![0.0; size * size];
        let all = binomials(degree);
        for (column, term) in terms.iter().enumerate() {
            let rest = binomials(degree - term.up - term.down);
            for (i, binomial) in rest.iter().enumerate() {
                let row = term.up + i;
                entries[row * size + column] = term.factor * binomial / all[row];
            }
        }
        Some(Self { size, entries })
    }

    /// Converts one line of control values: `size` numbers from `start` on, `step` apart.
    pub(crate) fn convert(&self, values: &mut [f64], start: usize, step: usize) {
        let old: Vec<f64> = (0..self.size).map(|i| values[start + i * step]).collect();
        for (i, row) in self.entries.chunks_exact(self.size).enumerate() {
            values[start + i * step] = row.iter().zip(&old).map(|(a, x)| a * x).sum();
        }
    }
}

/// `factor · t^up (1−t)^down`
#[derive(Clone, Copy, Debug)]
struct Term {
    factor: f64,
    up: usize,
    down: usize,
}

/// The Said–Ball basis as in [`super::ball::said_ball`].
fn said_ball(degree: usize) -> Vec<Term> {
    let half = degree / 2;
    let mut factor = 1.0;
    let left = (0..degree.div_ceil(2)).map(|i| {
        let term = Term {
            factor,
            up: i,
            down: half + 1,
        };
        // C(f+i, i), an integer at every step.
        factor = factor * (half + i + 1) as f64 / (i + 1) as f64;
        term
    });
    let left: Vec<Term> = left.collect();
    let middle = degree.is_multiple_of(2).then(|| Term {
        factor: binomials(degree)[half],
        up: half,
        down: half,
    });
    mirrored(left, middle)
}

/// The Wang–Ball basis as in [`super::ball::wang_ball`].
fn wang_ball(degree: usize) -> Vec<Term> {
    let half = degree / 2;
    let power = |i: usize| (0..i).fold(1.0, |product, _| 2.0 * product);
    let term = |i: usize, down: usize| Term {
        factor: power(i),
        up: i,
        down,
    };
    let mut left: Vec<Term> = (0..half).map(|i| term(i, i + 2)).collect();
    if degree.is_multiple_of(2) {
        return mirrored(left, Some(term(half, half)));
    }
    left.push(term(half, half + 1));
    mirrored(left, None)
}

/// Both halves of a symmetric basis.
fn mirrored(left: Vec<Term>, middle: Option<Term>) -> Vec<Term> {
    let right = left.iter().rev().map(|term| Term {
        factor: term.factor,
        up: term.down,
        down: term.up,
    });
    let right: Vec<Term> = right.collect();
    left.into_iter().chain(middle).chain(right).collect()
}

/// `C(n, 0) … C(n, n)`: exact up to n = 56, finite up to n = 1029.
fn binomials(n: usize) -> Vec<f64> {
    let mut value = 1.0;
    let mut row = vec![value];
    for k in 0..n {
        // Multiplied before it is divided, every value is an integer, exact up to 2^53.
        value = value * (n - k) as f64 / (k + 1) as f64;
        row.push(value);
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::{ball, bernstein};

    /// The functions of a degree at a parameter.
    type Evaluate = fn(usize, f64, &mut [f64]);

    const KINDS: [(Polynomial, Evaluate); 2] = [
        (Polynomial::SaidBall, ball::said_ball),
        (Polynomial::WangBall, ball::wang_ball),
    ];

    /// The curve of some control values in both bases.
    fn difference(kind: Polynomial, basis: Evaluate, degree: usize) -> f64 {
        let ball: Vec<f64> = (0..=degree).map(|i| ((i * i) as f64).sin()).collect();
        let mut bezier = ball.clone();
        let matrix = ToBezier::new(kind, degree).unwrap();
        matrix.convert(&mut bezier, 0, 1);
        let mut values = vec![0.0; degree + 1];
        let sum = |values: &[f64], points: &[f64]| -> f64 {
            values.iter().zip(points).map(|(b, x)| b * x).sum()
        };
        let mut largest = 0.0_f64;
        for step in 0..=64 {
            let t = f64::from(step) / 64.0;
            basis(degree, t, &mut values);
            let expected = sum(&values, &ball);
            bernstein::evaluate(degree, t, &mut values);
            largest = largest.max((sum(&values, &bezier) - expected).abs());
        }
        largest
    }

    fn assert_close(values: &[f64], expected: &[f64]) {
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() <= 1e-15 * expected, "{values:?}");
        }
    }

    #[test]
    fn both_bases_have_the_same_curve() {
        for (kind, basis) in KINDS {
            for degree in (1..=12).chain([29, 30, 57, 100, 101]) {
                let difference = difference(kind, basis, degree);
                assert!(difference < 4e-15, "{kind:?} {degree}: {difference:e}");
            }
            for degree in [999, 1000] {
                let difference = difference(kind, basis, degree);
                assert!(difference < 1e-12, "{kind:?} {degree}: {difference:e}");
            }
        }
    }

    /// B_1 = 3 t (1−t)², of which the second Ball function is two thirds; the rest of it comes from
    /// the first, (1−t)² = B_0 + B_1 / 3.
    #[test]
    fn cubic_ball_points_become_bezier_points() {
        for (kind, _) in KINDS {
            let mut line = [1.0, 2.0, 4.0, 8.0];
            ToBezier::new(kind, 3).unwrap().convert(&mut line, 0, 1);
            assert_close(&line, &[1.0, 5.0 / 3.0, 16.0 / 3.0, 8.0]);
        }
    }

    #[test]
    fn entries_are_weights_of_means() {
        for (kind, _) in KINDS {
            for degree in [4, 7, 500, 1000] {
                let matrix = ToBezier::new(kind, degree).unwrap();
                for row in matrix.entries.chunks_exact(degree + 1) {
                    assert!(row.iter().all(|x| (0.0..=1.0 + 1e-12).contains(x)));
                    assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn lines_with_steps_are_columns() {
        let matrix = ToBezier::new(Polynomial::SaidBall, 3).unwrap();
        let mut net = [0.0, 1.0, 0.0, 2.0, 0.0, 4.0, 0.0, 8.0];
        matrix.convert(&mut net, 1, 2);
        assert_close(&net, &[0.0, 1.0, 0.0, 5.0 / 3.0, 0.0, 16.0 / 3.0, 0.0, 8.0]);
    }

    #[test]
    fn bernstein_polynomials_stay() {
        assert!(ToBezier::new(Polynomial::Bernstein, 5).is_none());
    }
}
