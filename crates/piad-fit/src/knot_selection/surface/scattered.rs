//! Scattered data: points without order, each with its own (u, v).
//!
//! Least squares do not separate into directions, so for a knot span only the largest distance of the data in it is
//! known, whatever their other parameter. The direction that gains more is found by trial: one step towards the
//! least-squares fit over the knots that each would get.
//!
//! The surface does not depend on the order of the data: they are sorted by their parameters.

use std::sync::Arc;

use super::correction;
use super::gradients::{Effort, descend, first_gain};
use super::normal::{Normal, inverses};
use super::rows::{Rows, Sites};
use super::{Data, Fit, Nearest, Parameters};
use crate::data::distances::Distances;
use crate::data::points::{Points, normalizing_scale};
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::linear::stencil::Stencil;
use crate::linear::vectors::dot;

/// A root of the mean square below this part of the tolerance need not fall further.
const ENOUGH: f64 = 1e-3;

/// Where neither direction lowers the sum of squares by this part, both are tried with twice the knots.
const GAIN: f64 = 0.05;

/// Data points of all fits with fewer knot lines, and the most of these fits.
const WORK: usize = 4_000_000;

/// See [`WORK`].
const PRUNINGS: usize = 60;

/// Points at scattered parameters.
#[derive(Debug)]
pub(crate) struct ScatteredData {
    /// The data, sorted by u and then by v.
    points: Points,
    /// The index of each of them among those that were given.
    order: Vec<u32>,
    sites: Sites,
    /// The most control points of a surface.
    most: usize,
    /// Distances that are small enough.
    enough: f64,
    /// Brings squares to the order of one.
    unit: f64,
}

impl ScatteredData {
    /// Points with a u and a v each; those of a closed direction lie within one period, from the
    /// smallest of them on.
    pub(crate) fn new(
        points: &Points,
        parameters: &Parameters,
        poles: [bool; 2],
        tolerance: f64,
    ) -> Self {
        let [u, v] = parameters;
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by(|&i, &j| {
            let (i, j) = (i as usize, j as usize);
            let point = |i: usize| points.point(i);
            let pairs = point(i).zip(point(j));
            let mut coordinates = pairs.map(|(a, b)| a.total_cmp(&b));
            u[i].total_cmp(&u[j])
                .then(v[i].total_cmp(&v[j]))
                .then_with(|| coordinates.find(|it| it.is_ne()).unwrap_or(i.cmp(&j)))
        });
        let sorted = |lane: &[f64]| order.iter().map(|&i| lane[i as usize]).collect::<Vec<_>>();
        let [u, v] = [sorted(u), sorted(v)].map(|t| ranked(&t));
        Self {
            points: Points::from_lanes(points.lanes().iter().map(|lane| sorted(lane))),
            sites: Sites {
                parameters: [Arc::new(u.0), Arc::new(v.0)],
                places: [u.1, v.1],
                poles,
            },
            most: points.len(),
            order,
            enough: ENOUGH * tolerance,
            unit: normalizing_scale(points.magnitude()),
        }
    }

    /// The same with at most `most` control points instead of one for each datum.
    pub(crate) fn with_most(self, most: usize) -> Self {
        Self { most, ..self }
    }

    /// The same data with parameters that follow a surface, and these in the order in which the data were given.
    pub(crate) fn following(&self, level: &Level<2>) -> Option<(Self, Parameters)> {
        let sorted = correction::corrected(&self.sites, &self.points, level)?;
        let parameters = sorted.map(|sorted| Arc::new(self.in_order(&sorted)));
        let lanes = self.points.lanes().iter();
        let points = Points::from_lanes(lanes.map(|lane| self.in_order(lane)));
        let data = Self::new(&points, &parameters, self.sites.poles, self.enough / ENOUGH);
        Some((data.with_most(self.most), parameters))
    }

    /// How far the sorted data are from a surface, times the unit: a coordinate at a time.
    fn residuals<'a>(
        &'a self,
        rows: &'a Rows,
        control_points: &'a Points,
    ) -> impl Iterator<Item = Vec<f64>> + 'a {
        let lanes = control_points.lanes().iter().zip(self.points.lanes());
        lanes.map(|(x, data)| {
            let mut residual = vec![0.0; data.len()];
            rows.apply(x, &mut residual);
            let pairs = residual.iter_mut().zip(&**data);
            pairs.for_each(|(r, datum)| *r = (datum - *r) * self.unit);
            residual
        })
    }

    /// The squared distances of the sorted data, times the square of the unit.
    fn squares(&self, rows: &Rows, control_points: &Points) -> Vec<f64> {
        let mut squares = vec![0.0; self.points.len()];
        for residual in self.residuals(rows, control_points) {
            let pairs = squares.iter_mut().zip(residual);
            pairs.for_each(|(sum, distance)| *sum += distance * distance);
        }
        squares
    }

    /// A surface with its distances from the data, and the largest at each parameter of each direction.
    pub(crate) fn with_distances(&self, lines: &[Breaks; 2], control_points: Points) -> Nearest {
        self.measured(&Rows::new(&self.sites, lines), control_points)
    }

    fn measured(&self, rows: &Rows, control_points: Points) -> Nearest {
        let squares = self.squares(rows, &control_points);
        let left = [0, 1].map(|axis| {
            let mut left = vec![0.0; self.sites.parameters[axis].len()];
            for (&place, square) in self.sites.places[axis].iter().zip(&squares) {
                let most = &mut left[place as usize];
                *most = f64::max(*most, square.sqrt() / self.unit);
            }
            left
        });
        Nearest {
            distances: self.distances_of(&squares),
            control_points,
            left,
        }
    }

    /// Numbers of the sorted data in the order in which these were given.
    fn in_order(&self, sorted: &[f64]) -> Vec<f64> {
        let mut given = vec![0.0; sorted.len()];
        for (&i, x) in self.order.iter().zip(sorted) {
            given[i as usize] = *x;
        }
        given
    }

    /// The distances, of the squares of the sorted data.
    fn distances_of(&self, sorted: &[f64]) -> Distances {
        Distances::of_squares(self.in_order(sorted), self.unit)
    }

    /// The surface near the data, and with little energy, by descent from some control points.
    pub(crate) fn nearest_from(
        &self,
        start: Option<Points>,
        lines: &[Breaks; 2],
        energy: Option<&Stencil>,
    ) -> Nearest {
        self.nearest_by(|_| Effort::USUAL, start, lines, energy)
    }

    fn nearest_by(
        &self,
        effort: impl Fn(&Rows) -> Effort,
        start: Option<Points>,
        lines: &[Breaks; 2],
        energy: Option<&Stencil>,
    ) -> Nearest {
        let rows = Rows::new(&self.sites, lines);
        let normal = Normal::new(&rows, energy);
        let (effort, preconditioner) = (effort(&rows), normal.preconditioner());
        let mut control_points = start.unwrap_or_else(|| self.mean(rows.control_points()));
        let lanes = control_points.lanes_mut().iter_mut();
        for (x, data) in lanes.zip(self.points.lanes()) {
            let by = (&normal, &preconditioner, effort);
            descend(by, data, x, self.unit, self.enough);
        }
        for x in control_points.lanes_mut() {
            rows.join_poles(x);
        }
        self.measured(&rows, control_points)
    }

    /// All control points at the mean of the data.
    fn mean(&self, count: usize) -> Points {
        let lanes = self.points.lanes().iter();
        Points::from_lanes(lanes.map(|lane| {
            let mean: f64 = lane.iter().map(|x| x / lane.len() as f64).sum();
            vec![mean; count]
        }))
    }
}

impl Data for ScatteredData {
    fn parameters(&self, axis: usize) -> &[f64] {
        &self.sites.parameters[axis]
    }

    /// The residual of both directions together.
    fn share(&self) -> f64 {
        1.0
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        counts[0].saturating_mul(counts[1]) <= self.most
    }

    fn nearest(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest> {
        Some(self.nearest_from(from.map(|it| it.over(lines)), lines, None))
    }

    fn nearest_of_all(&self, lines: &[Breaks; 2], from: Option<&Level<2>>) -> Option<Nearest> {
        let start = from.map(|it| it.over(lines));
        Some(self.nearest_by(Effort::whole, start, lines, None))
    }

    fn distances(&self, lines: &[Breaks; 2], control_points: &Points) -> Distances {
        let rows = Rows::new(&self.sites, lines);
        self.distances_of(&self.squares(&rows, control_points))
    }

    fn corrected(&self, level: &Level<2>) -> Option<(Box<dyn Data>, Parameters)> {
        let (data, parameters) = self.following(level)?;
        Some((Box::new(data), parameters))
    }

    fn prunings(&self) -> usize {
        (WORK / self.points.len().max(1)).min(PRUNINGS)
    }

    /// The direction in which a step lowers the sum of squares more, for each new control point.
    fn prefers(&self, fit: &Fit, finer: &[Breaks; 2]) -> usize {
        let level = &fit.level;
        let rows = Rows::new(&self.sites, &level.lines);
        let residuals: Vec<Vec<f64>> = self.residuals(&rows, &level.control_points).collect();
        let gain = |axis: usize, line: &Breaks| {
            let mut lines = level.lines.clone();
            lines[axis] = line.clone();
            let rows = Rows::new(&self.sites, &lines);
            let diagonal = inverses(rows.sums());
            let gains = residuals.iter().map(|it| first_gain(&rows, &diagonal, it));
            let added = rows.control_points() - level.count();
            (gains.sum::<f64>(), added as f64)
        };
        let mut gains = [0, 1].map(|axis| gain(axis, &finer[axis]));
        let left: f64 = residuals.iter().map(|it| dot(it, it)).sum();
        if gains.iter().all(|(gain, _)| *gain < GAIN * left) {
            // Knots in the middle of spans do nothing for residuals that are odd about it.
            let twice = [0, 1].map(|axis| finer[axis].halved().unwrap_or(finer[axis].clone()));
            gains = [0, 1].map(|axis| gain(axis, &twice[axis]));
        }
        let [u, v] = gains.map(|(gain, added)| gain / added);
        usize::from(v > u)
    }
}

/// The different numbers among some, increasing, and which of them each is.
fn ranked(t: &[f64]) -> (Vec<f64>, Vec<u32>) {
    let mut different = t.to_vec();
    different.sort_by(f64::total_cmp);
    different.dedup();
    let place = |t: &f64| different.partition_point(|other| other < t) as u32;
    let places = t.iter().map(place).collect();
    (different, places)
}
