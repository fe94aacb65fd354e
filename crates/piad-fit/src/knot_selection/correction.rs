//! Parameters that move to the foot points of their data (Hoschek 1988).
//!
//! ```text
//! t_i ← t_i + (P_i − C(t_i)) · C'(t_i) / ‖C'(t_i)‖²
//! ```
//!
//! After it the distance of a datum is nearly that to the curve, and the next fit has no reason to
//! bend to a parameter that was only guessed. Parameters stay increasing: none goes more than a part
//! of the way to its neighbours. The first one stays, and on open curves the last one.

use super::breaks::Breaks;
use super::values::Values;
use crate::data::points::Points;

/// How far a parameter may go towards a neighbour.
const PART: f64 = 0.4;

/// The parameters after one step.
pub(crate) fn corrected(values: &Values, control_points: &Points, points: &Points) -> Vec<f64> {
    let (line, t) = (values.line(), values.parameters());
    let Some(lower) = Breaks::new(line.degree() - 1, line.is_closed(), line.breaks().to_vec())
    else {
        return t.to_vec();
    };
    let slopes = Values::new(&lower, t);
    let (mut along, mut square) = (vec![0.0; t.len()], vec![0.0; t.len()]);
    let mut fit = Points::zeros(points.dimension(), t.len());
    values.apply(control_points.lanes(), fit.lanes_mut());
    let derivatives = control_points.lanes().iter();
    let derivatives: Vec<Vec<f64>> = derivatives.map(|x| derivative(line, &lower, x)).collect();
    let mut slope = Points::zeros(points.dimension(), t.len());
    slopes.apply(&derivatives, slope.lanes_mut());
    for (c, data) in points.lanes().iter().enumerate() {
        let (fit, slope) = (fit.lane(c), slope.lane(c));
        for i in 0..t.len() {
            along[i] += (data[i] - fit[i]) * slope[i];
            square[i] += slope[i] * slope[i];
        }
    }
    let end = line.breaks()[line.spans()];
    let last = if line.is_closed() {
        t.len()
    } else {
        t.len() - 1
    };
    let mut moved = t.to_vec();
    for i in 1..last {
        let step = along[i] / square[i];
        if step.is_finite() {
            let next = t.get(i + 1).copied().unwrap_or(end);
            let back = PART * (t[i - 1] - t[i]);
            moved[i] = t[i] + step.clamp(back, PART * (next - t[i]));
        }
    }
    moved
}

/// The control points of the derivative of one coordinate, over the same breaks.
pub(super) fn derivative(line: &Breaks, lower: &Breaks, x: &[f64]) -> Vec<f64> {
    let degree = line.degree();
    (0..lower.control_points())
        .map(|j| {
            let width = line.knot((j + 1 + degree) as isize) - line.knot(j as isize + 1);
            let (from, to) = (line.control_point(j), line.control_point(j + 1));
            degree as f64 * (x[to] - x[from]) / width
        })
        .collect()
}
