//! The interface of a method to the rest of the crate.
//!
//! Functions are called once for each fit, or once for each level, never for each point. In the
//! order in which they are called:
//!
//! 1. `check` the settings, when nothing has been computed;
//! 2. `check_convergence`, when the bases are known; `demand` and costs, for admission;
//! 3. `forecast`, `transform`, `complete`, when the collocation matrix is there;
//! 4. `start`, `update` and `relaxation`, when the iteration begins;
//! 5. `stop`, at every level.

use std::fmt::Debug;
use std::sync::Arc;

use super::equations::Equations;
use super::plain::Plain;
use super::relaxation::Relaxation;
use super::update::Update;
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::points::Points;
use crate::geometry::norms::FitError;
use crate::invalid::Invalid;
use crate::kind_info::KindInfo;
use crate::matrix::forecast::Forecast;
use crate::matrix::tensor::Tensor;
use crate::matrix::transform::Transform;
use crate::setup::Setup;
use crate::termination::Outcome;
use crate::warning::Warning;

/// What the settings of a method are checked against, before anything has been computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope<'a> {
    /// The arrangement of the data points.
    pub grid: Grid,
    /// True if there is a second direction.
    pub is_surface: bool,
    /// True if the points of the surface are scattered: they are in a grid of one column.
    pub is_scattered: bool,
    /// The number of coordinates of the data points.
    pub dimension: usize,
    /// True if the fit is made in homogeneous coordinates.
    pub is_homogeneous: bool,
    /// The indices of the control points that may move, if they were given.
    pub selected: Option<&'a [usize]>,
}

/// The memory of a method besides data, control points and residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Demand {
    /// Vectors with as many points as the data.
    pub vectors: usize,
    /// Matrices as large as the collocation matrix, that one included.
    pub matrices: usize,
    /// Bytes besides.
    pub bytes: usize,
}

impl Default for Demand {
    /// A vector, and factorizations for λ_min.
    fn default() -> Self {
        Self {
            vectors: 1,
            matrices: 4,
            bytes: 0,
        }
    }
}

/// The errors so far, for the stop rule of a method.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// The number of updates.
    pub iteration: usize,
    /// The length of the residual at level 0, up to a factor.
    pub first_length: f64,
    /// The length of the residual at the current level, up to the same factor.
    pub length: f64,
    /// The relative decrease of that length in the last update.
    pub decrease: f64,
}

/// A method: how the control points of level 0 are chosen, how they move (the transform U of
/// `X ← X + U (P − B X)`), when to stop, and what is known beforehand. Functions are called once
/// for each fit, or for each level; the loops over points are in [`Update`] and the sweeps.
pub(crate) trait Algorithm: Debug {
    /// Its entry in the table of methods.
    fn info(&self) -> &'static KindInfo;

    /// Refuses settings that are out of their range, or not for a fit like this.
    ///
    /// # Errors
    ///
    /// The setting that is wrong, with its value and the rule.
    fn check(&self, _scope: &Scope<'_>) -> Result<(), Invalid> {
        Ok(())
    }

    /// Refuses fits that cannot converge, `ρ(I − U B) ≥ 1`, as far as that is known.
    ///
    /// # Errors
    ///
    /// The rate at which the error would grow, or what is missing for a forecast.
    fn check_convergence(&self, _setup: &Setup) -> Result<(), Invalid> {
        Ok(())
    }

    /// The numbers of control points in both directions, if there are fewer of them than data
    /// points.
    fn control_points(&self) -> Option<(usize, usize)> {
        None
    }

    /// Returns true if data points of the grid may be missing.
    fn fits_holes(&self) -> bool {
        false
    }

    /// Returns true if the points of a surface may be scattered.
    fn fits_scattered(&self) -> bool {
        false
    }

    /// The largest distance at which the fit may end, in data units, if this tolerance is
    /// requested.
    fn tolerance(&self, requested: f64) -> f64 {
        requested
    }

    /// Its memory.
    fn demand(&self) -> Demand {
        Demand::default()
    }

    /// The multiplications of a level besides those of its residual, as far as they matter.
    fn step_cost(&self, _setup: &Setup) -> usize {
        0
    }

    /// The multiplications before the first level besides those of the collocation matrix and its
    /// factorization, as far as they matter.
    fn start_cost(&self, _setup: &Setup) -> usize {
        0
    }

    /// The forecast before the first step. It may take as long as some factorizations of the
    /// collocation matrix.
    fn forecast(&self, _setup: &Setup, _collocation: &Tensor) -> Forecast {
        Forecast::default()
    }

    /// The transform U, as far as it is a fixed linear map.
    fn transform(&self, _collocation: &Tensor, _forecast: &Forecast) -> Transform {
        Transform::Scale(1.0)
    }

    /// Adds to the forecast what only the transform or a trial run shows. It may change the steps
    /// that the forecast assumes.
    fn complete(&self, _equations: &mut Equations) {}

    /// The control points of level 0, unless they were given: those of most methods are the data.
    fn start(&self, equations: &Equations) -> Arc<Points> {
        Arc::clone(equations.setup.data())
    }

    /// How the plain loop moves the control points, before the first update.
    fn update(&self, equations: &Equations) -> Box<dyn Update>;

    /// How a sweep moves them, if it can: where the step of a control point is a multiple of its
    /// own adjusting vector and of its last step, or a transform of all adjusting vectors together.
    fn relaxation(&self, _equations: &Equations) -> Option<Relaxation> {
        None
    }

    /// The indices of the control points that may move, increasing, if others never do.
    fn adjusted(&self, _setup: &Setup) -> Option<Vec<usize>> {
        None
    }

    /// Returns true if errors fall towards zero, so that their decay predicts the end.
    fn decays(&self) -> bool {
        true
    }

    /// Returns true if fits end although errors never reach a tolerance of zero.
    fn ends_by_itself(&self) -> bool {
        false
    }

    /// Returns true if the rate of the forecast is that of the long run, rather than a bound.
    fn rate_is_sharp(&self) -> bool {
        true
    }

    /// Returns true if the level `exact_after` of the forecast is where the fit ends, but for
    /// rounding.
    fn ends_when_exact(&self) -> bool {
        false
    }

    /// The first level at which the fit may end within the tolerance: a method that solves for its
    /// limit takes its step although the data are near enough as control points.
    fn first_end(&self) -> usize {
        0
    }

    /// The outcome if the fit ends for a reason of the method's own: it is neither within the
    /// tolerance nor at the last allowed level.
    fn stop(&self, _progress: &Progress) -> Option<Outcome> {
        None
    }

    /// Warnings by the forecast, if the fit is predicted to end at level `predicted`, and ends at
    /// level `iterations` at the latest.
    fn warnings(
        &self,
        _forecast: &Forecast,
        _predicted: Option<usize>,
        _iterations: usize,
    ) -> Vec<Warning> {
        Vec::new()
    }
}

impl dyn Algorithm + '_ {
    /// The control points of level 0: given ones, or those of the method.
    pub(crate) fn level_zero(&self, equations: &Equations) -> Arc<Points> {
        match equations.setup.start() {
            Some(start) => Arc::clone(start),
            None => self.start(equations),
        }
    }

    /// Level 0 of the plain loop from these control points, and its error.
    pub(crate) fn plain(
        &self,
        equations: &Equations,
        control_points: Arc<Points>,
    ) -> (Plain, FitError) {
        let counted = self.counted(&equations.setup);
        Plain::start(equations, self.update(equations), control_points, counted)
    }

    /// Which data points count for the error of a fit: the adjusted ones if others never move, else
    /// all that there are.
    fn counted(&self, setup: &Setup) -> Option<Vec<bool>> {
        let Some(adjusted) = self.adjusted(setup) else {
            return setup.missing().map(Missing::present);
        };
        let mut counted = vec![false; setup.grid().count()];
        for index in adjusted {
            counted[index] = true;
        }
        Some(counted)
    }
}
