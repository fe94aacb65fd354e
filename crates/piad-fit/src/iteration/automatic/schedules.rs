//! The schedules of fits that choose their knots: of curves and surfaces, with conditions or without.

use std::sync::Arc;

use crate::data::points::{Points, normalizing_scale};
use crate::geometry::norms::FitError;
use crate::interrupt;
use crate::knot_selection::Options;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::edges::Edges;
use crate::knot_selection::equations::{self, Minimum};
use crate::knot_selection::guide::Guide;
use crate::knot_selection::knot_conversion::{in_directions, in_lines};
use crate::knot_selection::levels::Level;
use crate::knot_selection::schedule::Schedule;
use crate::knot_selection::surface::{Data, GridData, ScatteredData, SurfaceSchedule};
use crate::knot_selection::values::{MANY, Values};
use crate::method::{
    Constrained, ConstrainedSurface, FairSurface, KnotSelection as Settings, LeastSquares,
};
use crate::problem::Problem;
use crate::termination::Outcome;

/// A B-spline of a schedule.
#[derive(Debug)]
pub(super) struct Fit {
    pub(super) problem: Arc<Problem>,
    pub(super) control_points: Arc<Points>,
    pub(super) error: FitError,
}

/// The schedules that there are.
#[derive(Debug)]
pub(super) enum Schedules {
    /// With points between the data, or without.
    Curve(Box<Schedule<equations::LeastSquares>>, Option<Between>),
    Constrained(Box<Schedule<Constrained>>),
    Surface(Box<SurfaceSchedule>),
    /// With some fairness although none was requested.
    FairSurface(Box<SurfaceSchedule>),
    /// Not even the first level has finite numbers.
    Nowhere,
}

/// Points between the data.
#[derive(Debug)]
pub(super) enum Between {
    Guide(Guide),
    Edges(Edges),
}

impl Between {
    fn points(&self) -> &Points {
        match self {
            Self::Guide(guide) => &guide.points,
            Self::Edges(edges) => &edges.points,
        }
    }

    /// A level with the parameters of the data.
    fn of_data(&self, level: &Level<1>) -> Level<1> {
        match self {
            Self::Guide(guide) => guide.of_data(level),
            Self::Edges(edges) => edges.of_vertices(level),
        }
    }
}

impl Schedules {
    /// The schedule of a fit.
    pub(super) fn new(
        problem: &Problem,
        (settings, automatic): (&LeastSquares, &Settings),
    ) -> Option<Self> {
        match problem.v() {
            None => Self::curve(problem, (settings, automatic)),
            Some(_) => {
                let data = surface_data(problem, settings)?;
                let options = options(problem, (settings, automatic))?;
                Some(Self::Surface(Box::new(SurfaceSchedule::new(data, options))))
            }
        }
    }

    /// That of a curve.
    fn curve(problem: &Problem, (settings, automatic): (&LeastSquares, &Settings)) -> Option<Self> {
        let (u, mut points) = (problem.u(), Arc::clone(problem.data()));
        let mut options = options(problem, (settings, automatic))?;
        if !settings.is_plain() {
            let minimum = Constrained::new(problem.setup(), settings);
            if options.first.is_none() {
                let values = Values::new(&options.lines[0], &u.parameters);
                options.first = Some(Minimum::minimum(&minimum, &values, None)?);
            }
            let schedule = Schedule::new(points, options, minimum);
            return Some(Self::Constrained(Box::new(schedule)));
        }
        if options.first.is_none() {
            options.lines = [Breaks::coarsest_of(u)?];
        }
        let mut between = None;
        if problem.request().polyline {
            let edges = Edges::new(&points, &u.parameters, u.period());
            points = Arc::clone(&edges.points);
            options.parameters = [Arc::clone(&edges.parameters)];
            between = Some(Between::Edges(edges));
        }
        let weights = settings.data_weights.as_ref();
        let minimum = equations::LeastSquares {
            data_weights: weights.map(|it| Arc::new(it.to_vec())),
            ..equations::LeastSquares::of(&points)
        };
        let schedule = Schedule::new(points, options, minimum);
        Some(Self::Curve(Box::new(schedule), between))
    }

    /// The next level, or `None` after the last one.
    pub(super) fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        let level = match self {
            Self::Curve(schedule, between) => {
                let points = between.as_ref().map_or(&**whole.data(), Between::points);
                let level = match points.len() >= MANY {
                    true => among_threads(|| schedule.next_level()),
                    false => schedule.next_level(),
                }?;
                match between {
                    Some(between) => Arc::new(between.of_data(&level)),
                    None => level,
                }
            }
            Self::Constrained(schedule) => schedule.next_level()?,
            Self::Nowhere => return None,
            Self::Surface(schedule) | Self::FairSurface(schedule) => {
                let mut level = schedule.next_level()?;
                let (all, given) = (&level.distances, whole.data().len());
                // Those of points between the given ones are behind them.
                if all.each.len() > given {
                    let unit = normalizing_scale(whole.data().magnitude());
                    let distances = all.of_first(given, unit);
                    level = Arc::new(Level {
                        distances,
                        ..Level::clone(&level)
                    });
                }
                return Some(Fit::new(whole, &level));
            }
        };
        Some(Fit::new(whole, &level))
    }

    /// How it has ended, after the last level.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        match self {
            Self::Curve(schedule, _) => schedule.outcome(),
            Self::Constrained(schedule) => schedule.outcome(),
            Self::Surface(schedule) | Self::FairSurface(schedule) => schedule.outcome(),
            Self::Nowhere => Some(Outcome::Overflow),
        }
    }
}

/// The data of a surface.
fn surface_data(problem: &Problem, settings: &LeastSquares) -> Option<Box<dyn Data>> {
    let setup = problem.setup();
    let is_plain = settings.is_plain_surface();
    // Between sections there are no data.
    let fair = match (is_plain, setup.sections.is_some()) {
        (true, true) => FairSurface::unasked(setup, settings),
        (true, false) => None,
        (false, _) => FairSurface::new(setup, settings),
    };
    let (points, parameters) = (problem.data(), parameters(problem)?);
    Some(match (fair, problem.is_scattered()) {
        (Some(fair), _) => Box::new(fair),
        (None, _) if !is_plain => Box::new(ConstrainedSurface::new(setup, settings)),
        (None, false) => Box::new(GridData::new(points, problem.grid(), parameters)),
        (None, true) => {
            let (poles, tolerance) = (setup.poles(), problem.tolerance());
            Box::new(ScatteredData::new(points, &parameters, poles, tolerance))
        }
    })
}

/// The parameters of the data in each direction.
pub(super) fn parameters<const D: usize>(problem: &Problem) -> Option<[Arc<Vec<f64>>; D]> {
    let all = problem.directions().map(|it| Arc::clone(&it.parameters));
    all.collect::<Vec<_>>().try_into().ok()
}

/// The options of a fit with the knots, and the control points, with which a problem begins.
pub(super) fn options<const D: usize>(
    problem: &Problem,
    (settings, automatic): (&LeastSquares, &Settings),
) -> Option<Options<D>> {
    let lines: Option<Vec<Breaks>> = problem.directions().map(Breaks::of).collect();
    let lines = <[Breaks; D]>::try_from(lines?).ok()?;
    Some(Options {
        first: problem.start().map(|start| in_lines(start, &lines)),
        lines,
        parameters: parameters(problem)?,
        tolerance: problem.tolerance(),
        max_control_points: std::array::from_fn(|axis| [settings.u, settings.v][axis]),
        correct_parameters: automatic.correct_parameters,
    })
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
    fn new<const D: usize>(whole: &Arc<Problem>, level: &Level<D>) -> Self {
        let directions = level.lines.iter().zip(&level.parameters);
        let directions = directions.map(|(line, t)| line.direction(Arc::clone(t)));
        Self {
            problem: Arc::new(whole.with_directions(directions)),
            control_points: Arc::new(in_directions(&level.control_points, &level.lines)),
            error: FitError::of(&level.distances),
        }
    }
}
