//! The loop `X ← X + U (P − B X)`, its errors and its stop rules.
//!
//! A level is reported with its errors, and the next one is computed on demand. Two engines compute levels, with the
//! same bits: the plain loop, for every method and basis, and sweeps, for long banded data. A third one is for fits
//! that choose their knots.
//!
//! An iteration ends at the first level at which one of these is true:
//!
//! | rule | outcome |
//! |---|---|
//! | the residual is not finite | overflow |
//! | the largest distance is within the tolerance, and the method has nothing left to do | converged |
//! | the stop rule of the method | at a minimum, or stalled |
//! | the update of the method can do no more | stalled |
//! | the last allowed level is reached | exhausted |
//!
//! An iterate is a pure function of the problem and the level: nothing random, nothing that depends
//! on time or on the number of threads.

mod automatic;
pub(crate) mod bases;
mod convergence;
mod decay;
mod ending;
pub(crate) mod limit;
pub(crate) mod sweep;
pub(crate) mod system;

use std::sync::{Arc, OnceLock};

use super::method::update::Update;
use super::problem::Problem;
use super::warning::Warning;
use crate::data::points::Points;
use crate::geometry::between::Excursion;
use crate::geometry::evaluation::Geometry;
use crate::geometry::fold::Fold;
use crate::geometry::norms::FitError;
use crate::matrix::forecast::Prediction;
use crate::method::plain::Plain;
use automatic::Automatic;
use decay::Decay;
use sweep::{Measured, Sweep};
use system::System;

/// Between data a fit may be further away than at them by this factor.
const MORE_BETWEEN: f64 = 2.0;

/// A level of the iteration: how far the curve of these control points is from the data.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Level {
    /// The number of updates so far.
    pub iteration: usize,
    /// The distances from the data.
    pub error: FitError,
    /// The largest distance as a multiple of that of the level before.
    pub rate: Option<f64>,
    /// The number of control points that the last update moved.
    pub moved: usize,
    /// Homogeneous fits: the first control point whose weight is not positive, and that weight.
    pub bad_weight: Option<(usize, f64)>,
    /// The predicted last level, as of this level.
    pub predicted: Option<usize>,
    /// At the last level of curves and grids: by how much it leaves its data between neighbours, beyond the freedom that
    /// these leave, in data units.
    pub between: Option<f64>,
    /// At the last level: warnings about deviations that the data do not show.
    pub found: Option<Warning>,
}

/// The iteration of one problem at some level.
#[derive(Debug)]
pub struct Iteration {
    system: Arc<System>,
    engine: Engine,
    level: Level,
    /// The length of the residual at level 0, up to a factor.
    first_length: f64,
    /// The length of the residual at the current level, up to the same factor.
    length: f64,
    /// The relative decrease of that length in the last update.
    decrease: f64,
    /// The errors of the levels so far, for the prediction.
    decay: Decay,
    /// Where this level leaves its data between neighbours, once that has been computed.
    excursion: OnceLock<Option<Excursion>>,
}

/// Who computes the levels.
#[derive(Debug)]
enum Engine {
    Plain(Box<Plain>),
    Sweep(Box<Sweep>),
    Automatic(Box<Automatic>),
}

impl Iteration {
    /// Level 0, without a prediction of where the fit will end, which takes as long as a short fit itself: its levels are
    /// the same, but for [`Level::predicted`]. It takes a sweep if the problem and its method have one.
    pub fn start_unpredicted(system: Arc<System>) -> Self {
        if let Some(automatic) = Automatic::start(system.problem()) {
            let error = automatic.error();
            return Self::begin(
                system,
                Engine::Automatic(Box::new(automatic)),
                error,
                error.rms,
            );
        }
        let control_points = system.start();
        match Sweep::start(&system, control_points) {
            Ok(begun) => Self::with_sweep(system, begun),
            Err(control_points) => Self::with_plain(system, control_points),
        }
    }

    /// Level 0 of the plain loop, which sweeps are measured by, for tests and benches.
    pub fn start_plain(system: Arc<System>) -> Self {
        if system.problem().is_automatic() {
            return Self::start_unpredicted(system);
        }
        let control_points = system.start();
        Self::with_plain(system, control_points)
    }

    /// Level 0 of the plain loop from these control points.
    fn with_plain(system: Arc<System>, control_points: Arc<Points>) -> Self {
        let method = system.problem().method().algorithm();
        let (plain, error) = method.plain(system.equations(), control_points);
        let length = plain.residual_length();
        Self::begin(system, Engine::Plain(Box::new(plain)), error, length)
    }

    /// The level at which a sweep has begun.
    pub(super) fn with_sweep(
        system: Arc<System>,
        (sweep, (error, length)): (Sweep, Measured),
    ) -> Self {
        Self::begin(system, Engine::Sweep(Box::new(sweep)), error, length)
    }

    /// Level 0 with what an engine has measured.
    fn begin(system: Arc<System>, engine: Engine, error: FitError, length: f64) -> Self {
        let mut iteration = Self {
            system,
            engine,
            level: Level {
                iteration: 0,
                error,
                rate: None,
                moved: 0,
                bad_weight: None,
                predicted: None,
                between: None,
                found: None,
            },
            first_length: length,
            length,
            decrease: 1.0,
            decay: Decay::default(),
            excursion: OnceLock::new(),
        };
        iteration.decay.record(0, error.max);
        iteration.level.bad_weight = iteration.bad_weight();
        iteration.level.predicted = iteration.predicted();
        iteration
    }

    /// A copy of the iteration at its level, which continues with the same bits. `None` for fits that choose their
    /// knots: their search state is too large to copy.
    pub fn copy(&self) -> Option<Self> {
        let engine = match &self.engine {
            Engine::Plain(plain) => Engine::Plain(Box::new(plain.copy())),
            Engine::Sweep(sweep) => Engine::Sweep(sweep.clone()),
            Engine::Automatic(_) => return None,
        };
        Some(Self {
            system: Arc::clone(&self.system),
            engine,
            decay: self.decay.clone(),
            excursion: self.excursion.clone(),
            ..*self
        })
    }

    /// What does not change from level to level.
    pub fn system(&self) -> &Arc<System> {
        &self.system
    }

    /// The current level.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The free control points of the current level, in homogeneous coordinates if the fit is: one
    /// point of R^d, or of R^(d+1), for each place of the problem's control grid, row by row.
    pub fn control_points(&self) -> &Points {
        match &self.engine {
            Engine::Plain(plain) => plain.control_points(),
            Engine::Sweep(sweep) => sweep.control_points(),
            Engine::Automatic(automatic) => automatic.control_points(),
        }
    }

    /// The problem with the bases of the current level: that of the system, unless the fit chooses its knots.
    pub fn problem(&self) -> &Arc<Problem> {
        match &self.engine {
            Engine::Automatic(automatic) => automatic.problem(),
            Engine::Plain(_) | Engine::Sweep(_) => self.system.problem(),
        }
    }

    /// The level from which on the bases are what they are at the current one.
    pub fn knots_since(&self) -> usize {
        match &self.engine {
            Engine::Automatic(automatic) => automatic.knots_since(),
            Engine::Plain(_) | Engine::Sweep(_) => 0,
        }
    }

    /// Shares the control points, which stay while the iteration continues. The plain loop copies them, a sweep shares
    /// them.
    pub fn shared_control_points(&self) -> Arc<Points> {
        match &self.engine {
            Engine::Plain(plain) => Arc::new(plain.control_points().clone()),
            Engine::Sweep(sweep) => Arc::clone(sweep.control_points()),
            Engine::Automatic(automatic) => Arc::clone(automatic.control_points()),
        }
    }

    /// Takes shared control points back, to reuse their memory if nothing else holds them.
    pub fn take_back(&mut self, control_points: Arc<Points>) {
        if let Engine::Sweep(sweep) = &mut self.engine {
            sweep.take_back(control_points);
        }
    }

    /// How the plain loop moves control points; `None` for sweeps.
    fn update(&self) -> Option<&dyn Update> {
        match &self.engine {
            Engine::Plain(plain) => Some(plain.update()),
            Engine::Sweep(_) | Engine::Automatic(_) => None,
        }
    }

    /// The free control points that the last step moved, where it left others alone. All others are
    /// to the last bit what they were a level before.
    pub fn moved(&self) -> Option<&[usize]> {
        let moved = self.update()?.moved()?;
        let some = self.level.iteration > 0 && moved.len() < self.control_points().len();
        some.then_some(moved)
    }

    /// `Δ = P − B X`, where the plain loop computes it.
    pub fn residual(&self) -> Option<&Points> {
        match &self.engine {
            Engine::Plain(plain) => Some(plain.residual()),
            Engine::Sweep(_) | Engine::Automatic(_) => None,
        }
    }

    /// Moves on to the next level, whatever the outcome of the current one.
    pub fn step(&mut self) -> Level {
        let system = &self.system;
        let (moved, (error, length)) = match &mut self.engine {
            Engine::Plain(plain) => {
                let (moved, error) = plain.step(system.equations());
                (moved, (error, plain.residual_length()))
            }
            Engine::Sweep(sweep) => {
                let measured = sweep.step(system);
                (sweep.control_points().len(), measured)
            }
            Engine::Automatic(automatic) => {
                let (moved, error) = automatic.step();
                (moved, (error, error.rms))
            }
        };
        self.reach(moved, error, length);
        self.level
    }

    /// Advances by `count` levels, or to the first one at which the iteration ends, and visits each of them. The
    /// control points of the levels between are not visible, so that several levels can be computed at once. They are
    /// the same as by single steps, to the last bit.
    pub fn steps(&mut self, count: usize, visit: &mut impl FnMut(Level)) {
        let mut left = count;
        while left > 0 {
            let at_once = self.at_once(left);
            if at_once > 1 {
                left -= self.pass(at_once, visit);
            } else {
                visit(self.step());
                left -= 1;
            }
            if self.outcome().is_some() {
                return;
            }
        }
    }

    /// The number of levels to compute in one pass: not far beyond the one at which the fit will be within the
    /// tolerance if the error keeps shrinking as in the last step.
    fn at_once(&self, left: usize) -> usize {
        let Engine::Sweep(sweep) = &self.engine else {
            return 1;
        };
        let problem = self.system.problem();
        let allowed = problem
            .max_iterations()
            .saturating_sub(self.level.iteration);
        let ratio = problem.tolerance() / self.level.error.max;
        let expected = self.level.rate.map(|rate| (ratio.ln() / rate.ln()).ceil());
        let expected = expected
            .filter(|&count| count >= 1.0)
            .unwrap_or(f64::INFINITY);
        sweep.levels().min(left).min(allowed).min(expected as usize)
    }

    /// At the last level, measures the deviation between its data, and the obstacles to its tolerance.
    pub fn look_closer(&mut self) {
        let problem = self.problem();
        let fold = || match self.level.error.max > problem.tolerance() {
            true => Fold::of(problem),
            false => None,
        };
        let between = self.leaving().map(Warning::Between);
        let found = between.or_else(|| fold().map(Warning::Folded));
        let excess = self.excess();
        self.level.between = (!problem.is_scattered() && excess.is_finite()).then_some(excess);
        self.level.found = found;
    }

    /// Where this level is furthest from its data between neighbours, beyond their freedom.
    fn excursion(&self) -> Option<Excursion> {
        *self
            .excursion
            .get_or_init(|| Excursion::of(self.problem(), self.control_points(), self.allowed()))
    }

    /// By how much it leaves them there.
    pub(crate) fn excess(&self) -> f64 {
        self.excursion().map_or(0.0, Excursion::excess)
    }

    /// The same, if it is further away than it may be.
    pub(super) fn leaving(&self) -> Option<Excursion> {
        let allowed = self.allowed();
        self.excursion().filter(|it| it.excess() > allowed)
    }

    /// How far beyond the freedom of its data a fit may be: the tolerance, or what it is from them; a little further between
    /// two data points than at both.
    fn allowed(&self) -> f64 {
        let FitError { max, fixed_max, .. } = self.level.error;
        let at_data = fixed_max.unwrap_or(max).max(max);
        self.problem().tolerance().max(MORE_BETWEEN * at_data)
    }

    /// Computes several levels in one pass over memory, and returns how many were taken: fewer, if
    /// the fit ends between.
    fn pass(&mut self, count: usize, visit: &mut impl FnMut(Level)) -> usize {
        let Engine::Sweep(sweep) = &mut self.engine else {
            return 0;
        };
        sweep.steps(&self.system, count);
        for index in 0..count {
            let Engine::Sweep(sweep) = &self.engine else {
                return index;
            };
            let (error, length) = sweep.measured(index);
            self.reach(sweep.control_points().len(), error, length);
            visit(self.level);
            // Control points are those of the last of these levels.
            if self.outcome_at_data().is_some() && index + 1 < count {
                if let Engine::Sweep(sweep) = &mut self.engine {
                    sweep.retake(&self.system, count, index + 1);
                }
                return index + 1;
            }
        }
        count
    }

    /// Notes that another level is reached, with its errors.
    fn reach(&mut self, moved: usize, error: FitError, length: f64) {
        self.decrease = if self.length > 0.0 {
            1.0 - length / self.length
        } else {
            0.0
        };
        self.length = length;
        let rate = error.max / self.level.error.max;
        self.level = Level {
            iteration: self.level.iteration + 1,
            error,
            rate: rate.is_finite().then_some(rate),
            moved,
            bad_weight: self.bad_weight(),
            predicted: None,
            between: None,
            found: None,
        };
        self.excursion = OnceLock::new();
        self.decay.record(self.level.iteration, error.max);
        self.level.predicted = self.predicted();
    }

    /// The level at which the fit will end: as was found out beforehand, else by how its errors
    /// fall.
    fn predicted(&self) -> Option<usize> {
        let Level {
            iteration, error, ..
        } = self.level;
        let problem = self.system.problem();
        if let Engine::Automatic(automatic) = &self.engine {
            return automatic.outcome().map(|_| iteration);
        }
        if self.is_within() {
            return Some(iteration);
        }
        match self.system.prediction() {
            Some(Prediction::End(level)) => Some(level).filter(|level| *level > iteration),
            Some(Prediction::Estimate { end, seen }) if iteration <= seen => Some(end),
            _ => self.end_of_decay().or_else(|| {
                let forecast = self.system.forecast();
                let left = forecast.iterations_of_block(error.max, problem.tolerance())?;
                Some(iteration + left)
            }),
        }
    }

    /// The level at which the errors will be within the tolerance if they keep falling at the current rate.
    pub(super) fn end_of_decay(&self) -> Option<usize> {
        let problem = self.system.problem();
        let method = problem.method().algorithm();
        if !method.decays() || problem.tolerance() <= 0.0 {
            return None;
        }
        let Level {
            iteration, error, ..
        } = self.level;
        let slowest = self.system.forecast().rate;
        let slowest = slowest.filter(|_| method.rate_is_sharp());
        self.decay
            .end(iteration, error.max, problem.tolerance(), slowest)
    }

    /// Homogeneous fits: the first control point whose weight is not positive. It has no place, or
    /// the curve may leave the convex hull of its control points.
    fn bad_weight(&self) -> Option<(usize, f64)> {
        Geometry::new(self.problem(), self.control_points()).bad_weight()
    }
}
