//! The engine of fits that choose their knots by themselves ([`super::tolerance`]).
//!
//! Levels come from a schedule. Each has knots of its own, and so a problem of its own: that of the
//! fit with other directions. One level is computed ahead, as only then is known whether a level is
//! the last one.
//!
//! A fit that is within the tolerance at its data and far from them in between continues with a second schedule
//! ([`careful`]).

mod careful;

use std::sync::Arc;

use self::careful::{FAR, NEAR};
use super::construction::first_line;
use super::direction::{BasisChoice, Direction, DirectionChoice};
use super::interrupt;
use super::invalid::{Axis, Invalid};
use super::method::{Automatic as Settings, LeastSquares, Obeying, ObeyingSurface};
use super::norms::FitError;
use super::points::{Grid, Points};
use super::problem::Problem;
use super::request::Request;
use super::setup::Setup;
use super::termination::{Outcome, Reason};
use super::tolerance::distances::Distances;
use super::tolerance::equations::{self, Minimum};
use super::tolerance::guide::Guide;
use super::tolerance::line::KnotLine;
use super::tolerance::placed::{in_directions, in_lines};
use super::tolerance::schedule::Schedule;
use super::tolerance::surface::{Data, GridData, ScatteredData, SurfaceOptions, SurfaceSchedule};
use super::tolerance::values::{MANY, Values};
use super::tolerance::{Level, Options};

/// The fit at some level, and the schedule that leads on.
#[derive(Debug)]
pub(super) struct Automatic {
    whole: Arc<Problem>,
    schedule: Schedules,
    now: Fit,
    next: Option<Fit>,
    /// The number of the level, and that of the level at which the knots became what they are.
    number: usize,
    knots_since: usize,
    /// True if the last level is far from its data where there are none.
    leaves: bool,
}

/// A B-spline of a schedule.
#[derive(Debug)]
struct Fit {
    problem: Arc<Problem>,
    control_points: Arc<Points>,
    error: FitError,
}

/// The schedules that there are.
#[derive(Debug)]
enum Schedules {
    /// With points between the data, or without.
    Curve(Box<Schedule<equations::LeastSquares>>, Option<Guide>),
    Obeying(Box<Schedule<Obeying>>),
    Surface(Box<SurfaceSchedule>),
    /// With some fairness where none was asked for.
    FairSurface(Box<SurfaceSchedule>),
    /// Not even the first level has finite numbers.
    Nowhere,
}

impl Automatic {
    /// Level 0 of an automatic fit; `None` of any other.
    pub(super) fn start(problem: &Arc<Problem>) -> Option<Self> {
        let (settings, automatic) = problem.method().automatic()?;
        let mut schedule = Schedules::new(problem, settings, automatic);
        let now = schedule.next(problem).unwrap_or_else(|| {
            // Not even the first level has finite numbers.
            let count = problem.control_grid().count();
            let nowhere = Points::zeros(problem.dimension(), count);
            Fit {
                problem: Arc::clone(problem),
                control_points: Arc::new(nowhere),
                error: FitError::unknown(),
            }
        });
        let mut automatic = Self {
            whole: Arc::clone(problem),
            schedule,
            now,
            next: None,
            number: 0,
            knots_since: 0,
            leaves: false,
        };
        automatic.next = automatic.following();
        Some(automatic)
    }

    /// Returns true if fewer control points than data are allowed.
    fn is_limited(&self) -> bool {
        let settings = self.whole.method().automatic();
        settings.is_some_and(|(settings, _)| settings.u < self.whole.grid().rows)
    }

    /// The level after this one: of another schedule where this one has ended with a fit that leaves its data.
    fn following(&mut self) -> Option<Fit> {
        if let Some(next) = self.schedule.next(&self.whole) {
            return Some(next);
        }
        if self.schedule.outcome() != Some(Outcome::Converged) {
            return None;
        }
        if !self.schedule.is_careful()
            && self.now.leaves(NEAR)
            && let Some(careful) = self.schedule.careful(&self.whole, &self.now)
        {
            (self.schedule, self.leaves) = (careful, true);
            return self.schedule.next(&self.whole);
        }
        self.leaves = self.now.leaves(FAR);
        None
    }

    /// Moves on, unless this is the last level: how many control points there are now, and how far
    /// they are from the data.
    pub(super) fn step(&mut self) -> (usize, FitError) {
        if let Some(next) = self.next.take() {
            self.number += 1;
            let (new, old) = (next.problem.directions(), self.now.problem.directions());
            if !new.map(|it| &it.basis).eq(old.map(|it| &it.basis)) {
                self.knots_since = self.number;
            }
            self.now = next;
            self.next = self.following();
        }
        (self.now.control_points.len(), self.now.error)
    }

    /// The fit with the knots, and the parameters, of this level.
    pub(super) fn problem(&self) -> &Arc<Problem> {
        &self.now.problem
    }

    /// The control points of this level.
    pub(super) fn control_points(&self) -> &Arc<Points> {
        &self.now.control_points
    }

    /// How far they are from the data.
    pub(super) fn error(&self) -> FitError {
        self.now.error
    }

    /// The level from which on the knots are what they are now.
    pub(super) fn knots_since(&self) -> usize {
        self.knots_since
    }

    /// How the fit ends, if this is its last level.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        let over = self.next.is_none();
        over.then(|| match self.schedule.outcome() {
            Some(Outcome::Converged) if self.leaves => Outcome::Stalled(Reason::Between),
            // It would be within the tolerance at its data alone.
            Some(Outcome::Minimum) if self.leaves => Outcome::Stalled(Reason::Between),
            Some(Outcome::Exhausted) if self.leaves && !self.is_limited() => {
                Outcome::Stalled(Reason::Between)
            }
            outcome => outcome.unwrap_or(Outcome::Overflow),
        })
    }
}

impl Schedules {
    fn new(problem: &Problem, settings: &LeastSquares, automatic: &Settings) -> Self {
        let points = Arc::clone(problem.data());
        let lines: Vec<KnotLine> = problem.directions().filter_map(KnotLine::of).collect();
        let first = problem.start().map(|start| in_lines(start, &lines));
        let u = problem.u();
        if let Some(v) = problem.v() {
            let parameters = [u, v].map(|it| Arc::clone(&it.parameters));
            let tolerance = problem.tolerance();
            let data: Box<dyn Data> = match problem.is_scattered() {
                _ if !settings.is_plain_surface() => {
                    Box::new(ObeyingSurface::new(problem.setup(), settings))
                }
                false => Box::new(GridData::new(points, problem.grid(), parameters)),
                true => Box::new(ScatteredData::new(&points, &parameters, tolerance)),
            };
            let options = surface_options(problem, settings, first);
            return Self::Surface(Box::new(SurfaceSchedule::new(data, options)));
        }
        let mut options = Options {
            degree: u.basis.degree(),
            period: u.period(),
            tolerance: problem.tolerance(),
            max_control_points: settings.u,
            correct_parameters: automatic.correct_parameters,
            first: lines.first().cloned().zip(first),
            minima_alone: !settings.is_plain(),
            freedom: None,
        };
        let parameters = Arc::clone(&u.parameters);
        if settings.is_plain() {
            let minimum = equations::LeastSquares {
                points: Arc::clone(&points),
                data_weights: settings
                    .data_weights
                    .as_ref()
                    .map(|it| Arc::new(it.to_vec())),
                fairness: 0.0,
            };
            let schedule = Schedule::new(points, parameters, options, minimum);
            return Self::Curve(Box::new(schedule), None);
        }
        let minimum = Obeying::new(problem.setup(), settings);
        if let (None, Some(line)) = (&options.first, lines.into_iter().next()) {
            let values = Values::new(&line, &parameters);
            let Some(coarsest) = Minimum::minimum(&minimum, &values, None) else {
                return Self::Nowhere;
            };
            options.first = Some((line, coarsest));
        }
        Self::Obeying(Box::new(Schedule::new(
            points, parameters, options, minimum,
        )))
    }

    fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        let level = match self {
            Self::Curve(schedule, None) if whole.data().len() >= MANY => {
                among_threads(|| schedule.next_level())
            }
            Self::Curve(schedule, None) => schedule.next_level(),
            Self::Curve(schedule, Some(guide)) => {
                let level = schedule.next_level();
                level.map(|level| Arc::new(guide.of_data(&level)))
            }
            Self::Obeying(schedule) => schedule.next_level(),
            Self::Nowhere => return None,
            Self::Surface(schedule) | Self::FairSurface(schedule) => {
                let level = schedule.next_level()?;
                let t = whole.directions().map(|it| Arc::clone(&it.parameters));
                let parameters: Vec<Arc<Vec<f64>>> = t.collect();
                return Some(Fit::new(
                    whole,
                    &level.lines,
                    &parameters,
                    &level.control_points,
                    &level.distances,
                ));
            }
        };
        level.map(|level| {
            let Level {
                line,
                control_points,
                distances,
                parameters,
                ..
            } = &*level;
            let lines = std::slice::from_ref(line);
            let parameters = std::slice::from_ref(parameters);
            Fit::new(whole, lines, parameters, control_points, distances)
        })
    }

    fn outcome(&self) -> Option<Outcome> {
        match self {
            Self::Curve(schedule, _) => schedule.outcome(),
            Self::Obeying(schedule) => schedule.outcome(),
            Self::Surface(schedule) | Self::FairSurface(schedule) => schedule.outcome(),
            Self::Nowhere => Some(Outcome::Overflow),
        }
    }
}

/// The options of a surface, with the control points to begin with, if there are some.
fn surface_options(
    problem: &Problem,
    settings: &LeastSquares,
    first: Option<Points>,
) -> SurfaceOptions {
    let directions: Vec<&Direction> = problem.directions().collect();
    let of = |axis: usize| directions[axis.min(directions.len() - 1)];
    let lines: Vec<KnotLine> = problem.directions().filter_map(KnotLine::of).collect();
    let lines = <[KnotLine; 2]>::try_from(lines).ok();
    SurfaceOptions {
        degrees: [0, 1].map(|axis| of(axis).basis.degree()),
        periods: [0, 1].map(|axis| of(axis).period()),
        tolerance: problem.tolerance(),
        max_control_points: [settings.u, settings.v],
        first: lines.clone().zip(first),
        coarsest: lines,
    }
}

/// Computes something on one of the threads that share long loops. Any other one would fall asleep
/// and be woken up again for each of these loops.
fn among_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let rule = interrupt::rule();
    rayon::scope(|_| match rule {
        Some(rule) => interrupt::until(rule, work),
        None => work(),
    })
}

impl Fit {
    fn new(
        whole: &Arc<Problem>,
        lines: &[KnotLine],
        parameters: &[Arc<Vec<f64>>],
        control_points: &Points,
        distances: &Distances,
    ) -> Self {
        let directions = lines.iter().zip(parameters);
        let directions = directions.map(|(line, t)| line.direction(Arc::clone(t)));
        Self {
            problem: Arc::new(whole.with_directions(directions)),
            control_points: Arc::new(in_directions(control_points, lines)),
            error: FitError::of(distances),
        }
    }
}

/// The directions with which a fit begins that chooses its knots.
pub(super) fn first_directions(
    request: &Request,
    (settings, _): (&LeastSquares, &Settings),
) -> Result<(Direction, Option<Direction>), Invalid> {
    let breaks = |place: usize| {
        let all = request.start_breaks.as_ref();
        all.and_then(|all| all.get(place)).map(|breaks| &breaks[..])
    };
    if let Some(scattered) = &request.scattered {
        let [along, across] = scattered.parameters(&request.points)?;
        let u = first_scattered(&request.u, (along, breaks(0)), settings.u, Axis::U)?;
        let v = request.v.as_ref();
        let v = v.map(|v| first_scattered(v, (across, breaks(1)), settings.v, Axis::V));
        return Ok((u, v.transpose()?));
    }
    let data = (&*request.points, request.grid);
    let direction = |choice: &DirectionChoice, most, axis, place: usize| {
        let breaks = breaks(place);
        let (line, t) = first_line(choice.clone(), data, breaks, most, axis)?;
        Ok::<_, Invalid>(line.direction(t))
    };
    let u = direction(&request.u, settings.u, Axis::U, 0)?;
    let v = request.v.as_ref();
    let v = v.map(|choice| direction(choice, settings.v, Axis::V, 1));
    Ok((u, v.transpose()?))
}

/// The direction with which a fit of scattered points begins.
fn first_scattered(
    choice: &DirectionChoice,
    (parameters, breaks): (Vec<f64>, Option<&[f64]>),
    most: usize,
    axis: Axis,
) -> Result<Direction, Invalid> {
    let BasisChoice::BSpline { degree, .. } = choice.basis else {
        return Err(Invalid::automatic_knots(axis));
    };
    let free = degree.saturating_add(1);
    if most < free {
        let free = most;
        return Err(Invalid::too_few_control_points(axis, free, degree));
    }
    let direction = Direction::scattered(choice, (parameters, free), axis)?;
    let line = match breaks {
        Some(breaks) => KnotLine::new(degree, false, breaks.to_vec()),
        None => KnotLine::of(&direction),
    };
    let line = line.ok_or(Invalid::parameter_range(axis))?;
    Ok(line.direction(direction.parameters))
}

/// A fit that chooses its knots, with half as long spans, for what a setup cannot obey.
pub(super) fn finer(setup: &Setup, request: &Request) -> Option<Setup> {
    let (settings, _) = request.method.automatic()?;
    let Grid { rows, columns } = setup.grid();
    let data = match setup.is_scattered() {
        true => [rows; 2],
        false => [rows, columns],
    };
    let halved = |direction: &Direction, most: usize| {
        let line = KnotLine::of(direction)?.halved()?;
        let fits = line.control_points() <= most;
        fits.then(|| line.direction(Arc::clone(&direction.parameters)))
    };
    let u = halved(setup.u(), settings.u.min(data[0]))?;
    let v = match setup.v() {
        Some(v) => Some(halved(v, settings.v.min(data[1]))?),
        None => None,
    };
    setup.start().is_none().then(|| Setup {
        u,
        v,
        ..setup.clone()
    })
}

/// The most numbers of a factorization over some of the many knots that are tried for a surface: what
/// its bound of multiplications leaves room for.
const FACTOR: usize = 1 << 21;

/// About how many bytes a fit takes besides its data: values of functions, and the levels that a
/// schedule remembers.
pub(super) fn memory(problem: &Problem) -> usize {
    let dimension = problem.dimension();
    let width: usize = problem
        .directions()
        .map(|it| it.basis.degree() + 1)
        .max()
        .unwrap_or(1);
    let data = problem.grid().count();
    let most = problem.most_control_points();
    // A value of each function at each parameter twice, distances and parameters of five levels,
    // residual and image of a step, weights, and what is being computed.
    let by_data = data * (2 * width + 10 + 2 * dimension + 2);
    let by_control_points = most * (5 * dimension + 4 * width);
    // Points one by one, the values at each of them, and the vectors of conjugate gradients.
    let obeying = match (problem.v(), problem.method().automatic()) {
        (Some(_), Some((settings, _))) if !settings.is_plain_surface() => {
            data * (2 * width + 3 * dimension + 8) + FACTOR
        }
        _ => 0,
    };
    (by_data + by_control_points + obeying) * size_of::<f64>()
}
