//! Parameters of scattered points that move to the foot points of their data: a step of Gauss and Newton in both directions.
//!
//! ```text
//! (u, v) ← (u, v) + (JᵀJ + λ diag JᵀJ)⁻¹ Jᵀ (P − S(u, v)),   J = (S_u, S_v)
//! ```
//!
//! After it the distance of a datum is nearly that from the surface (Hoschek 1988). No parameter moves further than
//! half of its knot span, nor beyond the ends of an open direction; a closed one wraps around.

use std::ops::Deref;
use std::sync::Arc;

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
    let fit = values(sites, &level.lines, level.control_points.lanes());
    let [u, v] = &level.lines;
    let [along_u, along_v] = [0, 1].map(|axis| {
        let line = &level.lines[axis];
        let lower = Breaks::new(
            line.degree().checked_sub(1)?,
            line.is_closed(),
            line.breaks().to_vec(),
        )?;
        let nets = level
            .control_points
            .lanes()
            .iter()
            .map(|net| slopes(net, &level.lines, &lower, axis));
        let nets: Vec<Vec<f64>> = nets.collect();
        let lines = match axis {
            0 => [lower, v.clone()],
            _ => [u.clone(), lower],
        };
        Some(values(sites, &lines, &nets))
    });
    let (along_u, along_v) = (along_u?, along_v?);
    let moved: Vec<[f64; 2]> = (0..points.len())
        .map(|i| {
            let at = |lanes: &[Vec<f64>]| lanes.iter().map(|lane| lane[i]).collect::<Vec<_>>();
            let left = points
                .point(i)
                .zip(at(&fit))
                .map(|(datum, fit)| datum - fit);
            let step = step(&left.collect::<Vec<_>>(), &at(&along_u), &at(&along_v));
            [0, 1].map(|axis| {
                let t = sites.parameters[axis][sites.places[axis][i] as usize];
                moved(&level.lines[axis], t, step[axis])
            })
        })
        .collect();
    Some([0, 1].map(|axis| moved.iter().map(|pair| pair[axis]).collect()))
}

/// The values of a net at all sites, coordinate by coordinate.
fn values<L: Deref<Target = [f64]>>(
    sites: &Sites,
    lines: &[Breaks; 2],
    nets: &[L],
) -> Vec<Vec<f64>> {
    let rows = Rows::new(sites, lines).without_poles();
    let apply = |net: &L| {
        let mut values = vec![0.0; rows.points()];
        rows.apply(net, &mut values);
        values
    };
    nets.iter().map(apply).collect()
}

/// The net of a derivative of one coordinate.
fn slopes(net: &[f64], lines: &[Breaks; 2], lower: &Breaks, axis: usize) -> Vec<f64> {
    let columns = lines[1].control_points();
    if axis == 1 {
        let rows = net.chunks(columns);
        return rows
            .flat_map(|row| derivative(&lines[1], lower, row))
            .collect();
    }
    let mut slopes = vec![0.0; lower.control_points() * columns];
    for column in 0..columns {
        let curve: Vec<f64> = net.iter().skip(column).step_by(columns).copied().collect();
        let places = slopes.iter_mut().skip(column).step_by(columns);
        let values = derivative(&lines[0], lower, &curve);
        places.zip(values).for_each(|(place, value)| *place = value);
    }
    slopes
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

/// Parameters of sorted points in the order in which these were given.
pub(super) fn in_order(sorted: [Vec<f64>; 2], order: &[u32]) -> [Arc<Vec<f64>>; 2] {
    sorted.map(|sorted| {
        let mut given = vec![0.0; sorted.len()];
        for (&index, t) in order.iter().zip(sorted) {
            given[index as usize] = t;
        }
        Arc::new(given)
    })
}
