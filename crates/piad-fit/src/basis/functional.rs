//! Values and derivatives at a parameter as sums over free control points.
//!
//! ```text
//! C^(r)(t) = Σ_j f_j X_j,   f_j = B_j^(r)(t)
//! ```
//!
//! The derivative of a B-spline of degree q is a difference of two of degree q − 1 (PT97 (2.7)), so
//! that the functions of degree p − r at t are raised r times:
//!
//! ```text
//! f_i ← q (f_i / (u_{i+q} − u_i) − f_{i+1} / (u_{i+q+1} − u_{i+1})),   q = p − r + 1 … p
//! ```
//!
//! With weights, R = N/W, derivatives follow from those of N and W (PT97 (4.8)).

use super::direction::Direction;
use super::{Basis, bspline};

impl Direction {
    /// The free control points on which the derivative of this order at `t`, in the domain of the
    /// basis, depends, and their factors; order 0 is the value. `None` for a derivative of a basis
    /// without knots. At a knot with a jump it is the derivative from the right.
    pub(crate) fn functional(&self, t: f64, order: usize) -> Option<Vec<(usize, f64)>> {
        let t = self.within(t);
        let mut lists = vec![vec![0.0; self.basis.support_width()]; order + 1];
        let mut start = 0;
        for (order, values) in lists.iter_mut().enumerate() {
            start = derivatives(&self.basis, t, order, values)?;
        }
        if let Some(weights) = self.weights() {
            weigh(&weights[start..], &mut lists);
        }
        let values = lists.last_mut()?;
        self.share(start, values);
        let mut factors: Vec<(usize, f64)> = Vec::new();
        for (k, &value) in values.iter().enumerate() {
            let index = self.free_index(start + k);
            match factors.iter_mut().find(|(other, _)| *other == index) {
                Some((_, factor)) => *factor += value,
                None => factors.push((index, value)),
            }
        }
        factors.retain(|(_, factor)| *factor != 0.0);
        Some(factors)
    }
}

/// Writes the derivatives of the functions that can differ from zero at `t`, and returns the index
/// of the first of them.
fn derivatives(basis: &Basis, t: f64, order: usize, values: &mut [f64]) -> Option<usize> {
    if order == 0 {
        return Some(basis.evaluate(t, values));
    }
    let (degree, knots) = (basis.degree(), basis.knots()?);
    let span = bspline::find_span(degree, &knots, t);
    values.fill(0.0);
    if let Some(low) = degree.checked_sub(order) {
        // Functions span − q … span of degree q stand in the last q + 1 places.
        bspline::evaluate(low, &knots, span, t, &mut values[order..]);
        for q in low + 1..=degree {
            raise(q, &knots, span, &mut values[degree - q..]);
        }
    }
    Some(span - degree)
}

/// From factors of the functions of degree q − 1 to those of the functions of degree q, span − q …
/// span. The first has no factor yet.
fn raise(q: usize, knots: &[f64], span: usize, values: &mut [f64]) {
    // The factor of function i of degree q − 1, over the length of its support.
    let quotient = |i: usize, factor: f64| q as f64 * factor / (knots[i + q] - knots[i]);
    for k in 0..=q {
        let i = span - q + k;
        let own = if k == 0 { 0.0 } else { quotient(i, values[k]) };
        let next = if k == q {
            0.0
        } else {
            quotient(i + 1, values[k + 1])
        };
        values[k] = own - next;
    }
}

/// The derivatives of `R_j = w_j B_j / W` of all orders, from those of the `B_j`.
fn weigh(weights: &[f64], lists: &mut [Vec<f64>]) {
    for values in lists.iter_mut() {
        for (value, weight) in values.iter_mut().zip(weights) {
            *value *= weight;
        }
    }
    let sums: Vec<f64> = lists.iter().map(|values| values.iter().sum()).collect();
    for order in 0..lists.len() {
        let (lower, rest) = lists.split_at_mut(order);
        let Some(values) = rest.first_mut() else {
            return;
        };
        let mut binomial = 1.0;
        for k in 1..=order {
            binomial *= (order + 1 - k) as f64 / k as f64;
            let factor = binomial * sums[k];
            for (value, below) in values.iter_mut().zip(&lower[order - k]) {
                *value -= factor * below;
            }
        }
        values.iter_mut().for_each(|value| *value /= sums[0]);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::invalid::Axis;

    /// A direction of six control points of degree 4 with unequal knots.
    fn direction() -> Direction {
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0, 1.0, 1.0, 1.0];
        let basis = Basis::BSpline {
            degree: 4,
            knots: knots.into(),
        };
        Direction::open(basis, Arc::new(vec![0.0, 1.0]), 6, 0)
    }

    fn sum(direction: &Direction, t: f64, order: usize) -> f64 {
        let x = |j: usize| (1.0 + j as f64).powi(3).sin();
        let factors = direction.functional(t, order).unwrap();
        factors.iter().map(|&(j, factor)| factor * x(j)).sum()
    }

    /// A derivative is the limit of differences of the one below it; for cubics and h = 1e-4 they
    /// are accurate to better than 1e-3.
    #[test]
    fn derivatives_equal_quotients_of_differences() {
        for weights in [None, Some(vec![1.0, 2.0, 0.5, 3.0, 1.0, 4.0])] {
            let mut direction = direction();
            if let Some(weights) = weights {
                direction = direction.with_weights(weights, Axis::U).unwrap();
            }
            for t in [0.1, 0.25, 0.5, 0.9] {
                for order in 1..=4 {
                    let h = 1e-4;
                    let [above, below] = [h, -h].map(|h| sum(&direction, t + h, order - 1));
                    let quotient = (above - below) / (2.0 * h);
                    let value = sum(&direction, t, order);
                    assert!((value - quotient).abs() < 1e-3 * value.abs().max(1.0));
                }
            }
        }
    }

    /// A polynomial of degree 4 has no fifth derivative.
    #[test]
    fn derivatives_above_the_degree_are_zero() {
        assert_eq!(direction().functional(0.5, 5), Some(Vec::new()));
    }
}
