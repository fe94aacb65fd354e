//! Parameters of scattered points that move to the foot points of their data: a step of Gauss and Newton in both directions.
//!
//! ```text
//! (u, v) ← (u, v) + (JᵀJ + λ diag JᵀJ)⁻¹ Jᵀ (P − S(u, v)),   J = (S_u, S_v)
//! ```
//!
//! After it the distance of a datum is nearly that from the surface (Hoschek 1988). No parameter moves further than
//! half of its knot span, nor beyond the ends of an open direction; a closed one wraps around.

use super::lines::{curves, joined};
use super::rows::{Rows, Sites};
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::correction::derivative;
use crate::knot_selection::levels::Level;

/// λ, so that a step is finite where one derivative vanishes, as at a pole.
const DAMPING: f64 = 1e-6;

/// The largest move of a parameter, as a part of the mean length of the spans.
const PART: f64 = 0.5;

/// The parameters of sorted points after one step, u and v of each; `None` for degrees without derivatives.
pub(super) fn corrected(sites: &Sites, points: &Points, level: &Level<2>) -> Option<[Vec<f64>; 2]> {
    let fit = values(sites, &level.lines, &level.control_points);
    let [along_u, along_v] = [0, 1].map(|axis| slopes(sites, level, axis));
    let (along_u, along_v) = (along_u?, along_v?);
    let moved = (0..points.len()).map(|i| {
        let at = |points: &Points| points.point(i).collect::<Vec<f64>>();
        let left = points.point(i).zip(fit.point(i));
        let left: Vec<f64> = left.map(|(datum, fit)| datum - fit).collect();
        let step = step(&left, &at(&along_u), &at(&along_v));
        [0, 1].map(|axis| {
            let t = sites.parameters[axis][sites.places[axis][i] as usize];
            moved(&level.lines[axis], t, step[axis])
        })
    });
    let moved: Vec<[f64; 2]> = moved.collect();
    Some([0, 1].map(|axis| moved.iter().map(|pair| pair[axis]).collect()))
}

/// The derivative in a direction at all sites.
fn slopes(sites: &Sites, level: &Level<2>, axis: usize) -> Option<Points> {
    let (net, mut lines) = (&level.control_points, level.lines.clone());
    let (lower, slopes) = derivative(&lines[axis], &curves(net, level.counts(), axis))?;
    lines[axis] = lower;
    let net = joined(&slopes, net.dimension(), axis);
    Some(values(sites, &lines, &net))
}

/// The values of a net at all sites.
fn values(sites: &Sites, lines: &[Breaks; 2], net: &Points) -> Points {
    let rows = Rows::new(sites, lines).without_poles();
    let mut values = Points::zeros(net.dimension(), rows.points());
    for (net, values) in net.lanes().iter().zip(values.lanes_mut()) {
        rows.apply(net, values);
    }
    values
}

/// The step of a point in u and v.
fn step(left: &[f64], along_u: &[f64], along_v: &[f64]) -> [f64; 2] {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let damped = |square: f64| square * (1.0 + DAMPING);
    let (a, b, c) = (
        damped(dot(along_u, along_u)),
        dot(along_u, along_v),
        damped(dot(along_v, along_v)),
    );
    let (p, q) = (dot(along_u, left), dot(along_v, left));
    let determinant = a * c - b * b;
    let step = [(c * p - b * q) / determinant, (a * q - b * p) / determinant];
    step.map(|step| if step.is_finite() { step } else { 0.0 })
}

/// A parameter after a step.
fn moved(line: &Breaks, t: f64, step: f64) -> f64 {
    let (low, high) = (line.breaks()[0], line.breaks()[line.spans()]);
    let most = PART * (high - low) / line.spans() as f64;
    let moved = t + step.clamp(-most, most);
    if !line.is_closed() {
        return moved.clamp(low, high);
    }
    let period = high - low;
    match moved {
        moved if moved < low => (moved + period).min(high),
        moved if moved >= high => (moved - period).max(low),
        moved => moved,
    }
}
