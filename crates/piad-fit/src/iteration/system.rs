//! A problem ready to be iterated.
//!
//! Making one takes most of the time before the first level: the collocation matrix, the transform
//! of the method, and the forecast. Iterations of the same problem share it, for all readers.

use std::sync::{Arc, OnceLock};

use crate::data::points::Points;
use crate::matrix::forecast::Prediction;
use crate::matrix::operator::Operator;
use crate::matrix::transform::Transform;
use crate::method::equations::Equations;
use crate::problem::Problem;

use crate::matrix::forecast::Forecast;

/// A problem ready to be iterated: with its collocation matrix, its transform, and the forecast of
/// its convergence. Iterations of the same problem share one.
#[derive(Debug)]
pub struct System {
    problem: Arc<Problem>,
    equations: Equations,
    /// Where the fit will end, once that has been computed.
    prediction: OnceLock<Option<Prediction>>,
}

impl System {
    /// Evaluates the collocation matrix and prepares the transform: for B-splines in O(n p²), for
    /// polynomials in up to O(n³).
    pub fn new(problem: Arc<Problem>) -> Self {
        let collocation = problem.collocation();
        Self::with(problem, collocation)
    }

    /// Like [`new`](Self::new), but shares the collocation matrix of `other` if it is the same.
    pub fn like(problem: Arc<Problem>, other: &Self) -> Self {
        let alike = problem.is_scattered() == other.problem.is_scattered();
        if alike && problem.directions().eq(other.problem.directions()) {
            Self::with(problem, other.equations.collocation.clone())
        } else {
            Self::new(problem)
        }
    }

    /// Prepares the transform and the forecast of the method.
    fn with(problem: Arc<Problem>, collocation: Operator) -> Self {
        let method = problem.method().algorithm();
        let setup = Arc::clone(problem.setup());
        // Methods of scattered points have no fixed transform, and no forecast.
        let (forecast, transform) = match collocation.tensor() {
            None => (Forecast::default(), Transform::Scale(1.0)),
            Some(tensor) => {
                let forecast = method.forecast(&setup, tensor);
                (forecast, method.transform(tensor, &forecast))
            }
        };
        let mut equations = Equations {
            transform,
            setup,
            collocation,
            forecast,
        };
        method.complete(&mut equations);
        Self {
            problem,
            equations,
            prediction: OnceLock::new(),
        }
    }

    /// The problem.
    pub fn problem(&self) -> &Arc<Problem> {
        &self.problem
    }

    /// What updates work with.
    pub(crate) fn equations(&self) -> &Equations {
        &self.equations
    }

    /// The collocation matrix.
    pub fn collocation(&self) -> &Operator {
        &self.equations.collocation
    }

    /// The forecast of the convergence.
    pub fn forecast(&self) -> Forecast {
        self.equations.forecast
    }

    /// The control points of level 0: given ones, or those of the method.
    pub fn start(&self) -> Arc<Points> {
        self.problem
            .method()
            .algorithm()
            .level_zero(&self.equations)
    }

    /// Finds out where the fit will end, unless that is known.
    pub(crate) fn predict(self: &Arc<Self>, look: impl FnOnce(&Arc<Self>) -> Option<Prediction>) {
        self.prediction.get_or_init(|| look(self));
    }

    /// Where the fit will end, if that was found out.
    pub(crate) fn prediction(&self) -> Option<Prediction> {
        self.prediction.get().copied().flatten()
    }
}
