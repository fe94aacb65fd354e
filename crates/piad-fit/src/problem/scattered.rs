//! Directions of scattered points. The surface has fewer control points than there are points, so that only least
//! squares fits it.

use std::sync::Arc;

use super::construction::check_degree;
use crate::basis::Basis;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::direction::Direction;
use crate::basis::given_knots;
use crate::basis::knots::{self, Knots};
use crate::invalid::{Axis, Invalid, Place};

impl Direction {
    /// A direction of scattered points with these parameters, which are in the order of the points.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with the number of control points, the degree or the knots.
    pub(crate) fn scattered(
        choice: &DirectionChoice,
        (mut parameters, free): (Vec<f64>, usize),
        axis: Axis,
    ) -> Result<Self, Invalid> {
        let mut sorted = parameters.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let count = sorted.len();
        if choice.closed {
            return Err(Invalid::at(
                Place::Closed(axis),
                "scattered points are fitted by open surfaces only",
            ));
        }
        if choice.ends.is_some() {
            let found = "least squares has ends of its own";
            return Err(Invalid::no_ends(axis, found));
        }
        let basis = match &choice.basis {
            BasisChoice::Polynomial(kind) => {
                let degree = free - 1;
                check_degree(degree, false, axis)?;
                let (low, length) = (sorted[0], sorted[count - 1] - sorted[0]);
                for t in &mut parameters {
                    *t = ((*t - low) / length).clamp(0.0, 1.0);
                }
                Basis::Polynomial {
                    kind: *kind,
                    degree,
                }
            }
            BasisChoice::BSpline { degree, knots } => {
                check_degree(*degree, true, axis)?;
                let degree = *degree;
                if degree >= free {
                    return Err(Invalid::too_few_control_points(axis, free, degree));
                }
                let knots = knots_of(knots, degree, free, (&parameters, &sorted), axis)?;
                Basis::BSpline { degree, knots }
            }
        };
        Ok(Self::open(basis, Arc::new(parameters), free, 0))
    }
}

/// The knots of a direction: spread over the parameters that differ, or given ones.
fn knots_of(
    choice: &Knots,
    degree: usize,
    free: usize,
    (parameters, sorted): (&[f64], &[f64]),
    axis: Axis,
) -> Result<Arc<Vec<f64>>, Invalid> {
    let count = sorted.len();
    match choice {
        Knots::Usual | Knots::Spread if free > count => Err(Invalid::at(
            Place::ControlPoints(axis),
            format!(
                "{free} control points for {count} different parameters: give the knots as numbers, or fewer control points"
            ),
        )),
        Knots::Usual | Knots::Spread => Ok(Arc::new(knots::spread(sorted, degree, free))),
        Knots::Data | Knots::Averaged | Knots::Adaptive => Err(Invalid::at(
            Place::Knots(axis),
            "the knots of scattered points are \"spread\" over their parameters, or numbers",
        )),
        Knots::Explicit(knots) => {
            given_knots::check(knots, degree, free, axis)?;
            let (low, high) = (knots[0], knots[knots.len() - 1]);
            match parameters.iter().position(|t| !(low..=high).contains(t)) {
                Some(index) => Err(Invalid::parameter_outside(
                    axis,
                    index,
                    parameters[index],
                    (low, high),
                )),
                None => Ok(Arc::clone(knots)),
            }
        }
    }
}
