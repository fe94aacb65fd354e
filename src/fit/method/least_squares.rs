//! Least squares: fewer control points than data points.
//!
//! ```text
//! X ← X + D Aᵀ (P − A X),   A[i][j] = B_j(t_i)
//! ```
//!
//! A is the rectangular collocation matrix, m + 1 data points × n + 1 control points. Level 0 are
//! the first data point, the last, and between them data point `⌊(m+1) i / n⌋` (Deng, Lin 2014); on
//! closed curves `⌊(m+1) i / (n+1)⌋`. Three choices of D:
//!
//! - [`Variant::Diagonal`]: D = diag(1 / column sums of A) (Lin, Cao, Zhang 2018);
//! - [`Variant::Lspia`]: D = μ I with 0 < μ < 2/λ_max(AᵀA) (Deng, Lin 2014), by default 1 over the
//!   largest column sum, as their 2 is on the edge of stability;
//! - [`Variant::ConjugateGradients`]: CGLS for each coordinate, preconditioned with the diagonal D.
//!
//! Control points without data (a zero column of A) stay where they are. The fit ends at its
//! minimum, when the length of the residual has stopped falling, which is hardly ever within the
//! tolerance. A level costs one application of A and one of Aᵀ.

use std::sync::Arc;

use super::scheme::{Demand, Progress, Scheme, Scope};
use super::update::{Change, State, Update};
use crate::fit::about::About;
use crate::fit::equations::Equations;
use crate::fit::forecast::Forecast;
use crate::fit::invalid::{Invalid, Setting};
use crate::fit::lane::Lane;
use crate::fit::outcome::{Outcome, Stall};
use crate::fit::points::Points;
use crate::fit::scaling::normalizing_scale;
use crate::fit::setup::Setup;
use crate::fit::warning::Warning;

/// The entry in the table of methods.
pub(super) const ABOUT: About = About {
    name: "least_squares",
    title: "Least-squares PIA (LSPIA)",
    summary: "Fewer control points than data points approach the least-squares approximation.",
    source: "Deng, Lin, CAD 47 (2014); Lin, Cao, Zhang, CAGD 64 (2018)",
};

/// A least-squares fit whose residual shrinks by less than this part in one iteration has
/// converged.
const STATIONARY: f64 = 1e-6;

/// Column sums below this part of the largest belong to control points without data.
const NO_DATA: f64 = 1e-12;

/// A least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares {
    /// The number of control points of a curve, or in the u direction.
    pub u: usize,
    /// The number of control points in the v direction of a surface.
    pub v: usize,
    /// How the control points move.
    pub variant: Variant,
}

/// The variants of the least-squares update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variant {
    /// `X ← X + D Aᵀ Δ` with D = diag(1 / column sums of A).
    Diagonal,
    /// `X ← X + μ Aᵀ Δ`; without μ it is 1 / (largest column sum of A).
    Lspia {
        /// The given μ > 0.
        mu: Option<f64>,
    },
    /// Conjugate gradients (CGLS), preconditioned with the same D.
    ConjugateGradients,
}

impl Scheme for LeastSquares {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    /// A given μ must be positive; one that is too large shows itself, as the residual grows.
    fn check(&self, _scope: &Scope<'_>) -> Result<(), Invalid> {
        match self.variant {
            Variant::Lspia { mu: Some(mu) } => Invalid::unless_positive(Setting::Mu, mu),
            _ => Ok(()),
        }
    }

    /// Those that were asked for.
    fn control_points(&self) -> Option<(usize, usize)> {
        Some((self.u, self.v))
    }

    /// Points without data have no residual, and pull at nothing.
    fn fits_holes(&self) -> bool {
        true
    }

    /// The gradient, and for conjugate gradients the direction and its image.
    fn demand(&self) -> Demand {
        Demand {
            vectors: 3,
            matrices: 4,
            bytes: 0,
        }
    }

    /// Control points with a zero column of A.
    fn complete(&self, equations: &mut Equations) {
        equations.forecast.without_data = Steps::new(equations, self.variant).fixed();
    }

    /// Samples of the data.
    fn start(&self, equations: &Equations) -> Arc<Points> {
        Arc::new(start(&equations.setup))
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        Box::new(Steps::new(equations, self.variant))
    }

    /// They end at the minimum, wherever that is, and nothing falls to zero.
    fn decays(&self) -> bool {
        false
    }

    /// At the minimum.
    fn ends_by_itself(&self) -> bool {
        true
    }

    /// At the minimum the residual stands still; if μ is too large it grows.
    fn stop(&self, progress: &Progress) -> Option<Outcome> {
        if progress.iteration == 0 {
            None
        } else if progress.decrease.abs() < STATIONARY {
            Some(Outcome::Stationary)
        } else if progress.decrease < 0.0 {
            Some(Outcome::Stalled(Stall::Diverging))
        } else {
            None
        }
    }

    /// Control points without data.
    fn warnings(
        &self,
        forecast: &Forecast,
        _predicted: Option<usize>,
        _iterations: usize,
    ) -> Vec<Warning> {
        let count = forecast.without_data;
        let lost = (count > 0).then_some(Warning::WithoutData { count });
        lost.into_iter().collect()
    }
}

/// The update of the three variants.
#[derive(Debug)]
struct Steps {
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
    /// The state of conjugate gradients, for that variant.
    conjugate: Option<Conjugate>,
}

/// What conjugate gradients remember.
#[derive(Debug)]
struct Conjugate {
    /// The directions d of the last step, one for each coordinate.
    direction: Points,
    /// `A d`, one coordinate.
    image: Vec<f64>,
    /// `gᵀ D g` of each coordinate.
    gamma: Vec<f64>,
    /// Whether there was a step.
    begun: bool,
}

impl Steps {
    /// Before the first update.
    fn new(equations: &Equations, variant: Variant) -> Self {
        let setup = &equations.setup;
        let count = setup.control_grid().count();
        let dimension = setup.data().dimension();
        let mut scratch = vec![0.0; equations.collocation.scratch()];
        let mut ones = vec![1.0; setup.grid().count()];
        if let Some(missing) = setup.missing() {
            missing.clear(&mut ones);
        }
        let mut sums = vec![0.0; count];
        equations
            .collocation
            .apply_transposed(&ones, &mut sums, &mut scratch);
        let largest = sums.iter().copied().fold(0.0, f64::max);
        let factor = |sum: f64| match variant {
            _ if sum <= NO_DATA * largest => 0.0,
            Variant::Lspia { mu } => mu.unwrap_or(1.0 / largest),
            Variant::Diagonal | Variant::ConjugateGradients => 1.0 / sum,
        };
        let conjugate = (variant == Variant::ConjugateGradients).then(|| Conjugate {
            direction: Points::zeros(dimension, count),
            image: vec![0.0; setup.grid().count()],
            gamma: vec![0.0; dimension],
            begun: false,
        });
        Self {
            scale: sums.into_iter().map(factor).collect(),
            units: setup
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

    /// How many control points have no data in the support of their basis function.
    fn fixed(&self) -> usize {
        self.scale.iter().filter(|&&factor| factor == 0.0).count()
    }
}

impl Update for Steps {
    fn update(&mut self, equations: &Equations, state: &mut State) -> Change {
        let moved = self.scale.iter().filter(|&&factor| factor > 0.0).count();
        if let Some(conjugate) = &mut self.conjugate {
            conjugate.update(equations, state, &self.gradient, &self.scale, &self.units);
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
}

impl Conjugate {
    /// CGLS, preconditioned with D, for each coordinate by itself.
    fn update(
        &mut self,
        equations: &Equations,
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
            equations
                .collocation
                .apply(direction, &mut self.image, &mut state.scratch);
            if let Some(missing) = equations.setup.missing() {
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

/// Level 0: data points at equal distances of their indices, the first and the last among them.
fn start(setup: &Setup) -> Points {
    let (data, grid) = (setup.data(), setup.grid());
    let rows = samples(grid.rows, setup.u().free(), setup.u().is_closed());
    let columns = setup
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

/// Which of `count` data points the control points of a direction start from.
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
