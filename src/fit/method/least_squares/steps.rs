//! Steps along the gradient, `X ← X + D Aᵀ Δ`, and what all variants share: D, the gradient, and the
//! end.

use super::conjugate::Conjugate;
use super::end::End;
use super::settings::{Ending, LeastSquares, Variant};
use super::solver::Solver;
use crate::fit::equations::Equations;
use crate::fit::method::update::{Change, State, Update};
use crate::fit::outcome::Outcome;
use crate::fit::points::Points;
use crate::fit::scaling::normalizing_scale;

/// Column sums below this part of the largest belong to control points without data.
const NO_DATA: f64 = 1e-12;

/// The update of all variants.
#[derive(Debug)]
pub(super) struct Steps {
    /// The diagonal of D.
    scale: Vec<f64>,
    /// Powers of two that bring each coordinate to the order of one, so that squares neither over-
    /// nor underflow.
    units: Vec<f64>,
    /// `g = Aᵀ Δ`.
    gradient: Points,
    /// The squared length of the gradient, `‖Aᵀ Δ‖²`, in scaled units.
    square: f64,
    /// That of level 0.
    first_square: Option<f64>,
    /// How the step follows from the gradient.
    kind: Kind,
    /// How far the minimum is, if the fit ends there.
    end: Option<End>,
}

/// How the step follows from the gradient.
#[derive(Debug)]
enum Kind {
    /// It is a multiple of it, for each control point by itself.
    Multiple,
    /// By the steps before.
    Conjugate(Conjugate),
    /// By the normal equations.
    Direct(Box<Solver>),
}

impl Steps {
    /// Before the first update.
    pub(super) fn new(equations: &Equations, settings: &LeastSquares) -> Self {
        let variant = settings.variant;
        let setup = &equations.setup;
        let count = setup.control_grid().count();
        let dimension = setup.data().dimension();
        let scale = scale(equations, variant);
        let kind = match variant {
            Variant::Diagonal | Variant::Lspia { .. } => Kind::Multiple,
            Variant::ConjugateGradients => {
                Kind::Conjugate(Conjugate::new(dimension, count, setup.grid().count()))
            }
            Variant::Direct => Kind::Direct(Box::new(Solver::new(equations, &scale))),
        };
        let units: Vec<f64> = setup
            .data()
            .lanes()
            .iter()
            .map(|lane| normalizing_scale(lane.iter().fold(0.0, |m, x| x.abs().max(m))))
            .collect();
        Self {
            end: (settings.ending == Ending::Minimum).then(|| End::new(&units)),
            scale,
            units,
            gradient: Points::zeros(dimension, count),
            square: 0.0,
            first_square: None,
            kind,
        }
    }

    /// How many control points have no data in the support of their basis function.
    pub(super) fn without_data(equations: &Equations) -> usize {
        let scale = scale(equations, Variant::Diagonal);
        scale.iter().filter(|&&factor| factor == 0.0).count()
    }
}

/// The diagonal of D: zero for control points without data.
fn scale(equations: &Equations, variant: Variant) -> Vec<f64> {
    let setup = &equations.setup;
    let mut scratch = vec![0.0; equations.collocation.scratch()];
    let mut ones = vec![1.0; setup.grid().count()];
    if let Some(missing) = setup.missing() {
        missing.clear(&mut ones);
    }
    let mut sums = vec![0.0; setup.control_grid().count()];
    equations
        .collocation
        .apply_transposed(&ones, &mut sums, &mut scratch);
    let largest = sums.iter().copied().fold(0.0, f64::max);
    let factor = |sum: f64| match variant {
        _ if sum <= NO_DATA * largest => 0.0,
        Variant::Lspia { mu } => mu.unwrap_or(1.0 / largest),
        Variant::Diagonal | Variant::ConjugateGradients | Variant::Direct => 1.0 / sum,
    };
    sums.into_iter().map(factor).collect()
}

impl Update for Steps {
    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        let moved = self.scale.iter().filter(|&&factor| factor > 0.0).count();
        match &mut self.kind {
            Kind::Conjugate(conjugate) => {
                conjugate.update(equations, state, &self.gradient, &self.scale, &self.units);
                return Change::Residual { moved };
            }
            Kind::Direct(solver) => solver.update(equations, state, &self.gradient),
            Kind::Multiple => {
                let lanes = state.control_points.lanes_mut().iter_mut();
                for (x, gradient) in lanes.zip(self.gradient.lanes()) {
                    for ((x, gradient), factor) in x.iter_mut().zip(gradient).zip(&self.scale) {
                        *x += factor * gradient;
                    }
                }
            }
        }
        Change::All { moved }
    }

    /// `g = Aᵀ Δ`, for the next step and as a measure of how far the minimum is.
    fn measured(&mut self, equations: &Equations, state: &mut State) {
        self.square = 0.0;
        let unit = self.units.iter().copied().fold(f64::INFINITY, f64::min);
        let lanes = self.gradient.lanes_mut().iter_mut();
        for (gradient, residual) in lanes.zip(state.residual.lanes()) {
            equations
                .collocation
                .apply_transposed(residual, gradient, &mut state.scratch);
            self.square += gradient
                .iter()
                .map(|g| (g * unit) * (g * unit))
                .sum::<f64>();
        }
        self.first_square.get_or_insert(self.square);
        let own = match &self.kind {
            Kind::Direct(solver) => Some(&**solver),
            _ => None,
        };
        if let Some(end) = &mut self.end {
            end.measure(equations, state, &self.gradient, &self.scale, own);
        }
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

    fn outcome(&self) -> Option<Outcome> {
        self.end.as_ref().and_then(End::outcome)
    }
}
