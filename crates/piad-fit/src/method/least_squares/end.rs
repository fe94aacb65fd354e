//! The end of a least-squares fit at its minimum.
//!
//! With the [objective](super::objective) f and its gradient g, f lies above its minimum f* by
//!
//! ```text
//! f − f* = gᵀ N⁻¹ g,   N = AᵀΩA + w H
//! ```
//!
//! exactly, whatever the variant (with conditions by the projected step N⁻¹ g): the step length does not show it, as
//! slow methods take small steps far from the minimum. So when the length of the residual has nearly stopped falling,
//! the normal equations are solved for g, and the fit ends where f − f* is a small part of f. Where their factorization
//! would take too long (large surfaces with holes) f − f* is what is left of decreases that continue shrinking by the
//! same factor (Aitken).
//!
//! Where the data lie on the curve, f falls to rounding and f* is zero: that is the end, too.

use std::sync::Arc;

use super::constraints::Condition;
use super::objective::Objective;
use super::settings::LeastSquares;
use super::solver::{Solver, cost, sums_products};
use crate::data::points::Points;
use crate::method::equations::Equations;
use crate::method::update::State;
use crate::setup::Setup;
use crate::termination::{Outcome, Reason};

/// A residual that shrinks by less than this part in one iteration has nearly stopped.
const SLOW: f64 = 1e-6;

/// A fit is at its minimum if its objective is above it by at most this part.
const MINIMUM_EXCESS: f64 = 1e-6;

/// A residual that grows by more than this part, away from the minimum, keeps growing.
const GROWS: f64 = 1e-12;

/// Residuals whose mean is below this part of the data are rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The most multiplications of a factorization to determine the end.
const MAX_END_MULTIPLICATIONS: usize = 200_000_000;

/// Distance from the minimum.
#[derive(Clone, Debug)]
pub(super) struct End {
    /// A power of two for all coordinates, as they are squared.
    unit: f64,
    /// The objective of the last level.
    last: Option<f64>,
    /// Its decrease.
    fall: f64,
    /// True if the normal equations can be solved in a short time.
    solvable: bool,
    /// True if the normal equations are summed up as products for that.
    sums_products: bool,
    /// The conditions of every level.
    conditions: Vec<Condition>,
    /// The normal equations, once they were needed.
    solver: Option<Arc<Solver>>,
    outcome: Option<Outcome>,
}

impl End {
    /// Before level 0 of data with such units and conditions.
    pub(super) fn new(
        units: &[f64],
        conditions: Vec<Condition>,
        setup: &Setup,
        settings: &LeastSquares,
    ) -> Self {
        Self {
            conditions,
            solvable: cost(setup, settings) <= MAX_END_MULTIPLICATIONS,
            sums_products: sums_products(setup, settings),
            unit: units.iter().copied().fold(f64::INFINITY, f64::min),
            last: None,
            fall: 0.0,
            solver: None,
            outcome: None,
        }
    }

    /// The outcome if the fit ends at the level that was measured last.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// Measures a level with this gradient, with the solver of the method if it has one.
    pub(super) fn measure(
        &mut self,
        (equations, objective): (&Equations, &Objective),
        state: &mut State,
        gradient: &Points,
        scale: &[f64],
        own: Option<&Solver>,
    ) {
        let value = objective.value(state, self.unit);
        let (last, fall) = (self.last.replace(value), self.fall);
        let Some(last) = last else {
            return;
        };
        self.fall = last - value;
        let decrease = if last > 0.0 {
            1.0 - (value / last).sqrt()
        } else {
            0.0
        };
        self.outcome = None;
        if decrease.abs() >= SLOW && own.is_none() {
            let grows = decrease < 0.0 && !self.is_rounding(equations, value);
            self.outcome = grows.then_some(Outcome::Stalled(Reason::Diverging));
            return;
        }
        let (unit, now) = (self.unit, self.fall);
        let above = match self.solver((equations, objective), scale, own) {
            Some(solver) => above(solver, state, gradient, unit),
            None if now < fall => now * now / (fall - now),
            None => f64::INFINITY,
        };
        if above <= MINIMUM_EXCESS * value || self.is_rounding(equations, value) {
            self.outcome = Some(Outcome::Minimum);
        } else if decrease < -GROWS {
            self.outcome = Some(Outcome::Stalled(Reason::Diverging));
        }
    }

    /// Returns true if a sum of squares is no more than rounding of the data leaves.
    fn is_rounding(&self, equations: &Equations, value: f64) -> bool {
        let coordinates = equations.setup.data().lanes().iter();
        let coordinates = coordinates.flat_map(|lane| lane.iter());
        let square: f64 = coordinates.map(|x| (x * self.unit) * (x * self.unit)).sum();
        value <= ROUNDING * ROUNDING * square
    }

    /// The factorization of the normal equations, if it does not take too long.
    fn solver<'a>(
        &'a mut self,
        (equations, objective): (&Equations, &Objective),
        scale: &[f64],
        own: Option<&'a Solver>,
    ) -> Option<&'a Solver> {
        if own.is_some() || !self.solvable {
            return own;
        }
        let (small, sums_products) = ((objective, &*self.conditions), self.sums_products);
        let make = || Arc::new(Solver::new(equations, small, scale, sums_products));
        Some(&**self.solver.get_or_insert_with(make))
    }
}

/// `gᵀ N⁻¹ g` of all coordinates, in squared units.
fn above(solver: &Solver, state: &mut State, gradient: &Points, unit: f64) -> f64 {
    let mut step = gradient.clone();
    solver.solve(&mut step, &mut state.scratch);
    let products = |(gradient, step): (&[f64], &[f64])| -> f64 {
        let products = gradient.iter().zip(step);
        products.map(|(g, step)| (g * unit) * (step * unit)).sum()
    };
    let lanes = gradient.lanes().iter().zip(step.lanes());
    lanes
        .map(|(gradient, step)| products((gradient, step)))
        .sum()
}
