//! The fit of all points from that of some, as if these were alone: without outliers or missing points.

use std::sync::Arc;

use super::schedules::Fit;
use crate::problem::{Inliers, Problem};

/// The same curve or surface as one of all points.
pub(super) fn of_all(whole: &Problem, alone: &Fit, inliers: &Inliers) -> Option<Fit> {
    let (problem, control_points) = (&alone.problem, &alone.control_points);
    let is_grid = whole.v().is_some() && !whole.is_scattered();
    let pairs = problem.directions().zip(whole.directions());
    let of_all = pairs.map(|(it, all)| match is_grid {
        true => it.with_parameters(all.parameters.to_vec()),
        false => inliers.with_outliers(it, problem.v().is_some()),
    });
    let mut directions: Vec<_> = of_all.collect();
    let mut points = Arc::clone(control_points);
    if let [u] = &mut directions[..] {
        // The control points of a closed curve are counted from its first datum on.
        let breaks = problem.breaks()?;
        let of_all = whole.with_breaks(u, breaks.first()?, Arc::clone(&u.parameters))?;
        let all = Arc::make_mut(&mut points);
        for j in 0..u.basis.functions() {
            let from = control_points.point(u.free_index(j));
            all.set(of_all.free_index(j), from);
        }
        *u = of_all;
    }
    let mut error = alone.error;
    error.at = inliers.indices[error.at];
    Some(Fit {
        problem: Arc::new(whole.with_directions(directions)),
        control_points: points,
        error,
    })
}
