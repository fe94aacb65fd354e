//! The objective of a least-squares fit:
//!
//! ```text
//! f(X) = Σ_i ω_i ‖P_i − (A X)_i‖² + w Xᵀ H X,   −∇f/2 = g = Aᵀ Ω (P − A X) − w H X
//! ```
//!
//! with a weight ω_i for each data point and the energy of [`super::fairness`].

use std::sync::Arc;

use super::constraints::Condition;
use super::fairness::Energy;
use super::settings::{LeastSquares, Variant};
use crate::data::points::{Points, normalizing_scale};
use crate::method::equations::Equations;
use crate::method::update::State;
use crate::setup::Setup;

/// Column sums below this part of the largest belong to control points without data.
pub(super) const NO_DATA: f64 = 1e-12;

/// The objective.
#[derive(Clone, Debug)]
pub(super) struct Objective {
    weights: Option<Arc<[f64]>>,
    energy: Option<Arc<Energy>>,
    /// One coordinate of `Ω Δ`.
    weighted: Vec<f64>,
}

impl Objective {
    /// That of a fit with such settings.
    pub(super) fn new(setup: &Setup, settings: &LeastSquares) -> Self {
        let weights = weights(setup, settings).as_ref().map(normalized);
        let is_there = |i: &usize| setup.missing().is_none_or(|missing| !missing.contains(*i));
        let points = (0..setup.grid().count()).filter(is_there);
        let sum = points
            .map(|i| weights.as_ref().map_or(1.0, |weights| weights[i]))
            .sum();
        let energy = Energy::new(setup, settings, sum);
        Self {
            weighted: vec![0.0; weights.as_ref().map_or(0, |weights| weights.len())],
            weights,
            energy: energy.map(Arc::new),
        }
    }

    /// The energy of fairness.
    pub(super) fn energy(&self) -> Option<&Energy> {
        self.energy.as_deref()
    }

    /// Returns true if the normal equations of a whole grid are a product of those of both directions.
    pub(super) fn is_separable(&self) -> bool {
        self.weights.is_none() && self.energy.is_none()
    }

    /// How much a data point counts.
    pub(super) fn weight(&self, index: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[index])
    }

    /// `g = Aᵀ Ω Δ − w H X`.
    pub(super) fn gradient(
        &mut self,
        equations: &Equations,
        state: &mut State,
        gradient: &mut Points,
    ) {
        let lanes = gradient.lanes_mut().iter_mut();
        for (c, gradient) in lanes.enumerate() {
            self.pull(
                equations,
                state.residual.lane(c),
                gradient,
                &mut state.scratch,
            );
            if let Some(energy) = &self.energy {
                energy.subtract(state.control_points.lane(c), gradient);
            }
        }
    }

    /// `Aᵀ Ω x` of one coordinate.
    fn pull(&mut self, equations: &Equations, x: &[f64], pull: &mut [f64], scratch: &mut [f64]) {
        let mut weighted = x;
        if let Some(weights) = &self.weights {
            let products = x.iter().zip(&**weights).map(|(x, weight)| x * weight);
            self.weighted.clear();
            self.weighted.extend(products);
            weighted = &self.weighted;
        }
        equations
            .collocation
            .apply_transposed(weighted, pull, scratch);
    }

    /// `Aᵀ Ω P`: the gradient where all control points are zero.
    pub(super) fn pull_of_data(&mut self, equations: &Equations) -> Points {
        let data = equations.setup.data();
        let mut pull = Points::zeros(data.dimension(), equations.setup.control_grid().count());
        let mut scratch = vec![0.0; equations.scratch()];
        for (c, pull) in pull.lanes_mut().iter_mut().enumerate() {
            self.pull(equations, data.lane(c), pull, &mut scratch);
        }
        pull
    }

    /// `‖A d‖² + w dᵀ H d` of a direction d with this image `A d`, weighted and in squared units.
    pub(super) fn curvature(&self, direction: &[f64], image: &[f64], unit: f64) -> f64 {
        let squares = image.iter().enumerate().map(|(i, q)| match &self.weights {
            None => (q * unit) * (q * unit),
            Some(weights) => (q * unit) * weights[i] * (q * unit),
        });
        squares.sum::<f64>() + self.bending(direction, unit)
    }

    /// f of all coordinates, in squared units.
    pub(super) fn value(&self, state: &State, unit: f64) -> f64 {
        let lanes = state.residual.lanes().iter();
        let lanes = lanes.zip(state.control_points.lanes());
        lanes
            .map(|(residual, x)| self.curvature(x, residual, unit))
            .sum()
    }

    /// `w xᵀ H x` of one coordinate.
    fn bending(&self, x: &[f64], unit: f64) -> f64 {
        let Some(energy) = &self.energy else {
            return 0.0;
        };
        let mut product = vec![0.0; x.len()];
        energy.subtract(x, &mut product);
        let products = x.iter().zip(product);
        products.map(|(x, y)| -(x * unit) * (y * unit)).sum()
    }

    /// The diagonal of D: 1 over at least `Σ_j |N_ij|` of `N = Aᵀ Ω A + w H`, or μ. It is zero for
    /// control points without data that neither fairness nor a condition moves.
    pub(super) fn scale(
        &self,
        equations: &Equations,
        variant: Variant,
        conditions: &[Condition],
    ) -> Vec<f64> {
        let (mut sums, mut moves) = self.column_sums(equations);
        if let Some(energy) = &self.energy {
            energy.add_sums(&mut sums);
            moves
                .iter_mut()
                .zip(&sums)
                .for_each(|(moves, sum)| *moves |= *sum > 0.0);
        }
        let largest = sums.iter().copied().fold(0.0, f64::max);
        for &(index, _) in conditions.iter().flat_map(|condition| &condition.row) {
            if !moves[index] {
                (moves[index], sums[index]) = (true, largest);
            }
        }
        let factor = |(sum, moves): (f64, bool)| match variant {
            _ if !moves => 0.0,
            Variant::Lspia { mu } => mu.unwrap_or(1.0 / largest),
            Variant::Diagonal | Variant::ConjugateGradients | Variant::Direct => 1.0 / sum,
        };
        sums.into_iter().zip(moves).map(factor).collect()
    }

    /// `Aᵀ Ω 1`, the row sums of `Aᵀ Ω A`, and which control points have data that count.
    fn column_sums(&self, equations: &Equations) -> (Vec<f64>, Vec<bool>) {
        let setup = &equations.setup;
        let mut counted = vec![1.0; setup.grid().count()];
        if let Some(missing) = setup.missing() {
            missing.clear(&mut counted);
        }
        let mut scratch = vec![0.0; equations.collocation.scratch()];
        let mut sums_of = |values: &[f64]| {
            let mut sums = vec![0.0; setup.control_grid().count()];
            let collocation = &equations.collocation;
            collocation.apply_transposed(values, &mut sums, &mut scratch);
            sums
        };
        let Some(weights) = &self.weights else {
            let sums = sums_of(&counted);
            let moves = have_data(&sums);
            return (sums, moves);
        };
        let weighted = counted.iter().zip(&**weights);
        let weighted: Vec<f64> = weighted.map(|(one, weight)| one * weight).collect();
        // Points with small weights are data, too.
        for (one, weight) in counted.iter_mut().zip(&**weights) {
            if *weight == 0.0 {
                *one = 0.0;
            }
        }
        let moves = have_data(&sums_of(&counted));
        (sums_of(&weighted), moves)
    }
}

/// How much each data point counts; `None` if all do alike. Curves and scattered points that are left out have weight
/// zero; grids with missing points leave out their rows.
pub(super) fn weights(setup: &Setup, settings: &LeastSquares) -> Option<Arc<[f64]>> {
    let given = settings.data_weights.clone();
    let Some(missing) = setup.missing().filter(|_| !setup.grid().is_rows()) else {
        return given;
    };
    let mut weights = given.map_or_else(|| vec![1.0; setup.grid().count()], |it| it.to_vec());
    missing.clear(&mut weights);
    Some(weights.into())
}

/// Weights in a unit, a power of two, in which the largest is near one, so that neither sums nor
/// squares leave the range of numbers.
fn normalized(weights: &Arc<[f64]>) -> Arc<[f64]> {
    let unit = normalizing_scale(weights.iter().copied().fold(0.0, f64::max));
    if unit == 1.0 {
        return Arc::clone(weights);
    }
    // A weight that is small beside others stays one.
    let least = |weight: f64| if weight > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
    let weights = weights.iter().map(|x| (x * unit).max(least(*x)));
    weights.collect()
}

/// Which column sums are those of control points with data.
fn have_data(sums: &[f64]) -> Vec<bool> {
    let largest = sums.iter().copied().fold(0.0, f64::max);
    sums.iter().map(|&sum| sum > NO_DATA * largest).collect()
}
