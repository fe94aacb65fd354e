//! The loop `X ← X + U (P − B X)`, its errors and its stop rules.

use std::sync::Arc;

use super::collocation::Tensor;
use super::points::Points;
use super::problem::Problem;
use super::transform::Transform;

/// What does not change from level to level: the data, the collocation matrix and the transform.
/// Iterations of the same problem share one.
#[derive(Debug)]
pub struct System {
    problem: Arc<Problem>,
    collocation: Tensor,
    transform: Transform,
    /// A power of two that brings the data to the order of one, so that squares of distances
    /// neither over- nor underflow.
    scale: f64,
}

impl System {
    /// Evaluates the collocation matrix and prepares the transform.
    pub fn new(problem: Arc<Problem>) -> Self {
        Self {
            collocation: Tensor::new(&problem),
            transform: Transform::new(problem.method()),
            // Equal points leave rounding errors of their magnitude.
            scale: normalizing_scale(
                problem
                    .diagonal()
                    .max(problem.points().magnitude() * f64::EPSILON),
            ),
            problem,
        }
    }

    /// The problem.
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// Writes `Δ = P − B X` and returns its norms.
    fn measure(
        &self,
        control_points: &Points,
        residual: &mut Points,
        scratch: &mut [f64],
    ) -> FitError {
        let data = self.problem.points().lanes();
        let lanes = residual.lanes_mut().iter_mut();
        for ((residual, x), data) in lanes.zip(control_points.lanes()).zip(data) {
            self.collocation.apply(x, residual, scratch);
            for (residual, data) in residual.iter_mut().zip(data) {
                *residual = data - *residual;
            }
        }
        distances(residual, self.scale)
    }
}

/// Distances of the curve from the data, in data units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitError {
    /// The largest distance: the fitting error of the papers and of the stop rule.
    pub max: f64,
    /// The index of the data point with the largest distance, the first if there are several.
    pub at: usize,
    /// The root of the mean of the squared distances.
    pub rms: f64,
    /// The sum of the distances (the error of Lin 2010).
    pub sum: f64,
}

/// A level of the iteration: how far the curve of these control points is from the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// The number of updates so far.
    pub iteration: usize,
    /// The distances from the data.
    pub error: FitError,
    /// How many control points the last update moved.
    pub moved: usize,
}

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The largest distance is within the tolerance.
    Converged,
    /// The last allowed level is reached, and the tolerance is not.
    Exhausted,
    /// The distances are not finite numbers any more.
    Overflow,
}

/// The iteration of one problem at some level.
#[derive(Debug)]
pub struct Iteration {
    system: Arc<System>,
    control_points: Points,
    residual: Points,
    scratch: Vec<f64>,
    level: Level,
}

impl Iteration {
    /// Level 0: the data are the control points.
    pub fn start(system: Arc<System>) -> Self {
        let control_points = system.problem.points().clone();
        let mut residual = Points::zeros(control_points.dimension(), control_points.len());
        let mut scratch = vec![0.0; system.collocation.scratch()];
        let error = system.measure(&control_points, &mut residual, &mut scratch);
        Self {
            control_points,
            residual,
            scratch,
            level: Level {
                iteration: 0,
                error,
                moved: 0,
            },
            system,
        }
    }

    /// The current level.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The free control points of the current level.
    pub fn control_points(&self) -> &Points {
        &self.control_points
    }

    /// Moves on to the next level.
    pub fn step(&mut self) -> Level {
        let system = &self.system;
        let moved = system
            .transform
            .update(&mut self.control_points, &self.residual);
        let error = system.measure(&self.control_points, &mut self.residual, &mut self.scratch);
        self.level = Level {
            iteration: self.level.iteration + 1,
            error,
            moved,
        };
        self.level
    }

    /// Whether the iteration ends at the current level, and why.
    pub fn outcome(&self) -> Option<Outcome> {
        let problem = &self.system.problem;
        let Level {
            iteration, error, ..
        } = self.level;
        if !error.sum.is_finite() {
            Some(Outcome::Overflow)
        } else if error.max <= problem.tolerance() {
            Some(Outcome::Converged)
        } else if iteration >= problem.max_iterations() {
            Some(Outcome::Exhausted)
        } else {
            None
        }
    }
}

/// A power of two near `1 / length`.
fn normalizing_scale(length: f64) -> f64 {
    if length > 0.0 {
        (-length.log2().floor()).clamp(-1022.0, 1022.0).exp2()
    } else {
        1.0
    }
}

/// Norms of the residual; squares are formed of coordinates times `scale`.
fn distances(residual: &Points, scale: f64) -> FitError {
    let mut squares = Squares::default();
    match residual.lanes() {
        [x] => x
            .iter()
            .for_each(|x| squares.add((x * scale) * (x * scale))),
        [x, y] => x.iter().zip(y).for_each(|(x, y)| {
            let (x, y) = (x * scale, y * scale);
            squares.add(x * x + y * y);
        }),
        lanes => (0..residual.len()).for_each(|i| {
            let square = lanes.iter().map(|lane| lane[i] * scale);
            squares.add(square.fold(0.0, |sum, x| sum + x * x));
        }),
    }
    FitError {
        max: squares.max.sqrt() / scale,
        at: squares.at,
        rms: (squares.sum / residual.len() as f64).sqrt() / scale,
        sum: squares.roots / scale,
    }
}

/// Running largest value and sums of squared distances.
#[derive(Default)]
struct Squares {
    count: usize,
    max: f64,
    at: usize,
    sum: f64,
    roots: f64,
}

impl Squares {
    #[inline]
    fn add(&mut self, square: f64) {
        if square > self.max {
            self.max = square;
            self.at = self.count;
        }
        self.sum += square;
        self.roots += square.sqrt();
        self.count += 1;
    }
}
