//! From p + 1 control points to the fewest for the tolerance: the choice of the next level.
//!
//! Growth ends with more control points than needed, between `low`, which is known to be too few,
//! and `high`, which is known to suffice. Each *attempt* has a number of control points, and
//! redistributes its knots until it is within the tolerance, makes no progress, or is hopeless. The
//! next number follows from the distances, by `(e/τ)^(1/(p+1))` times as many spans; near the end
//! it is one fewer.

mod growing;
mod merging;
mod pruning;

use std::sync::Arc;

use super::Options;
use super::attempt::Attempt;
use super::breaks::control_points_beyond_spans;
use super::correction::corrected;
use super::equations::Minimum;
use super::levels::{Level, Levels};
use super::minimax::Weights;
use super::monitor::{Monitor, needed, span_maxima};
use super::placement::place;
use super::steps::Steps;
use super::values::Values;
use crate::data::points::{Points, normalizing_scale};
use crate::termination::Outcome;

/// The most steps of conjugate gradients over the same knots.
const STEPS: usize = 6;

/// The same where the data do not determine the fit, so that there is no other method.
const STEPS_ALONE: usize = 60;

/// Steps end when the rms falls to no less than this part.
const SLOW: f64 = 0.9;

/// The largest distance may rise by this part, which is rounding.
const ROUNDING: f64 = 1e-12;

/// Gains below this part are not worth a level.
const GAIN: f64 = 1e-6;

/// How far knots go towards equal distances in a redistribution.
const DAMPING: f64 = 0.7;

/// Attempts use weights if their largest distance is below this number of tolerances.
const NEAR: f64 = 1.5;

/// Steps of the weights.
const WEIGHINGS: usize = 10;

/// Numbers of control points that differ by less than this part of them count as equal: of a
/// thousand the last three would take as long to save as all others.
const RESOLUTION: usize = 256;

/// Least-squares fits after growth: enough for every number of control points that is tried.
const BUDGET: usize = 120;

/// The number of data points times fits with single knots fewer: a fraction of a second.
const WORK: usize = 1_000_000;

/// With fewer fits than these hardly any knot would be removed.
const WORTHWHILE: usize = 64;

/// A fit with as few control points as its tolerance needs, level by level.
#[derive(Debug)]
pub(crate) struct Schedule<M> {
    minimum: M,
    points: Arc<Points>,
    /// A power of two that brings squares of distances to the order of one.
    unit: f64,
    options: Options<1>,
    stage: Stage,
    levels: Levels<1>,
    /// This many control points, or fewer, are known to be too few.
    low: usize,
    /// This many are known to suffice, or too many.
    high: usize,
    /// Least-squares fits since the end of growth.
    spent: usize,
    /// The number of knots that are tried to be removed at once.
    batch: Option<usize>,
    /// Least-squares fits that are left for the removal of single knots.
    prunings: usize,
    /// The same for knots that move.
    merges: usize,
}

/// The source of the next level.
#[derive(Debug)]
enum Stage {
    /// Nothing: the first level.
    Start,
    /// Steps over the knots of the last level.
    Steps(Box<Steps>, Values, usize),
    /// The choice of new knots.
    Growth(Values),
    /// Redistribution.
    Attempt(Attempt),
    /// Weights, over the knots of the last level.
    Minimax(Attempt, Weights, usize),
    /// The end.
    Done,
}

impl<M: Minimum> Schedule<M> {
    /// A fit of data at increasing parameters, two at least.
    pub(crate) fn new(points: Arc<Points>, options: Options<1>, minimum: M) -> Self {
        let degree = options.lines[0].degree();
        let most = options.max_control_points[0].min(points.len());
        Self {
            low: degree,
            high: most.max(degree + 1) + 1,
            batch: None,
            prunings: prunings(points.len()),
            merges: prunings(points.len()),
            minimum,
            unit: normalizing_scale(points.magnitude()),
            points,
            levels: Levels::new(options.tolerance),
            options,
            stage: Stage::Start,
            spent: 0,
        }
    }

    /// How it has ended, after the last level.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        self.levels.outcome()
    }

    /// The next level, or `None` after the last one.
    pub(crate) fn next_level(&mut self) -> Option<Arc<Level<1>>> {
        while self.levels.is_next_missing() {
            self.advance();
        }
        self.levels.pop()
    }

    /// Takes one step, after which there may be a new level.
    fn advance(&mut self) {
        match std::mem::replace(&mut self.stage, Stage::Done) {
            Stage::Start => self.begin(),
            Stage::Steps(steps, values, left) => self.step(steps, values, left),
            Stage::Growth(values) => self.grow(&values),
            Stage::Attempt(attempt) => self.attempt(attempt),
            Stage::Minimax(attempt, weights, left) => self.weigh(attempt, weights, left),
            Stage::Done if self.prune() || self.merge() => {}
            Stage::Done => self.finish(),
        }
    }

    /// The first attempt, with the number of control points that follows from the distances.
    fn begin_search(&mut self, nearest: &Level<1>, values: &Values) {
        let (each, line) = (&nearest.distances.each, values.line());
        let maxima = span_maxima(values.starts(), each);
        let asked = needed(line, &maxima, self.options.tolerance);
        if let Some(best) = &self.levels.best {
            self.high = best.count();
        }
        self.next_attempt(asked, Monitor::new(line, values.starts(), each, 1.0));
    }

    /// Starts an attempt with about `asked` control points, if there are numbers left to try.
    fn next_attempt(&mut self, asked: usize, monitor: Monitor) {
        let coarse = match self.levels.best {
            Some(_) => self.high / RESOLUTION,
            None => 0,
        };
        let (least, most) = (self.low + 1, self.high - 1 - coarse);
        self.stage = if least <= most {
            Stage::Attempt(Attempt::new(asked.clamp(least, most), monitor))
        } else {
            Stage::Done
        };
    }

    /// One redistribution.
    fn attempt(&mut self, mut attempt: Attempt) {
        if self.spent >= BUDGET {
            return;
        }
        self.spent += 1;
        let Some((level, values)) = self.redistributed(&attempt) else {
            self.fail(attempt);
            return;
        };
        let damping = if attempt.is_fresh() { 1.0 } else { DAMPING };
        let each = &level.distances.each;
        let monitor = Monitor::new(values.line(), values.starts(), each, damping);
        if attempt.take(&level, monitor) {
            self.levels.issue(Arc::clone(&level));
        }
        if self.levels.is_within(&level) {
            self.succeed(&level, attempt.into_last_monitor());
        } else if !attempt.is_over(self.options.tolerance, self.high - 1) {
            self.stage = Stage::Attempt(attempt);
        } else if attempt.lowest() < NEAR * self.options.tolerance {
            let weights = Weights::new(self.points.len());
            self.stage = Stage::Minimax(attempt, weights, WEIGHINGS);
        } else {
            self.fail(attempt);
        }
    }

    /// The least-squares fit over the knots of an attempt.
    fn redistributed(&mut self, attempt: &Attempt) -> Option<(Arc<Level<1>>, Values)> {
        let [t] = &self.options.parameters;
        let line = place(attempt.monitor(), t, attempt.count())?;
        let mut values = Values::new(&line, t);
        let control_points = self.minimum.minimum(&values, None)?;
        if self.options.correct_parameters {
            let moved = Arc::new(corrected(&values, &control_points, &self.points));
            values = Values::new(&line, &moved);
            self.options.parameters = [moved];
        }
        let level = self.level(&values, control_points);
        level.distances.max.is_finite().then_some((level, values))
    }

    /// One step of the weights over the knots of the last level.
    fn weigh(&mut self, attempt: Attempt, mut weights: Weights, left: usize) {
        let (Some(base), Some(last)) = (attempt.lowest_level(), &self.levels.last) else {
            return;
        };
        self.spent += 1;
        let from = attempt.weighed().unwrap_or(base);
        weights.raise(&from.distances.each, from.distances.max);
        let level = self.fit(&values_of(base), Some(weights.values()));
        let Some(level) = level.filter(|_| left > 0) else {
            self.fail(attempt);
            return;
        };
        if level.distances.max < last.distances.max * (1.0 - GAIN) {
            self.levels.issue(Arc::clone(&level));
        }
        if self.levels.is_within(&level) {
            self.high = level.count();
            self.next_attempt(self.high - 1, attempt.into_lowest_monitor());
        } else {
            let attempt = attempt.with_weighed(level);
            self.stage = Stage::Minimax(attempt, weights, left - 1);
        }
    }

    /// Continues with fewer control points.
    fn succeed(&mut self, level: &Level<1>, monitor: Monitor) {
        self.high = level.count();
        let asked = self.asked(level).min(self.high - 1);
        self.next_attempt(asked, monitor);
    }

    /// Continues with more control points.
    fn fail(&mut self, attempt: Attempt) {
        let count = attempt.count();
        self.low = self.low.max(count);
        let asked = match attempt.lowest_level() {
            Some(level) => self.asked(level),
            None => count + 1,
        };
        // Before a sufficient number is known, in steps towards one.
        let least = match self.levels.best {
            None => count + count / 4,
            Some(_) => 0,
        };
        self.next_attempt(asked.max(least), attempt.into_lowest_monitor());
    }

    /// The number of control points that follows from the largest distance, if it is the same
    /// everywhere.
    fn asked(&self, level: &Level<1>) -> usize {
        let ([line], largest) = (&level.lines, level.distances.max);
        let beyond = control_points_beyond_spans(line.degree(), line.is_closed());
        let power = 1.0 / (line.degree() + 1) as f64;
        let factor = (largest / self.options.tolerance).powf(power);
        beyond + (line.spans() as f64 * factor).ceil().min(1e15) as usize
    }

    /// The end, if no level is left.
    fn finish(&mut self) {
        let is_limited = self.options.max_control_points[0] < self.points.len();
        self.levels.end(match is_limited {
            true => Outcome::Exhausted,
            false => Outcome::Minimum,
        });
    }

    /// The least-squares fit over some knots.
    fn fit(&self, values: &Values, weights: Option<&[f64]>) -> Option<Arc<Level<1>>> {
        let control_points = self.minimum.minimum(values, weights)?;
        Some(self.level(values, control_points))
    }

    /// The level of some control points.
    fn level(&self, values: &Values, control_points: Points) -> Arc<Level<1>> {
        let mut distances =
            values.distances(control_points.lanes(), self.points.lanes(), self.unit);
        if let Some(freedom) = self.minimum.freedom() {
            distances = distances.beyond(freedom, self.unit);
        }
        Arc::new(Level {
            lines: [values.line().clone()],
            control_points,
            distances,
            parameters: [Arc::clone(values.parameters())],
        })
    }
}

/// The values of the functions of a level.
fn values_of(level: &Level<1>) -> Values {
    let ([line], [t]) = (&level.lines, &level.parameters);
    Values::new(line, t)
}

/// The number of fits with single knots fewer that are tried for this number of data.
fn prunings(points: usize) -> usize {
    let fits = WORK / points.max(1);
    if fits < WORTHWHILE { 0 } else { fits }
}
