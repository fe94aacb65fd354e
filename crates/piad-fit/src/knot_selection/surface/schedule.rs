//! From p + 1 × q + 1 control points to the fewest for the tolerance: the choice of the next level.

mod pruning;

use std::sync::Arc;

use super::attempt::Attempt;
use super::lines::along;
use super::search::Search;
use super::{Data, Fit};
use crate::data::points::Points;
use crate::knot_selection::Options;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::growth::grown;
use crate::knot_selection::insertion::refine;
use crate::knot_selection::levels::{Level, Levels};
use crate::termination::Outcome;

/// Where something keeps a surface away from its data, the search ends when this many times more knots lower the root
/// of the mean square by less than [`GAIN`] of it: each direction twice.
const STILL: usize = 4;

/// See [`STILL`].
const GAIN: f64 = 0.01;

/// Parameters follow a surface whose largest distance is at most this multiple of the tolerance: a coarser one would
/// move them too close together.
const NEAR: f64 = 4.0;

/// Bisections of a factor of numbers of control points, to rounding.
const BISECTIONS: usize = 100;

/// A surface with as few control points as its tolerance needs, level by level.
#[derive(Debug)]
pub(crate) struct SurfaceSchedule {
    data: Box<dyn Data>,
    options: Options<2>,
    stage: Stage,
    levels: Levels<2>,
    /// True if more control points were needed than are allowed.
    limited: bool,
    /// The root of the mean square of the last fit of the growth, and how many fits have hardly lowered
    /// it.
    rms: Option<f64>,
    still: usize,
    /// The number of lines of each direction that are tried to be removed at once.
    batches: [Option<usize>; 2],
    /// Fits that are left for the removal of lines.
    prunings: usize,
}

/// The source of the next level.
#[derive(Debug)]
enum Stage {
    /// Nothing: the first level.
    Start,
    /// Least squares over the knots of the last level, which were inserted.
    Steps,
    /// The choice of new knots after a fit.
    Growth(Fit),
    /// The choice of the next number of control points.
    Search(Search),
    /// Redistribution.
    Attempt(Search, Box<Attempt>),
    /// The end.
    Done,
}

impl SurfaceSchedule {
    /// A fit of data; nothing is computed before the first level is requested.
    pub(crate) fn new(data: Box<dyn Data>, options: Options<2>) -> Self {
        Self {
            batches: [None; 2],
            prunings: data.prunings(),
            data,
            levels: Levels::new(options.tolerance),
            options,
            stage: Stage::Start,
            limited: false,
            rms: None,
            still: 0,
        }
    }

    /// How it has ended, after the last level.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        self.levels.outcome()
    }

    /// The next level, or `None` after the last one.
    pub(crate) fn next_level(&mut self) -> Option<Arc<Level<2>>> {
        while self.levels.is_next_missing() {
            self.advance();
        }
        self.levels.pop()
    }

    /// Takes one step, after which there may be a new level.
    fn advance(&mut self) {
        self.stage = match std::mem::replace(&mut self.stage, Stage::Done) {
            Stage::Start => self.begin(),
            Stage::Steps => self.step(),
            Stage::Growth(fit) => self.grow(fit),
            Stage::Search(search) => self.next_attempt(search),
            Stage::Attempt(search, attempt) => self.attempt(search, attempt),
            Stage::Done if self.prune() => Stage::Done,
            Stage::Done => {
                self.finish();
                Stage::Done
            }
        };
    }

    /// The fewest control points of each direction.
    fn fewest(&self) -> [usize; 2] {
        self.options.lines.each_ref().map(|line| line.degree() + 1)
    }

    /// The most control points of each direction.
    fn most(&self) -> [usize; 2] {
        let fewest = self.fewest();
        [0, 1].map(|axis| {
            let data = self.data.parameters(axis).len();
            let most = self.options.max_control_points[axis];
            most.min(data).max(fewest[axis])
        })
    }

    /// The first level: the given surface, or the least-squares surface of the fewest control points.
    fn begin(&mut self) -> Stage {
        let lines = self.options.lines.clone();
        if let Some(control_points) = self.options.first.take() {
            self.levels.issue(self.level(lines, control_points));
            return Stage::Steps;
        }
        match self.fit(lines) {
            Some(fit) => {
                self.levels.issue(Arc::clone(&fit.level));
                Stage::Growth(fit)
            }
            None => match self.data.undetermined(&self.options) {
                Some(data) => {
                    self.data = data;
                    Stage::Start
                }
                None => Stage::Done,
            },
        }
    }

    /// The least-squares surface over the knots of the last level.
    fn step(&mut self) -> Stage {
        let Some(last) = self.levels.last.clone() else {
            return Stage::Done;
        };
        let Some(fit) = self.fit(last.lines.clone()) else {
            return Stage::Done;
        };
        if fit.level.distances.max <= last.distances.max {
            self.levels.issue(Arc::clone(&fit.level));
        }
        Stage::Growth(fit)
    }

    /// More knots, until the surface is within the tolerance.
    fn grow(&mut self, fit: Fit) -> Stage {
        let fit = match self.levels.best {
            Some(_) => fit,
            None => self.corrected(fit),
        };
        let is_within = self.levels.best.is_some();
        if !is_within && self.stands_still(&fit) {
            return Stage::Done;
        }
        if let (false, Some((axis, line)), Some(last)) =
            (is_within, self.finer(&fit), self.levels.last.clone())
        {
            let mut lines = last.lines.clone();
            let inserted = |curves: &Points| refine(&lines[axis], &line, curves);
            let control_points = along(&last.control_points, last.counts(), axis, inserted);
            lines[axis] = line;
            self.levels.issue(self.level(lines, control_points));
            return Stage::Steps;
        }
        let asked = fit.asked(&*self.data, self.options.tolerance);
        let is_fit_within = self.levels.is_within(&fit.level);
        let most = self.most_towards(asked);
        let even = self.most_towards([1, 1]);
        let asked = match self.data.allows(asked) {
            true => asked,
            false => most,
        };
        Stage::Search(Search::new(
            fit,
            is_fit_within,
            asked,
            self.fewest(),
            [most, even],
        ))
    }

    /// The fit with parameters that have followed it, if that brings it nearer to the data.
    fn corrected(&mut self, fit: Fit) -> Fit {
        let is_near = fit.level.distances.max <= NEAR * self.options.tolerance;
        let corrected = match self.options.correct_parameters && is_near {
            true => self.data.corrected(&fit.level),
            false => None,
        };
        let Some((data, parameters)) = corrected else {
            return fit;
        };
        let lines = fit.level.lines.clone();
        let nearest = data.nearest(&lines, Some(&fit.level));
        let moved = nearest.and_then(|nearest| Fit::of(lines, &parameters, nearest));
        match moved.filter(|it| it.level.distances.rms < fit.level.distances.rms) {
            Some(moved) => {
                (self.data, self.options.parameters) = (data, parameters);
                self.levels.issue(Arc::clone(&moved.level));
                moved
            }
            None => fit,
        }
    }

    /// Returns true if more knots have not brought the surface nearer for some time, and will not.
    fn stands_still(&mut self, fit: &Fit) -> bool {
        let rms = fit.level.distances.rms;
        let before = self.rms.replace(rms);
        self.still = match before.is_none_or(|before| rms < (1.0 - GAIN) * before) {
            true => 0,
            false => self.still + 1,
        };
        self.data.has_floor() && self.still >= STILL
    }

    /// The most control points, in about this ratio, if the data do not determine the allowed number in each direction.
    fn most_towards(&self, ratio: [usize; 2]) -> [usize; 2] {
        let (fewest, most) = (self.fewest(), self.most());
        let part = |factor: f64| {
            [0, 1].map(|axis| {
                let count = (ratio[axis] as f64 * factor).min(1e9) as usize;
                count.clamp(fewest[axis], most[axis])
            })
        };
        if self.data.allows(most) {
            return most;
        }
        let (mut low, mut high) = (0.0, 1e9);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            match self.data.allows(part(middle)) {
                true => low = middle,
                false => high = middle,
            }
        }
        part(low)
    }

    /// More knots in the direction that gains more, or else in the other one.
    fn finer(&mut self, fit: &Fit) -> Option<(usize, Breaks)> {
        let (most, now) = (self.most(), fit.level.counts());
        let share = self.data.share() * self.options.tolerance;
        let with_limits = |axis: usize, limits: (usize, usize)| {
            let t = self.data.parameters(axis);
            let line = grown(&fit.level.lines[axis], t, &fit.left[axis], share, limits)?;
            let mut counts = now;
            counts[axis] = line.control_points();
            self.data.allows(counts).then_some(line)
        };
        let asked = self.options.max_control_points;
        let finer = [0, 1].map(|axis| with_limits(axis, (most[axis], asked[axis])));
        match finer {
            [Some(u), Some(v)] => {
                let mut finer = [u, v];
                let axis = self.data.prefers(fit, &finer);
                finer.swap(0, axis);
                let [line, _] = finer;
                Some((axis, line))
            }
            [Some(u), None] => Some((0, u)),
            [None, Some(v)] => Some((1, v)),
            [None, None] => {
                self.limited |=
                    (0..2).any(|axis| with_limits(axis, (usize::MAX, usize::MAX)).is_some());
                None
            }
        }
    }

    /// The next attempt of a search.
    fn next_attempt(&mut self, mut search: Search) -> Stage {
        match search.counts() {
            Some(counts) if self.data.allows(counts) => {
                let mut attempt = Attempt::new(&*self.data, search.from(), counts);
                if search.is_even() {
                    attempt = attempt.with_even_knots();
                }
                Stage::Attempt(search, Box::new(attempt))
            }
            Some(_) => Self::failed(search),
            None => Stage::Done,
        }
    }

    /// One redistribution.
    fn attempt(&mut self, mut search: Search, mut attempt: Box<Attempt>) -> Stage {
        let lines = attempt.lines(&*self.data);
        let from = self.levels.last.as_deref();
        let fit = lines.and_then(|lines| {
            let nearest = match search.is_even() {
                true => self.data.nearest_of_all(&lines, from),
                false => self.data.nearest(&lines, from),
            };
            Fit::of(lines, &self.options.parameters, nearest?)
        });
        let Some(fit) = fit else {
            return Self::failed(search);
        };
        if attempt.take(&*self.data, &fit) {
            self.levels.issue(Arc::clone(&fit.level));
        }
        if self.levels.is_within(&fit.level) {
            search.succeed(fit);
            Stage::Search(search)
        } else if attempt.is_over(self.options.tolerance) {
            Self::failed(search)
        } else {
            Stage::Attempt(search, attempt)
        }
    }

    /// Continues after an attempt has failed.
    fn failed(mut search: Search) -> Stage {
        match search.fail() {
            true => Stage::Search(search),
            false => Stage::Done,
        }
    }

    /// The end, if no level is left.
    fn finish(&mut self) {
        // As many as data would go through all of a grid.
        let all = [0, 1].map(|axis| self.data.parameters(axis).len());
        let most = self.most();
        let fewer = (0..2).any(|axis| most[axis] < all[axis]);
        let limited = self.limited || fewer && self.data.allows(all);
        self.levels.end(match limited {
            true => Outcome::Exhausted,
            false => Outcome::Minimum,
        });
    }

    /// The least-squares surface over some knots, if the data determine it.
    fn fit(&self, lines: [Breaks; 2]) -> Option<Fit> {
        let from = self.levels.last.as_deref();
        let nearest = self.data.nearest(&lines, from)?;
        Fit::of(lines, &self.options.parameters, nearest)
    }

    /// The level of some control points.
    fn level(&self, lines: [Breaks; 2], control_points: Points) -> Arc<Level<2>> {
        Arc::new(Level {
            distances: self.data.distances(&lines, &control_points),
            lines,
            control_points,
            parameters: self.options.parameters.clone(),
        })
    }
}
