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
use crate::parameters::Domain;

impl Direction {
    /// A direction of scattered points with these parameters, which are in the order of the points.
    ///
    /// # Errors
    ///
    /// The first error of the number of control points, the degree or the knots.
    pub(crate) fn scattered(
        choice: &DirectionChoice,
        (mut parameters, domain): (Vec<f64>, Domain),
        free: usize,
        axis: Axis,
    ) -> Result<Self, Invalid> {
        let mut sorted = parameters.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let count = sorted.len();
        if choice.ends.is_some() {
            let found = "least squares has ends of its own";
            return Err(Invalid::no_ends(axis, found));
        }
        if let Domain::Closed(period) = domain {
            let (degree, knots) = match &choice.basis {
                BasisChoice::BSpline { degree, knots } => (*degree, knots),
                BasisChoice::Polynomial(_) => {
                    return Err(Invalid::at(
                        Place::Basis(axis),
                        "a closed direction is a periodic B-spline: polynomials cannot be closed",
                    ));
                }
            };
            check_degree(degree, true, axis)?;
            let knots = periodic(knots, degree, free, (&sorted, period), axis)?;
            let basis = Basis::BSpline { degree, knots };
            return Ok(Self::closed(basis, Arc::new(parameters), free, period));
        }
        if let Domain::Between {
            ends: [low, high], ..
        } = domain
        {
            sorted.insert(0, low.min(sorted[0]));
            sorted.push(high.max(sorted[count]));
            sorted.dedup();
        }
        let count = sorted.len();
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

/// The knots of a closed direction, spread over the parameters that differ.
fn periodic(
    choice: &Knots,
    degree: usize,
    free: usize,
    (sorted, period): (&[f64], f64),
    axis: Axis,
) -> Result<Arc<Vec<f64>>, Invalid> {
    let length = sorted[sorted.len() - 1] - sorted[0];
    if !(period.is_finite() && period > length) {
        return Err(Invalid::at(
            Place::Parameters(axis),
            format!(
                "the period {period} of a closed direction is greater than the range {length} of its parameters"
            ),
        ));
    }
    if !matches!(choice, Knots::Usual | Knots::Spread) {
        return Err(Invalid::at(
            Place::Knots(axis),
            "the knots of a closed direction of scattered points are \"spread\" over their parameters",
        ));
    }
    if free <= degree {
        return Err(Invalid::too_few_control_points(axis, free, degree));
    }
    if free > sorted.len() {
        let count = sorted.len();
        return Err(Invalid::at(
            Place::ControlPoints(axis),
            format!(
                "{free} control points for {count} different parameters: give fewer control points"
            ),
        ));
    }
    Ok(Arc::new(knots::periodic(sorted, period, degree, free)))
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
