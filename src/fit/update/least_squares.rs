//! Least squares: fewer control points than data (Deng, Lin 2014; Lin, Cao, Zhang 2018).
//!
//! `X ← X + D Aᵀ (P − A X)`, where A is the rectangular collocation matrix. Control points without
//! data (a zero column of A) stay where they are.

use super::{Change, State, Update};
use crate::fit::lane::Lane;
use crate::fit::method::Variant;
use crate::fit::norms::normalizing_scale;
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::fit::system::System;

/// Column sums below this part of the largest belong to control points without data.
const NO_DATA: f64 = 1e-12;

/// The update of the three variants.
#[derive(Debug)]
pub struct LeastSquaresUpdate {
    /// The diagonal of D.
    scale: Vec<f64>,
    /// Powers of two that bring each coordinate to the order of one, so that squares neither over-
    /// nor underflow.
    units: Vec<f64>,
    /// `g = Aᵀ Δ`.
    gradient: Points,
    square: f64,
    first_square: Option<f64>,
    conjugate: Option<Conjugate>,
}

/// What conjugate gradients remember.
#[derive(Debug)]
struct Conjugate {
    direction: Points,
    /// `A d`, one coordinate.
    image: Vec<f64>,
    /// `gᵀ D g` of each coordinate.
    gamma: Vec<f64>,
    begun: bool,
}

impl LeastSquaresUpdate {
    /// Before the first update.
    pub fn new(system: &System, variant: Variant) -> Self {
        let problem = system.problem();
        let count = problem.control_grid().count();
        let dimension = problem.data().dimension();
        let mut scratch = vec![0.0; system.collocation().scratch()];
        let mut ones = vec![1.0; problem.grid().count()];
        if let Some(missing) = problem.missing() {
            missing.clear(&mut ones);
        }
        let mut sums = vec![0.0; count];
        system
            .collocation()
            .apply_transposed(&ones, &mut sums, &mut scratch);
        let largest = sums.iter().copied().fold(0.0, f64::max);
        let factor = |sum: f64| match variant {
            _ if sum <= NO_DATA * largest => 0.0,
            Variant::Lspia { mu } => mu.unwrap_or(1.0 / largest),
            Variant::Diagonal | Variant::ConjugateGradients => 1.0 / sum,
        };
        let conjugate = (variant == Variant::ConjugateGradients).then(|| Conjugate {
            direction: Points::zeros(dimension, count),
            image: vec![0.0; problem.grid().count()],
            gamma: vec![0.0; dimension],
            begun: false,
        });
        Self {
            scale: sums.into_iter().map(factor).collect(),
            units: problem
                .data()
                .lanes()
                .iter()
                .map(|lane| normalizing_scale(lane.iter().fold(0.0, |m, x| x.abs().max(m))))
                .collect(),
            gradient: Points::zeros(dimension, count),
            square: 0.0,
            first_square: None,
            conjugate,
        }
    }
}

impl LeastSquaresUpdate {
    /// How many control points stay where they are, for want of data.
    pub fn fixed(&self) -> usize {
        self.scale.iter().filter(|&&factor| factor == 0.0).count()
    }
}

impl Update for LeastSquaresUpdate {
    fn update(&mut self, system: &System, state: &mut State) -> Change {
        let moved = self.scale.iter().filter(|&&factor| factor > 0.0).count();
        if let Some(conjugate) = &mut self.conjugate {
            conjugate.update(system, state, &self.gradient, &self.scale, &self.units);
            return Change::Residual { moved };
        }
        let lanes = state.control_points.lanes_mut().iter_mut();
        for (x, gradient) in lanes.zip(self.gradient.lanes()) {
            for ((x, gradient), factor) in x.iter_mut().zip(gradient).zip(&self.scale) {
                *x += factor * gradient;
            }
        }
        Change::All { moved }
    }

    fn measured(&mut self, system: &System, state: &mut State) {
        self.square = 0.0;
        let unit = self.units.iter().copied().fold(f64::INFINITY, f64::min);
        let lanes = self.gradient.lanes_mut().iter_mut();
        for (gradient, residual) in lanes.zip(state.residual.lanes()) {
            system
                .collocation()
                .apply_transposed(residual, gradient, &mut state.scratch);
            self.square += gradient
                .iter()
                .map(|g| (g * unit) * (g * unit))
                .sum::<f64>();
        }
        self.first_square.get_or_insert(self.square);
    }

    fn gradient(&self) -> Option<f64> {
        let first = self.first_square?;
        Some(if first > 0.0 {
            self.square / first
        } else {
            0.0
        })
    }
}

impl Conjugate {
    /// CGLS, preconditioned with D, for each coordinate by itself.
    fn update(
        &mut self,
        system: &System,
        state: &mut State,
        gradient: &Points,
        scale: &[f64],
        units: &[f64],
    ) {
        for ((c, gradient), unit) in gradient.lanes().iter().enumerate().zip(units) {
            let direction = &mut self.direction.lanes_mut()[c];
            let squares = gradient.iter().zip(scale);
            let gamma: f64 = squares.map(|(g, d)| (g * unit) * d * (g * unit)).sum();
            let beta = if self.begun && self.gamma[c] > 0.0 {
                gamma / self.gamma[c]
            } else {
                0.0
            };
            self.gamma[c] = gamma;
            for ((direction, g), d) in direction.iter_mut().zip(gradient).zip(scale) {
                *direction = d * g + beta * *direction;
            }
            system
                .collocation()
                .apply(direction, &mut self.image, &mut state.scratch);
            if let Some(missing) = system.problem().missing() {
                missing.clear(&mut self.image);
            }
            let curvature: f64 = self.image.iter().map(|q| (q * unit) * (q * unit)).sum();
            // At the minimum there is nowhere to go.
            let alpha = if curvature > 0.0 {
                gamma / curvature
            } else {
                0.0
            };
            let x = &mut state.control_points.lanes_mut()[c];
            for (x, direction) in x.iter_mut().zip(&*direction) {
                *x += alpha * direction;
            }
            let residual = &mut state.residual.lanes_mut()[c];
            for (residual, image) in residual.iter_mut().zip(&self.image) {
                *residual -= alpha * image;
            }
        }
        self.begun = true;
    }
}

/// Level 0: the first and the last data point, and between them point `⌊(m+1) i / n⌋` (Deng, Lin
/// 2014); on closed curves `⌊(m+1) i / (n+1)⌋`.
pub fn start(problem: &Problem) -> Points {
    let (data, grid) = (problem.data(), problem.grid());
    let rows = samples(grid.rows, problem.u().free(), problem.u().is_closed());
    let columns = problem
        .v()
        .map_or(vec![0], |v| samples(grid.columns, v.free(), v.is_closed()));
    let pick = |lane: &Lane| {
        let row = |i: &usize| {
            let start = i * grid.columns;
            columns.iter().map(move |j| lane[start + j])
        };
        rows.iter().flat_map(row).collect::<Vec<f64>>()
    };
    Points::from_lanes(data.lanes().iter().map(pick))
}

fn samples(count: usize, control_points: usize, closed: bool) -> Vec<usize> {
    let parts = if closed {
        control_points
    } else {
        control_points - 1
    };
    (0..control_points)
        .map(|i| (count * i / parts).min(count - 1))
        .collect()
}
