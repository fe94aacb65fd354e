//! Steps along the gradient, `X ← X + D g`, and what all variants share: D, the gradient, the
//! conditions of every level, and the end.

use std::sync::Arc;

use super::conjugate::Descent;
use super::constraints::{Condition, Projection, independent};
use super::end::End;
use super::objective::Objective;
use super::settings::{LeastSquares, Variant};
use super::solver::{Solver, sums_products};
use crate::data::points::{Points, normalizing_scale};
use crate::method::equations::Equations;
use crate::method::plain::compute_residual;
use crate::method::update::{Change, State, Update};
use crate::setup::Setup;
use crate::termination::Outcome;

/// The update of all variants.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// The objective.
    objective: Objective,
    /// The diagonal of D.
    scale: Vec<f64>,
    /// The projection that keeps the conditions of every level, with the metric D.
    projection: Option<Arc<Projection>>,
    /// Powers of two that bring each coordinate to the order of one, so that squares neither over-
    /// nor underflow.
    units: Vec<f64>,
    /// `g = Aᵀ Ω Δ − w H X`, projected.
    gradient: Points,
    /// The squared length of the gradient, `‖g‖²`, in scaled units.
    square: f64,
    /// That of level 0.
    first_square: Option<f64>,
    /// How the step follows from the gradient.
    kind: Kind,
    /// The distance of the minimum, if the fit can end there.
    end: End,
    /// The first constraint whose tangent the data run against.
    reversed: Option<usize>,
}

/// How the step follows from the gradient.
#[derive(Clone, Debug)]
enum Kind {
    /// It is a multiple of it, for each control point separately.
    Multiple,
    /// By the steps before.
    Conjugate(Descent),
    /// By the normal equations.
    Direct(Arc<Solver>),
}

impl Steps {
    /// Before the first update.
    pub(super) fn new(equations: &Equations, settings: &LeastSquares) -> Self {
        let variant = settings.variant;
        let setup = &equations.setup;
        let count = setup.control_grid().count();
        let dimension = setup.data().dimension();
        let mut objective = Objective::new(setup, settings);
        let mut conditions = conditions(setup, settings);
        let scale = objective.scale(equations, variant, &conditions);
        let has_tangents = conditions.iter().any(|condition| condition.is_tangent);
        let solver = (has_tangents || variant == Variant::Direct)
            .then(|| {
                Solver::new(
                    equations,
                    (&objective, &conditions),
                    &scale,
                    sums_products(setup, settings),
                )
            })
            .map(Arc::new);
        let tangents = solver.as_ref().filter(|_| has_tangents);
        let tangents =
            tangents.and_then(|it| it.tangents(equations, &mut objective, (&conditions, &scale)));
        let reversed = tangents.and_then(|it| it.settle(&mut conditions, setup));
        let kind = match solver.filter(|_| variant == Variant::Direct) {
            Some(solver) => Kind::Direct(solver),
            None if variant == Variant::ConjugateGradients => {
                Kind::Conjugate(Descent::new(dimension, count, setup.grid().count()))
            }
            None => Kind::Multiple,
        };
        let units: Vec<f64> = setup
            .data()
            .lanes()
            .iter()
            .map(|lane| normalizing_scale(lane.iter().fold(0.0, |m, x| x.abs().max(m))))
            .collect();
        Self {
            projection: Projection::diagonal(&conditions, &scale).map(Arc::new),
            end: End::new(&units, conditions, setup, settings),
            objective,
            scale,
            units,
            gradient: Points::zeros(dimension, count),
            square: 0.0,
            first_square: None,
            kind,
            reversed,
        }
    }

    /// The first constraint whose tangent the data run against.
    pub(super) fn reversed(&self) -> Option<usize> {
        self.reversed
    }

    /// Corrects the drift of control points from the conditions by rounding.
    fn correct(&self, state: &mut State) {
        let Some(projection) = &self.projection else {
            return;
        };
        let lanes = state.control_points.lanes_mut().iter_mut();
        lanes
            .enumerate()
            .for_each(|(c, x)| projection.correct(c, x));
    }

    /// The number of control points without data in the support of their basis function.
    pub(super) fn without_data(equations: &Equations, settings: &LeastSquares) -> usize {
        let objective = Objective::new(&equations.setup, settings);
        let conditions = conditions(&equations.setup, settings);
        let scale = objective.scale(equations, Variant::Diagonal, &conditions);
        scale.iter().filter(|&&factor| factor == 0.0).count()
    }
}

/// The conditions of every level. In a validated problem they can be satisfied.
fn conditions(setup: &Setup, settings: &LeastSquares) -> Vec<Condition> {
    independent(setup, settings).unwrap_or_default()
}

impl Update for Steps {
    fn copy(&self) -> Box<dyn Update> {
        Box::new(self.clone())
    }

    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        let moved = self.scale.iter().filter(|&&factor| factor > 0.0).count();
        match &mut self.kind {
            Kind::Conjugate(conjugate) => {
                conjugate.update(
                    (equations, &self.objective),
                    state,
                    &self.gradient,
                    &self.scale,
                    &self.units,
                );
                if self.projection.is_none() {
                    return Change::Residual { moved };
                }
            }
            Kind::Direct(solver) => {
                solver.update(equations, state, &self.gradient, &mut self.objective);
            }
            Kind::Multiple => {
                let lanes = state.control_points.lanes_mut().iter_mut();
                for (x, gradient) in lanes.zip(self.gradient.lanes()) {
                    for ((x, gradient), factor) in x.iter_mut().zip(gradient).zip(&self.scale) {
                        *x += factor * gradient;
                    }
                }
            }
        }
        self.correct(state);
        Change::All { moved }
    }

    /// Level 0 satisfies them, too.
    fn begin(&mut self, equations: &Equations, state: &mut State) {
        if self.projection.is_some() {
            // The second time for what rounding leaves of a large correction.
            self.correct(state);
            self.correct(state);
            compute_residual(equations, state);
        }
        self.measured(equations, state);
    }

    /// The gradient, for the next step and as a measure of how far the minimum is.
    fn measured(&mut self, equations: &Equations, state: &mut State) {
        self.objective
            .gradient(equations, state, &mut self.gradient);
        let unit = self.units.iter().copied().fold(f64::INFINITY, f64::min);
        self.square = 0.0;
        for gradient in self.gradient.lanes_mut() {
            if let Some(projection) = &self.projection {
                projection.gradient(gradient);
            }
            let squares = gradient.iter().map(|g| (g * unit) * (g * unit));
            self.square += squares.sum::<f64>();
        }
        self.first_square.get_or_insert(self.square);
        let own = match &self.kind {
            Kind::Direct(solver) => Some(&**solver),
            _ => None,
        };
        self.end.measure(
            (equations, &self.objective),
            state,
            &self.gradient,
            &self.scale,
            own,
        );
    }

    /// `‖g‖² / ‖g⁰‖²`.
    fn gradient(&self) -> Option<f64> {
        let first = self.first_square?;
        Some(if first > 0.0 {
            self.square / first
        } else {
            0.0
        })
    }

    fn seeks_minimum(&self) -> bool {
        self.objective.energy().is_some() && self.end.outcome() != Some(Outcome::Minimum)
    }

    fn outcome(&self) -> Option<Outcome> {
        self.end.outcome()
    }
}
