//! From the first level until one is within the tolerance: steps over the same knots, and more knots.

use std::sync::Arc;

use super::super::equations::{self, Minimum};
use super::super::growth::grown;
use super::super::insertion::refine;
use super::super::steps::Steps;
use super::super::values::Values;
use super::{GAIN, Level, ROUNDING, SLOW, STEPS, STEPS_ALONE, Schedule, Stage};
use crate::data::points::Points;

impl<M: Minimum> Schedule<M> {
    /// The first level.
    pub(super) fn begin(&mut self) {
        let ([line], [t]) = (&self.options.lines, &self.options.parameters);
        let fewest = line.control_points() <= line.degree() + 1;
        let values = Values::new(line, t);
        let first = self.options.first.take();
        let control_points = first.unwrap_or_else(|| self.near_the_data());
        self.levels.issue(self.level(&values, control_points));
        // Already the minimum.
        if self.levels.best.is_none() || !fewest {
            self.stage = self.begin_steps(values);
        }
    }

    /// Control points at data points that are evenly spaced; with fewer data, on the segment between the ends.
    fn near_the_data(&self) -> Points {
        let ([line], data) = (&self.options.lines, self.points.len());
        let count = line.control_points();
        if data <= count {
            return equations::start(line, &self.points);
        }
        let parts = count - line.fixed_ends();
        let indices = (0..count).map(|j| (data * j / parts).min(data - 1));
        self.points.selected(indices)
    }

    /// Steps from the last level on.
    fn begin_steps(&self, values: Values) -> Stage {
        let Some(last) = &self.levels.last else {
            return Stage::Done;
        };
        if !self.minimum.has_steps() {
            return Stage::Growth(values);
        }
        let steps = Steps::new(&values, &last.control_points, &self.points, self.unit);
        Stage::Steps(Box::new(steps), values, 0)
    }

    /// One step of conjugate gradients, unless it gains nothing.
    pub(super) fn step(&mut self, mut steps: Box<Steps>, values: Values, done: usize) {
        let Some(last) = &self.levels.last else {
            return;
        };
        let mut control_points = last.control_points.clone();
        steps.step(&values, &mut control_points);
        let level = Level {
            control_points,
            distances: steps.distances(),
            lines: last.lines.clone(),
            parameters: last.parameters.clone(),
        };
        let distances = &level.distances;
        let alone = last.count() > self.points.len();
        let most = if alone { STEPS_ALONE } else { STEPS };
        let falls = distances.max <= last.distances.max * (1.0 + ROUNDING)
            && distances.rms < last.distances.rms * (1.0 - GAIN)
            && level.control_points.is_finite();
        let slow = distances.rms > SLOW * last.distances.rms && !alone;
        if falls {
            self.levels.issue(Arc::new(level));
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
        let Some(mut last) = self.levels.last.clone() else {
            return;
        };
        let mut nearest = Arc::clone(&last);
        if let Some(level) = self.fit(values, None) {
            nearest = level;
            if nearest.distances.max < last.distances.max * (1.0 - GAIN) {
                last = Arc::clone(&nearest);
                self.levels.issue(Arc::clone(&nearest));
            }
        }
        if self.levels.is_within(&last) {
            self.begin_search(&nearest, values);
            return;
        }
        let (line, t, each) = (values.line(), values.parameters(), &nearest.distances.each);
        let limits = (self.high - 1, self.options.max_control_points[0]);
        match grown(line, t, each, self.options.tolerance, limits) {
            Some(finer) => {
                let control_points = refine(line, &finer, &last.control_points);
                let values = Values::new(&finer, t);
                self.levels.issue(self.level(&values, control_points));
                self.stage = self.begin_steps(values);
            }
            None => self.begin_search(&nearest, values),
        }
    }
}
