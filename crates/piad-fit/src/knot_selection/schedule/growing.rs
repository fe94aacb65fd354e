//! From the first level until one is within the tolerance: steps over the same knots, and more knots.

use std::sync::Arc;

use super::super::equations::{self, Minimum};
use super::super::growth::grown;
use super::super::insertion::refine;
use super::super::steps::Steps;
use super::super::values::Values;
use super::{GAIN, Level, ROUNDING, SLOW, STEPS, STEPS_ALONE, Schedule, Stage};
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::termination::Outcome;

impl<M: Minimum> Schedule<M> {
    /// The first level.
    pub(super) fn begin(&mut self) {
        let Some((line, values, control_points)) = self.first() else {
            self.outcome.get_or_insert(Outcome::Overflow);
            return;
        };
        let fewest = line.control_points() <= self.options.degree + 1;
        self.issue_new(line, &values, control_points);
        // Already the minimum.
        if self.best.is_none() || !fewest {
            self.stage = self.begin_steps(values);
        }
    }

    /// The given curve; or p + 1 control points, at data points that are evenly spaced; with fewer
    /// data, on the segment between the ends.
    fn first(&mut self) -> Option<(Breaks, Values, Points)> {
        if let Some((line, control_points)) = self.options.first.take() {
            let values = Values::new(&line, &self.parameters);
            return Some((line, values, control_points));
        }
        let (degree, closed) = (self.options.degree, self.options.period.is_some());
        let (first, last) = (self.parameters[0], self.parameters[self.points.len() - 1]);
        let end = self.options.period.map_or(last, |period| first + period);
        let line = Breaks::coarsest(degree, closed, first, end)?;
        let count = line.control_points();
        let control_points = if self.points.len() <= count {
            equations::start(&line, &self.points)
        } else {
            let parts = if closed { count } else { count - 1 };
            let index = |j: usize| (self.points.len() * j / parts).min(self.points.len() - 1);
            let lanes = self.points.lanes().iter();
            Points::from_lanes(
                lanes.map(|lane| (0..count).map(|j| lane[index(j)]).collect::<Vec<_>>()),
            )
        };
        let values = Values::new(&line, &self.parameters);
        Some((line, values, control_points))
    }

    /// Steps from the last level on.
    fn begin_steps(&self, values: Values) -> Stage {
        let Some(last) = &self.last else {
            return Stage::Done;
        };
        if self.options.minima_alone {
            return Stage::Growth(values);
        }
        let steps = Steps::new(&values, &last.control_points, &self.points, self.unit);
        Stage::Steps(Box::new(steps), values, 0)
    }

    /// One step of conjugate gradients, unless it gains nothing.
    pub(super) fn step(&mut self, mut steps: Box<Steps>, values: Values, done: usize) {
        let Some(last) = self.last.clone() else {
            return;
        };
        let mut control_points = last.control_points.clone();
        steps.step(&values, &mut control_points);
        let level = Arc::new(Level {
            line: last.line.clone(),
            control_points,
            distances: steps.distances(),
            parameters: Arc::clone(&self.parameters),
        });
        let distances = &level.distances;
        let alone = last.line.control_points() > self.points.len();
        let most = if alone { STEPS_ALONE } else { STEPS };
        let falls = distances.max <= last.distances.max * (1.0 + ROUNDING)
            && distances.rms < last.distances.rms * (1.0 - GAIN)
            && level.control_points.is_finite();
        let slow = distances.rms > SLOW * last.distances.rms && !alone;
        if falls {
            self.issue(level);
        }
        self.stage = if falls && !slow && done + 1 < most {
            Stage::Steps(steps, values, done + 1)
        } else {
            Stage::Growth(values)
        };
    }

    /// The least-squares fit over the knots of the last level, and where it is too far from the
    /// data new knots.
    pub(super) fn grow(&mut self, values: &Values) {
        let Some(last) = self.last.clone() else {
            return;
        };
        let mut nearest = Arc::clone(&last);
        if let Some(control_points) = self.minimum.minimum(values, None) {
            nearest = self.level(last.line.clone(), values, control_points);
            if nearest.distances.max < last.distances.max * (1.0 - GAIN) {
                self.issue(Arc::clone(&nearest));
            }
        }
        let tolerance = self.options.tolerance;
        let Some(last) = self.last.clone() else {
            return;
        };
        if last.distances.max <= tolerance {
            self.begin_search(&nearest, values);
            return;
        }
        let each = &nearest.distances.each;
        let limits = (self.high - 1, self.options.max_control_points);
        match grown(&last.line, &self.parameters, each, tolerance, limits) {
            Some(line) => {
                let control_points = refine(&last.line, &line, &last.control_points);
                let values = Values::new(&line, &self.parameters);
                self.issue_new(line, &values, control_points);
                self.stage = self.begin_steps(values);
            }
            None => self.begin_search(&nearest, values),
        }
    }
}
