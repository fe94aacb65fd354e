//! The schedules of fits that choose their knots: of curves and surfaces, with conditions or without.

use std::fmt::Debug;
use std::sync::Arc;

use crate::basis::direction::Direction;
use crate::data::distances::Distances;
use crate::data::points::{Points, normalizing_scale};
use crate::geometry::norms::FitError;
use crate::interrupt;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::edges::Edges;
use crate::knot_selection::equations::{self, Minimum};
use crate::knot_selection::guide::Guide;
use crate::knot_selection::knot_conversion::{in_directions, in_lines};
use crate::knot_selection::schedule::Schedule;
use crate::knot_selection::surface::{
    Data, GridData, ScatteredData, SurfaceOptions, SurfaceSchedule,
};
use crate::knot_selection::values::{MANY, Values};
use crate::knot_selection::{Level, Options};
use crate::method::{Constrained, ConstrainedSurface, FairSurface, KnotSelection, LeastSquares};
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
    /// Those of several fits.
    Several(Box<dyn Levels>),
    Surface(Box<SurfaceSchedule>),
    /// With some fairness although none was requested.
    FairSurface(Box<SurfaceSchedule>),
    /// Not even the first level has finite numbers.
    Nowhere,
}

/// Levels of a whole fit.
pub(super) trait Levels: Debug + Send + Sync {
    /// The next one, or `None` after the last one.
    fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit>;

    /// How the fit has ended, after the last one.
    fn outcome(&self) -> Option<Outcome>;
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
    fn of_data(&self, level: &Level) -> Level {
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
        settings: &LeastSquares,
        automatic: &KnotSelection,
    ) -> Self {
        let points = Arc::clone(problem.data());
        let lines: Vec<Breaks> = problem.directions().filter_map(Breaks::of).collect();
        let first = problem.start().map(|start| in_lines(start, &lines));
        let u = problem.u();
        if let Some(v) = problem.v() {
            let parameters = [u, v].map(|it| Arc::clone(&it.parameters));
            let tolerance = problem.tolerance();
            let setup = problem.setup();
            // Between sections there are no data.
            let fair = match (settings.is_plain_surface(), setup.sections.is_some()) {
                (true, true) => FairSurface::unasked(setup, settings),
                (true, false) => None,
                (false, _) => FairSurface::new(setup, settings),
            };
            let data: Box<dyn Data> = match (fair, problem.is_scattered()) {
                (Some(fair), _) => Box::new(fair),
                (None, _) if !settings.is_plain_surface() => {
                    Box::new(ConstrainedSurface::new(setup, settings))
                }
                (None, false) => Box::new(GridData::new(points, problem.grid(), parameters)),
                (None, true) => Box::new(ScatteredData::new(
                    &points,
                    &parameters,
                    setup.poles(),
                    tolerance,
                )),
            };
            let options = surface_options(problem, (settings, automatic), first);
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
        if problem.request().polyline {
            let edges = Edges::new(&points, &parameters, u.period());
            let (points, parameters) = (Arc::clone(&edges.points), Arc::clone(&edges.parameters));
            let minimum = equations::LeastSquares {
                points: Arc::clone(&points),
                data_weights: None,
                fairness: 0.0,
            };
            let schedule = Schedule::new(points, parameters, options, minimum);
            return Self::Curve(Box::new(schedule), Some(Between::Edges(edges)));
        }
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
        let minimum = Constrained::new(problem.setup(), settings);
        if let (None, Some(line)) = (&options.first, lines.into_iter().next()) {
            let values = Values::new(&line, &parameters);
            let Some(coarsest) = Minimum::minimum(&minimum, &values, None) else {
                return Self::Nowhere;
            };
            options.first = Some((line, coarsest));
        }
        Self::Constrained(Box::new(Schedule::new(
            points, parameters, options, minimum,
        )))
    }

    /// The next level, or `None` after the last one.
    pub(super) fn next(&mut self, whole: &Arc<Problem>) -> Option<Fit> {
        let level = match self {
            Self::Curve(schedule, between) => {
                let points = between.as_ref().map_or(&**whole.data(), Between::points);
                let level = match points.len() >= MANY {
                    true => among_threads(|| schedule.next_level()),
                    false => schedule.next_level(),
                };
                match between {
                    Some(between) => level.map(|level| Arc::new(between.of_data(&level))),
                    None => level,
                }
            }
            Self::Constrained(schedule) => schedule.next_level(),
            Self::Several(levels) => return levels.next(whole),
            Self::Nowhere => return None,
            Self::Surface(schedule) | Self::FairSurface(schedule) => {
                let level = schedule.next_level()?;
                let t = whole.directions().map(|it| Arc::clone(&it.parameters));
                let parameters: Vec<Arc<Vec<f64>>> = match &level.parameters {
                    Some(moved) => moved.to_vec(),
                    None => t.collect(),
                };
                let (all, given) = (&level.distances, whole.data().len());
                // Those of points between the given ones are behind them.
                let of_given = (all.each.len() > given).then(|| {
                    let unit = normalizing_scale(whole.data().magnitude());
                    all.of_first(given, unit)
                });
                return Some(Fit::new(
                    whole,
                    &level.lines,
                    &parameters,
                    &level.control_points,
                    of_given.as_ref().unwrap_or(all),
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

    /// How it has ended, after the last level.
    pub(super) fn outcome(&self) -> Option<Outcome> {
        match self {
            Self::Curve(schedule, _) => schedule.outcome(),
            Self::Constrained(schedule) => schedule.outcome(),
            Self::Surface(schedule) | Self::FairSurface(schedule) => schedule.outcome(),
            Self::Several(levels) => levels.outcome(),
            Self::Nowhere => Some(Outcome::Overflow),
        }
    }
}

/// The options of a surface, with the control points to begin with, if there are some.
pub(super) fn surface_options(
    problem: &Problem,
    (settings, automatic): (&LeastSquares, &KnotSelection),
    first: Option<Points>,
) -> SurfaceOptions {
    let directions: Vec<&Direction> = problem.directions().collect();
    let of = |axis: usize| directions[axis.min(directions.len() - 1)];
    let lines: Vec<Breaks> = problem.directions().filter_map(Breaks::of).collect();
    let lines = <[Breaks; 2]>::try_from(lines).ok();
    SurfaceOptions {
        degrees: [0, 1].map(|axis| of(axis).basis.degree()),
        periods: [0, 1].map(|axis| of(axis).period()),
        tolerance: problem.tolerance(),
        correct_parameters: automatic.correct_parameters,
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
        lines: &[Breaks],
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
