//! A fit request, [`Fit`], and a checked one that can be iterated, [`Prepared`].

use std::fmt;
use std::iter::FusedIterator;
use std::marker::PhantomData;
use std::sync::Arc;

use super::basis::knots::Knots;
use super::invalid::Invalid;
use super::iteration::Iteration;
use super::method::{AS_MANY_AS_DATA, LeastSquares, Method};
use super::parameters::Parametrization;
use super::problem::Problem;
use super::shape::{Curve, Shape, Surface};
use super::termination::{Outcome, Reason};
use crate::basis::choice::{BasisChoice, Corners, DirectionChoice};
use crate::basis::end_conditions::Ends;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::data::{IntoGrid, IntoPoints};
use crate::geometry::norms::FitError;
use crate::iteration::system::System;
use crate::parameters::scattered::Scattered;
use crate::problem::request::{Request, Tolerance, Trim, Weights};
use crate::trim::trimmed;

/// The degree of B-splines where none is given.
const DEGREE: usize = 3;

/// A fit request. The defaults are a cubic B-spline through the data, by classical PIA, to within a millionth of their
/// size. Nothing is checked before [`prepare`](Self::prepare).
#[derive(Clone, Debug)]
#[must_use = "a fit is computed once it is prepared"]
pub struct Fit<S> {
    request: Result<Request, Invalid>,
    shape: PhantomData<fn() -> S>,
}

/// A direction with default settings.
fn usual(parameters: Parametrization) -> DirectionChoice {
    DirectionChoice::new(
        BasisChoice::BSpline {
            degree: DEGREE,
            knots: Knots::Usual,
        },
        parameters,
    )
}

/// A request with default settings.
fn request(points: Points, grid: Grid, is_surface: bool) -> Request {
    let parameters = match is_surface {
        true => Parametrization::usual_of_surface(&points),
        false => Parametrization::ChordLength,
    };
    let v = is_surface.then(|| usual(parameters.clone()));
    Request::new(points, grid, usual(parameters), v)
}

impl Fit<Curve> {
    /// A curve through or near points, in their order.
    pub fn curve(points: impl IntoPoints) -> Self {
        Self::of(points.into_points().map(|points| {
            let rows = points.len();
            request(points, Grid { rows, columns: 1 }, false)
        }))
    }

    /// Closes the curve: the last point is followed by the first.
    pub fn closed(self) -> Self {
        self.with(|request| request.u.closed = true)
    }

    /// The basis and its knots; default: B-splines with [usual](Knots::Usual) knots.
    pub fn basis(self, basis: BasisChoice) -> Self {
        self.with(|request| request.u.basis = basis)
    }

    /// The parameters of the data points; default: chord length.
    pub fn parameters(self, parameters: Parametrization) -> Self {
        self.with(|request| request.u.parameters = parameters)
    }

    /// The points at which the curve may turn, and through which it passes.
    pub fn corners(self, corners: Corners) -> Self {
        self.with(|request| request.u.corners = Some(corners))
    }

    /// The points are unordered: they are sorted along the curve.
    pub fn unordered(self) -> Self {
        self.with(|request| request.unordered = true)
    }

    /// Repeated successive points are kept once, rather than refused.
    pub fn merge_repeated(self) -> Self {
        self.with(|request| request.merge_repeated = true)
    }

    /// The edges between the points are data, too: the fewest control points with which the curve is within the tolerance
    /// of all of them. It turns at vertices with more than 30 degrees, unless corners are given.
    pub fn polyline(self) -> Self {
        self.with(|request| request.polyline = true)
            .fewest_control_points()
    }

    /// End conditions of an open curve that has its knots at the data.
    pub fn ends(self, ends: Ends) -> Self {
        self.with(|request| request.u.ends = Some(ends))
    }

    /// Least squares with this number of control points.
    pub fn control_points(self, count: usize) -> Self {
        self.method(Method::LeastSquares(LeastSquares::new(count, count)))
    }
}

impl Fit<Surface> {
    /// A surface through or near a grid of points: rows along u, columns along v.
    pub fn surface(rows: impl IntoGrid) -> Self {
        Self::of(
            rows.into_grid()
                .map(|(points, grid)| request(points, grid, true)),
        )
    }

    /// A surface near unordered points, with as few control points as the tolerance needs.
    pub fn scattered(points: impl IntoPoints, parameters: Scattered) -> Self {
        let request = points.into_points().map(|points| {
            let rows = points.len();
            let mut request = request(points, Grid { rows, columns: 1 }, true);
            request.scattered = Some(parameters);
            request
        });
        Self::of(request).fewest_control_points()
    }

    /// The closed directions of the surface.
    pub fn closed(self, u: bool, v: bool) -> Self {
        self.with(|request| {
            request.u.closed = u;
            request.v.iter_mut().for_each(|it| it.closed = v);
        })
    }

    /// The bases of u and of v with their knots; default: B-splines with [usual](Knots::Usual) knots.
    pub fn bases(self, u: BasisChoice, v: BasisChoice) -> Self {
        self.with(|request| {
            request.u.basis = u;
            request.v.iter_mut().for_each(|it| it.basis = v.clone());
        })
    }

    /// The parameters of rows and columns; default: mean chord length.
    pub fn parameters(self, u: Parametrization, v: Parametrization) -> Self {
        self.with(|request| {
            request.u.parameters = u;
            request
                .v
                .iter_mut()
                .for_each(|it| it.parameters = v.clone());
        })
    }

    /// Least squares with these numbers of control points.
    pub fn control_points(self, u: usize, v: usize) -> Self {
        self.method(Method::LeastSquares(LeastSquares::new(u, v)))
    }
}

impl Fit<Surface> {
    /// Trims the surface to the outline of its data, at a distance equal to their spacing.
    pub fn trimmed(self) -> Self {
        self.with(|request| request.trim = Some(Trim::default()))
    }

    /// Trims the surface to an outline that is at most this far from the data, in the unit of the points.
    pub fn trimmed_within(self, distance: f64) -> Self {
        let distance = Some(distance);
        self.with(|request| request.trim = Some(Trim { distance }))
    }

    /// Lines of points across which the surface of a grid may turn, by indices of rows and of columns.
    pub fn creases(self, rows: &[usize], columns: &[usize]) -> Self {
        self.with(|request| {
            request.u.corners = Some(Corners::At(rows.into()));
            if let Some(v) = &mut request.v {
                v.corners = Some(Corners::At(columns.into()));
            }
        })
    }
}

impl<S: Shape> Fit<S> {
    fn of(request: Result<Request, Invalid>) -> Self {
        let shape = PhantomData;
        Self { request, shape }
    }

    fn with(mut self, change: impl FnOnce(&mut Request)) -> Self {
        if let Ok(request) = &mut self.request {
            change(request);
        }
        self
    }

    /// The degree of B-splines; default: 3.
    pub fn degree(self, degree: usize) -> Self {
        let basis = || BasisChoice::BSpline {
            degree,
            knots: Knots::Usual,
        };
        self.with(|request| {
            request.u.basis = basis();
            request.v.iter_mut().for_each(|it| it.basis = basis());
        })
    }

    /// The method; default: classical PIA.
    pub fn method(self, method: Method) -> Self {
        self.with(|request| request.method = method)
    }

    /// Least squares with as few control points as the tolerance needs.
    pub fn fewest_control_points(self) -> Self {
        let settings = LeastSquares::automatic(AS_MANY_AS_DATA, AS_MANY_AS_DATA);
        self.method(Method::LeastSquares(settings))
    }

    /// Least squares without outliers: points that are far from where their neighbours predict them.
    pub fn robust(self) -> Self {
        self.with(|request| {
            if let Method::LeastSquares(settings) = &mut request.method {
                settings.robust = true;
            }
        })
    }

    /// Positive weights, one for each data point: the fit is rational, in homogeneous coordinates (Lin 2010, 2.1).
    pub fn weights(self, weights: Vec<f64>) -> Self {
        self.with(|request| request.weights = Weights::Homogeneous(weights))
    }

    /// The largest allowed distance from a data point, in the unit of the data.
    pub fn tolerance(self, tolerance: f64) -> Self {
        self.with(|request| request.tolerance = Some(Tolerance::Absolute(tolerance)))
    }

    /// The most iterations; default: 1000.
    pub fn max_iterations(self, count: usize) -> Self {
        self.with(|request| request.max_iterations = count)
    }

    /// Validates the request, and computes the collocation matrix and the transform of the method.
    ///
    /// # Errors
    ///
    /// The first validation error, with its location and reason.
    pub fn prepare(self) -> Result<Prepared<S>, Invalid> {
        let problem = trimmed(Problem::new(self.request?)?)?;
        Ok(Prepared {
            system: Arc::new(System::new(Arc::new(problem))),
            shape: PhantomData,
        })
    }
}

/// A fit that is ready to be iterated. Iterations share it.
#[derive(Clone, Debug)]
pub struct Prepared<S> {
    system: Arc<System>,
    shape: PhantomData<fn() -> S>,
}

impl<S: Shape> Prepared<S> {
    /// The parameters of the data points of a curve, or of the rows of a surface.
    pub fn parameters(&self) -> &[f64] {
        &self.system.problem().u().parameters
    }

    /// The levels of the fit, from level 0 to the last one. Each is computed on demand.
    pub fn levels(&self) -> Levels<S> {
        Levels {
            iteration: None,
            system: Arc::clone(&self.system),
            shape: PhantomData,
        }
    }

    /// The last level, if it is within the tolerance; of least squares without a tolerance also the minimum.
    ///
    /// # Errors
    ///
    /// The nearest level, if the fit ends before it is within the tolerance.
    pub fn solve(&self) -> Result<S, NotConverged<S>> {
        let mut iteration = Iteration::start(Arc::clone(&self.system));
        let mut nearest: Level<S> = Level::of(&iteration);
        loop {
            let outcome = iteration.outcome();
            if has_converged(outcome) {
                return Ok(Level::of(&iteration).shape());
            }
            if iteration.level().error.max < nearest.error.max {
                nearest = Level::of(&iteration);
            }
            if outcome.is_some() {
                let between = matches!(outcome, Some(Outcome::Stalled(Reason::Between)));
                return Err(NotConverged {
                    best: nearest.shape(),
                    error: nearest.error,
                    between: between.then(|| iteration.excess()),
                    iterations: iteration.level().iteration,
                });
            }
            iteration.step();
        }
    }
}

fn has_converged(outcome: Option<Outcome>) -> bool {
    matches!(outcome, Some(Outcome::Converged | Outcome::Minimum))
}

/// The levels of a fit.
#[derive(Debug)]
pub struct Levels<S> {
    system: Arc<System>,
    /// None before level 0.
    iteration: Option<Iteration>,
    shape: PhantomData<fn() -> S>,
}

impl<S: Shape> Iterator for Levels<S> {
    type Item = Level<S>;

    fn next(&mut self) -> Option<Level<S>> {
        let iteration = match &mut self.iteration {
            Some(iteration) => {
                if iteration.outcome().is_some() {
                    return None;
                }
                iteration.step();
                iteration
            }
            none => none.insert(Iteration::start(Arc::clone(&self.system))),
        };
        Some(Level::of(iteration))
    }
}

impl<S: Shape> FusedIterator for Levels<S> {}

/// A level of a fit: a curve or surface after some updates.
#[derive(Clone, Debug)]
pub struct Level<S> {
    /// The number of updates.
    pub iteration: usize,
    /// The distances from the data, in their unit.
    pub error: FitError,
    /// True if the fit ends at this level.
    pub is_last: bool,
    /// True if it ends within its tolerance; of least squares without a tolerance also at the minimum.
    pub has_converged: bool,
    problem: Arc<Problem>,
    control_points: Arc<Points>,
    shape: PhantomData<fn() -> S>,
}

impl<S: Shape> Level<S> {
    fn of(iteration: &Iteration) -> Self {
        let (level, outcome) = (iteration.level(), iteration.outcome());
        Self {
            iteration: level.iteration,
            error: level.error,
            is_last: outcome.is_some(),
            has_converged: has_converged(outcome),
            problem: Arc::clone(iteration.problem()),
            control_points: iteration.shared_control_points(),
            shape: PhantomData,
        }
    }

    fn shape(&self) -> S {
        S::of(&self.problem, &self.control_points, self.error)
    }
}

impl<S> Level<S> {
    /// The fitted problem, for piad-files.
    #[doc(hidden)]
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// The free control points, for piad-files; in homogeneous coordinates if the fit is.
    #[doc(hidden)]
    pub fn control_points(&self) -> &Arc<Points> {
        &self.control_points
    }
}

impl Level<Curve> {
    /// The curve of this level.
    pub fn curve(&self) -> Curve {
        self.shape()
    }
}

impl Level<Surface> {
    /// The surface of this level.
    pub fn surface(&self) -> Surface {
        self.shape()
    }
}

/// A fit has ended outside its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct NotConverged<S> {
    /// The nearest curve or surface.
    pub best: S,
    /// Its distances from the data, in their unit.
    pub error: FitError,
    /// If it is within the tolerance only at the data: the largest deviation between neighbours.
    pub between: Option<f64>,
    /// The number of iterations that were computed.
    pub iterations: usize,
}

impl<S> fmt::Display for NotConverged<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (iterations, left) = (self.iterations, self.error.max);
        match self.between {
            Some(between) => write!(
                f,
                "after {iterations} iterations it is within the tolerance at the data, and leaves them by {between:.3e} \
                 between neighbours"
            ),
            None => write!(
                f,
                "after {iterations} iterations a distance of {left:.3e} is left, which is more than the tolerance"
            ),
        }
    }
}

impl<S: fmt::Debug> std::error::Error for NotConverged<S> {}
