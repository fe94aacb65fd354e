//! The first part of the schedule: steps and new knots, from p + 1 control points on until the fit
//! is within the tolerance.

use std::sync::Arc;

use super::Phase;
use super::equations::{self, Minimum};
use super::growth::grown;
use super::insertion::refine;
use super::line::KnotLine;
use super::schedule::{GAIN, Schedule, Stage};
use super::steps::Steps;
use super::values::Values;
use crate::fit::outcome::Outcome;
use crate::fit::points::Points;

/// The most steps of conjugate gradients over the same knots.
const STEPS: usize = 6;

/// The same where the data do not determine the fit, so that nothing else leads to them.
const STEPS_ALONE: usize = 60;

/// Steps end when the rms falls to no less than this part.
const SLOW: f64 = 0.9;

/// The largest distance may rise by this part, which is rounding.
const ROUNDING: f64 = 1e-12;

impl<M: Minimum> Schedule<M> {
    /// The first level: p + 1 control points, at data points that are as far from each other; of
    /// fewer data on the segment between the ends.
    pub(super) fn begin(&mut self) {
        let (degree, closed) = (self.options.degree, self.options.period.is_some());
        let (first, last) = (self.parameters[0], self.parameters[self.points.len() - 1]);
        let end = self.options.period.map_or(last, |period| first + period);
        let Some(line) = KnotLine::coarsest(degree, closed, first, end) else {
            self.outcome = Some(Outcome::Overflow);
            return;
        };
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
        self.issue_new(Phase::Steps, line, &values, control_points);
        // Fewer there are not.
        if self.best.is_none() {
            self.stage = self.begin_steps(values);
        }
    }

    /// Steps from the last level on.
    fn begin_steps(&self, values: Values) -> Stage {
        let Some(last) = &self.last else {
            return Stage::Done;
        };
        let steps = Steps::new(&last.line, &values, &last.control_points, &self.points);
        Stage::Steps(Box::new(steps), values, 0)
    }

    /// One step of conjugate gradients, unless it brings nothing.
    pub(super) fn step(&mut self, mut steps: Box<Steps>, values: Values, done: usize) {
        let Some(last) = self.last.clone() else {
            return;
        };
        let mut control_points = last.control_points.clone();
        steps.step(&last.line, &values, &mut control_points);
        let level = self.level(Phase::Steps, last.line.clone(), &values, control_points);
        let distances = &level.distances;
        let alone = last.line.control_points() > self.points.len();
        let most = if alone { STEPS_ALONE } else { STEPS };
        let falls = distances.max <= last.distances.max * (1.0 + ROUNDING)
            && distances.rms < last.distances.rms * (1.0 - GAIN);
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
        if let Some(control_points) = self.minimum.minimum(&last.line, values, None) {
            nearest = self.level(Phase::Steps, last.line.clone(), values, control_points);
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
        let limit = self.high - 1;
        match grown(&last.line, &self.parameters, each, tolerance, limit) {
            Some(line) => {
                let control_points = refine(&last.line, &line, &last.control_points);
                let values = Values::new(&line, &self.parameters);
                self.issue_new(Phase::Insertion, line, &values, control_points);
                self.stage = self.begin_steps(values);
            }
            None => self.begin_search(&nearest, values),
        }
    }
}
