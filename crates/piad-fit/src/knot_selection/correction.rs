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
    let Some((lower, derivative)) = derivative(line, control_points) else {
        return t.to_vec();
    };
    let (mut along, mut square) = (vec![0.0; t.len()], vec![0.0; t.len()]);
    let residual = values.residual(control_points, points);
    let slope = Values::new(&lower, t).points(&derivative);
    for (left, slope) in residual.lanes().iter().zip(slope.lanes()) {
        for i in 0..t.len() {
            along[i] += left[i] * slope[i];
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

/// The derivative of curves: its knots, at the same breaks, and its control points.
pub(super) fn derivative(line: &Breaks, control_points: &Points) -> Option<(Breaks, Points)> {
    let degree = line.degree();
    let (breaks, closed) = (line.breaks().to_vec(), line.is_closed());
    let lower = Breaks::new(degree.checked_sub(1)?, closed, breaks)?;
    let of_lane = |x: &[f64]| {
        let difference = |j: usize| {
            let width = line.knot((j + 1 + degree) as isize) - line.knot(j as isize + 1);
            let (from, to) = (line.control_point(j), line.control_point(j + 1));
            degree as f64 * (x[to] - x[from]) / width
        };
        let differences = (0..lower.control_points()).map(difference);
        differences.collect::<Vec<f64>>()
    };
    let lanes = control_points.lanes().iter();
    let derivative = Points::from_lanes(lanes.map(|lane| of_lane(lane)));
    Some((lower, derivative))
}
