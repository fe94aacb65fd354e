//! What does not change from level to level: the data, the collocation matrix, the transform.

use std::sync::{Arc, OnceLock};

use super::linear::{Inverse, apply_tensor, qr::Orthogonal};
use super::method::{Method, Start};
use super::points::Points;
use super::problem::Problem;
use super::rehearsal::{self, Foreseen};
use super::spectrum;
use super::tensor::Tensor;
use super::update::least_squares::LeastSquaresUpdate;

/// Up to this number of points in a direction λ_min is computed for the forecast alone; methods
/// that need it always have it.
const FORECAST: usize = 100_000;

/// Up to this number of adjusted points their block of the matrix is looked at, in O(n³).
const BLOCK: usize = 200;

/// A problem ready to be iterated. Iterations of the same problem share one.
#[derive(Debug)]
pub struct System {
    problem: Arc<Problem>,
    collocation: Arc<Tensor>,
    transform: Transform,
    forecast: Forecast,
    foreseen: OnceLock<Option<Foreseen>>,
}

/// The transform U of the update `X ← X + U Δ`, as far as it is a fixed linear map.
#[derive(Debug)]
pub enum Transform {
    /// `U = ω I`; also where the method chooses the step by itself.
    Scale(f64),
    /// `U = H Qᵀ`, of each direction.
    Orthogonal(Orthogonal, Option<Orthogonal>),
    /// `U = B⁻¹`, of each direction.
    Inverse(Inverse, Option<Inverse>),
    /// `U = Bᵀ / ρ`.
    Transposed {
        /// ρ(B Bᵀ).
        rho: f64,
    },
}

/// What is known of the convergence before the first step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forecast {
    /// The least eigenvalue of the collocation matrix.
    pub lambda_min: Option<f64>,
    /// The relaxation of weighted PIA.
    pub omega: Option<f64>,
    /// By how much the error shrinks in each iteration, asymptotically. For adaptive fits, and local
    /// ones of many points, an upper bound: principal submatrices have larger eigenvalues.
    pub rate: Option<f64>,
    /// Local: the least eigenvalue of the block of the matrix that belongs to the adjusted points.
    pub block: Option<f64>,
    /// The number of iterations after which the fit is exact, where there is one.
    pub exact_after: Option<usize>,
    /// Least squares: how many control points no data say anything of.
    pub without_data: usize,
    /// Chebyshev: where the interval of its steps begins, if not at the least eigenvalue.
    pub interval: Option<f64>,
    /// About how large a distance rounding leaves then, if that is more than the tolerance.
    pub rounding: Option<f64>,
}

impl Forecast {
    /// How many iterations of a local fit reduce an error to the tolerance: its block is small, so that
    /// the end of the spectrum is soon all that is left.
    pub fn iterations_of_block(&self, error: f64, tolerance: f64) -> Option<usize> {
        let rate = self.rate.filter(|_| self.block.is_some())?;
        let count = (tolerance / error).ln() / rate.ln();
        (rate > 0.0 && rate < 1.0 && count.is_finite()).then_some(count.ceil() as usize)
    }
}

impl System {
    /// Evaluates the collocation matrix and prepares the transform.
    pub fn new(problem: Arc<Problem>) -> Self {
        let collocation = Arc::new(Tensor::new(&problem));
        Self::with(problem, collocation)
    }

    /// Like [`new`](Self::new), but shares the collocation matrix of `other` if it is the same.
    pub fn like(problem: Arc<Problem>, other: &Self) -> Self {
        if problem.directions().eq(other.problem.directions()) {
            Self::with(problem, Arc::clone(&other.collocation))
        } else {
            Self::new(problem)
        }
    }

    fn with(problem: Arc<Problem>, collocation: Arc<Tensor>) -> Self {
        let forecast = forecast(&problem, &collocation);
        let transform = transform(problem.method(), &collocation, &forecast);
        let mut system = Self {
            problem,
            collocation,
            transform,
            forecast,
            foreseen: OnceLock::new(),
        };
        if matches!(system.transform, Transform::Orthogonal(..)) {
            system.forecast.rounding = rehearsal::left_by_rounding(&system);
        }
        if let Method::LeastSquares(settings) = system.problem.method() {
            system.forecast.without_data =
                LeastSquaresUpdate::new(&system, settings.variant).fixed();
        }
        if matches!(system.problem.method(), Method::Chebyshev) {
            system.choose_interval();
        }
        system
    }

    /// Takes shorter steps, unless those by the least eigenvalue keep distances low.
    fn choose_interval(&mut self) {
        for interval in rehearsal::safe_intervals(self) {
            if rehearsal::stays_low(self) {
                return;
            }
            self.forecast.interval = Some(interval);
            let least = self.forecast.lambda_min.unwrap_or(1.0);
            self.forecast.rate = Some(spectrum::chebyshev_rate(least, interval));
        }
    }

    /// The problem.
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The collocation matrix.
    pub fn collocation(&self) -> &Tensor {
        &self.collocation
    }

    /// The transform.
    pub fn transform(&self) -> &Transform {
        &self.transform
    }

    /// What is known of the convergence.
    pub fn forecast(&self) -> Forecast {
        self.forecast
    }

    /// Finds out where the fit will end, unless that is known.
    pub fn foresee(self: &Arc<Self>, look: impl FnOnce(&Arc<Self>) -> Option<Foreseen>) {
        self.foreseen.get_or_init(|| look(self));
    }

    /// Where the fit will end, if that was found out.
    pub fn foreseen(&self) -> Option<Foreseen> {
        self.foreseen.get().copied().flatten()
    }

    /// Numbers of scratch space that [`Self::transform_all`] and the maps of the matrix need.
    pub fn scratch(&self) -> usize {
        let count = self.problem.data().len();
        let image = matches!(self.transform, Transform::Transposed { .. });
        self.collocation.scratch() + if image { count } else { 0 }
    }

    /// Applies the transform in place and adds others: `points ← U points + others`.
    pub fn transform_onto(&self, points: &mut Points, others: &Points, scratch: &mut [f64]) {
        if let Transform::Inverse(Inverse::Positive(u), None) = &self.transform {
            let lanes = points.lanes_mut().iter_mut();
            let mut lanes: Vec<&mut [f64]> = lanes.map(AsMut::as_mut).collect();
            let others: Vec<&[f64]> = others.lanes().iter().map(|lane| &lane[..]).collect();
            return u.apply_onto(&mut lanes, &others);
        }
        self.transform_all(points, scratch);
        points.add(others);
    }

    /// Applies the transform in place: `points ← U points`.
    pub fn transform_all(&self, points: &mut Points, scratch: &mut [f64]) {
        let grid = self.problem.grid();
        let mut lanes: Vec<&mut [f64]> = points.lanes_mut().iter_mut().map(AsMut::as_mut).collect();
        match &self.transform {
            Transform::Scale(omega) => {
                let values = lanes.into_iter().flatten();
                values.for_each(|value| *value *= omega);
            }
            Transform::Transposed { rho } => {
                let (image, scratch) = scratch.split_at_mut(grid.count());
                for lane in lanes {
                    self.collocation.apply_transposed(lane, image, scratch);
                    let image = lane.iter_mut().zip(&*image);
                    image.for_each(|(value, image)| *value = image / rho);
                }
            }
            Transform::Orthogonal(u, v) => {
                apply_tensor(u, v.as_ref(), grid, &mut lanes, scratch);
            }
            Transform::Inverse(u, v) => apply_tensor(u, v.as_ref(), grid, &mut lanes, scratch),
        }
    }
}

fn transform(method: Method, collocation: &Tensor, forecast: &Forecast) -> Transform {
    let (u, v) = (&collocation.u, collocation.v.as_ref());
    match method {
        Method::Extended { .. } => Transform::Orthogonal(u.orthogonal(), v.map(|v| v.orthogonal())),
        Method::Direct => Transform::Inverse(u.inverse(), v.map(|v| v.inverse())),
        Method::Transpose => Transform::Transposed {
            rho: collocation
                .directions()
                .map(spectrum::largest_singular_value_squared)
                .product(),
        },
        Method::Weighted { .. } => Transform::Scale(forecast.omega.unwrap_or(1.0)),
        _ => Transform::Scale(1.0),
    }
}

fn forecast(problem: &Problem, collocation: &Tensor) -> Forecast {
    let grid = problem.grid();
    let small = grid.rows.max(grid.columns) <= FORECAST;
    let least = || -> f64 {
        let known = problem.request().lambda_min;
        let directions = collocation.directions();
        known.unwrap_or_else(|| directions.map(spectrum::least_eigenvalue).product())
    };
    match problem.method() {
        Method::Weighted { omega } => {
            let lambda = (small || omega.is_none()).then(least);
            let omega = omega.or_else(|| lambda.map(|lambda| 2.0 / (1.0 + lambda)));
            let rate = omega
                .zip(lambda)
                .map(|(omega, lambda)| (1.0 - omega * lambda).abs().max((1.0 - omega).abs()));
            Forecast {
                lambda_min: lambda,
                omega,
                rate,
                ..Forecast::default()
            }
        }
        Method::Chebyshev => {
            let lambda = least();
            Forecast {
                lambda_min: Some(lambda),
                rate: Some(spectrum::chebyshev_rate(lambda, lambda)),
                ..Forecast::default()
            }
        }
        Method::Local { .. } if few(problem).is_some() => {
            let block = few(problem).and_then(|adjusted| {
                spectrum::least_eigenvalue_of_block(collocation, grid, adjusted)
            });
            Forecast {
                lambda_min: problem.request().lambda_min,
                rate: block.map(|least| 1.0 - least),
                block,
                ..Forecast::default()
            }
        }
        Method::Global | Method::Local { .. } | Method::Adaptive { .. } if small => {
            let lambda = least();
            Forecast {
                lambda_min: Some(lambda),
                rate: Some(1.0 - lambda),
                ..Forecast::default()
            }
        }
        Method::Direct => Forecast {
            exact_after: Some(1),
            ..Forecast::default()
        },
        Method::Extended { start } => Forecast {
            exact_after: Some(nilpotency(problem, start)),
            ..Forecast::default()
        },
        _ => Forecast::default(),
    }
}

/// The adjusted points of a local fit, if they are few.
fn few(problem: &Problem) -> Option<&[usize]> {
    let adjusted = problem.selected()?;
    (adjusted.len() <= BLOCK).then_some(adjusted)
}

/// After so many levels the error of the extended method is zero: `I − U B` is strictly upper
/// triangular, so its power n + 1 vanishes; on surfaces, with highest indices m and n, the power
/// m + n + 1. The start `U P` is one step ahead of all others.
fn nilpotency(problem: &Problem, start: Start) -> usize {
    let highest: usize = problem
        .directions()
        .map(|direction| direction.free() - 1)
        .sum();
    match start {
        Start::Transformed if problem.start().is_none() => highest,
        _ => highest + 1,
    }
}
