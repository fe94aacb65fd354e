//! The schedule of a fit with outliers or missing points: that of the others, as if they were alone.

use std::sync::Arc;

use super::pieces::Piece;
use super::schedules::{Fit, Levels};
use crate::problem::{Inliers, Problem};
use crate::termination::Outcome;

/// The fit of the inliers.
#[derive(Debug)]
pub(super) struct Alone {
    fit: Box<dyn Piece>,
    inliers: Arc<Inliers>,
    has_begun: bool,
}

impl Alone {
    pub(super) fn new(fit: Box<dyn Piece>, inliers: Arc<Inliers>) -> Self {
        Self {
            fit,
            inliers,
            has_begun: false,
        }
    }

    /// The same curve or surface as one of all points.
    fn of_all(&self, whole: &Arc<Problem>) -> Option<Fit> {
        let (problem, control_points) = (self.fit.problem(), self.fit.control_points());
        let is_grid = whole.v().is_some() && !whole.is_scattered();
        let pairs = problem.directions().zip(whole.directions());
        let of_all = pairs.map(|(it, all)| match is_grid {
            true => it.with_parameters(all.parameters.to_vec()),
            false => self.inliers.with_outliers(it, problem.v().is_some()),
        });
        let mut directions: Vec<_> = of_all.collect();
        let mut points = control_points.clone();
        if let [u] = &mut directions[..] {
            // The control points of a closed curve are counted from its first datum on.
            let breaks = problem.breaks()?;
            let of_all = whole.with_breaks(u, breaks.first()?, Arc::clone(&u.parameters))?;
            for j in 0..u.basis.functions() {
                let from = control_points.point(u.free_index(j));
                points.set(of_all.free_index(j), from);
            }
            *u = of_all;
        }
        let mut error = self.fit.error();
        error.at = self.inliers.indices[error.at];
        Some(Fit {
            problem: Arc::new(whole.with_directions(directions)),
            control_points: Arc::new(points),
            error,
        })
    }
}

impl Levels for Alone {
    fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        if self.has_begun {
            if self.fit.outcome().is_some() {
                return None;
            }
            self.fit.advance();
        }
        self.has_begun = true;
        self.of_all(whole)
    }

    fn outcome(&self) -> Option<Outcome> {
        self.fit.outcome()
    }
}
