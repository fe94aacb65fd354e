//! Scattered data: points without order, each with a (u, v) of its own.
//!
//! Least squares do not fall apart into directions, so all that is known of a knot span is the
//! largest distance of the data in it, whatever their other parameter. Which direction gains more is
//! tried: one step towards the least-squares fit over the knots that each would get.
//!
//! The surface does not depend on the order of the data: they are sorted by their parameters.

use std::sync::Arc;

use super::gradients::{Effort, descend, diagonal, first_gain};
use super::rows::{Rows, Sites};
use super::{Data, Fit, Nearest, SurfaceLevel};
use crate::data::distances::Distances;
use crate::data::points::{Points, normalizing_scale};
use crate::knot_selection::breaks::Breaks;

/// A root of the mean square below this part of the tolerance does not have to fall any more.
const ENOUGH: f64 = 1e-3;

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
    pub(crate) fn new(points: &Points, parameters: &[Arc<Vec<f64>>; 2], tolerance: f64) -> Self {
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
            },
            most: points.len(),
            order,
            enough: ENOUGH * tolerance,
            unit: normalizing_scale(points.magnitude()),
        }
    }

    /// The same with so many control points at most, rather than as many as data.
    pub(crate) fn with_most(self, most: usize) -> Self {
        Self { most, ..self }
    }

    /// The squared distances of the sorted data, times the square of the unit.
    fn squares(&self, rows: &Rows<'_>, control_points: &Points) -> Vec<f64> {
        let mut squares = vec![0.0; self.points.len()];
        let mut fit = vec![0.0; self.points.len()];
        for (x, data) in control_points.lanes().iter().zip(self.points.lanes()) {
            rows.apply(x, &mut fit);
            for ((sum, fit), data) in squares.iter_mut().zip(&fit).zip(&**data) {
                let distance = (data - fit) * self.unit;
                *sum += distance * distance;
            }
        }
        squares
    }

    /// For each direction, the largest distance that a surface leaves at each of its parameters.
    pub(crate) fn left(&self, lines: &[Breaks; 2], control_points: &Points) -> [Vec<f64>; 2] {
        let squares = self.squares(&Rows::new(&self.sites, lines), control_points);
        [0, 1].map(|axis| {
            let mut left = vec![0.0; self.sites.parameters[axis].len()];
            for (&place, square) in self.sites.places[axis].iter().zip(&squares) {
                let most = &mut left[place as usize];
                *most = f64::max(*most, square.sqrt() / self.unit);
            }
            left
        })
    }

    /// The surface near the data that a descent with some effort leads to.
    fn nearest_by(
        &self,
        effort: impl Fn(&Rows<'_>) -> Effort,
        lines: &[Breaks; 2],
        from: Option<&SurfaceLevel>,
    ) -> Nearest {
        let rows = Rows::new(&self.sites, lines);
        let effort = effort(&rows);
        let diagonal = diagonal(&rows);
        let mut control_points = match from {
            Some(level) => level.over(lines),
            None => self.mean(rows.control_points()),
        };
        let lanes = control_points.lanes_mut().iter_mut();
        for (x, data) in lanes.zip(self.points.lanes()) {
            descend((&rows, effort), &diagonal, data, x, self.unit, self.enough);
        }
        Nearest {
            left: self.left(lines, &control_points),
            control_points,
        }
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

    /// What is left is known of both together.
    fn share(&self) -> f64 {
        1.0
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        counts[0].saturating_mul(counts[1]) <= self.most
    }

    fn nearest(&self, lines: &[Breaks; 2], from: Option<&SurfaceLevel>) -> Option<Nearest> {
        Some(self.nearest_by(|_| Effort::USUAL, lines, from))
    }

    fn nearest_of_all(&self, lines: &[Breaks; 2], from: Option<&SurfaceLevel>) -> Option<Nearest> {
        Some(self.nearest_by(Effort::whole, lines, from))
    }

    fn distances(&self, lines: &[Breaks; 2], control_points: &Points) -> Distances {
        let rows = Rows::new(&self.sites, lines);
        let sorted = self.squares(&rows, control_points);
        let mut squares = vec![0.0; sorted.len()];
        for (&i, square) in self.order.iter().zip(sorted) {
            squares[i as usize] = square;
        }
        Distances::of_squares(squares, self.unit)
    }

    /// The one where a step lowers the sum of squares more, for each new control point.
    fn prefers(&self, fit: &Fit, finer: &[Breaks; 2]) -> usize {
        let level = &fit.level;
        let rows = Rows::new(&self.sites, &level.lines);
        let lanes = level.control_points.lanes().iter().zip(self.points.lanes());
        let residuals: Vec<Vec<f64>> = lanes
            .map(|(x, data)| {
                let mut residual = vec![0.0; data.len()];
                rows.apply(x, &mut residual);
                let pairs = residual.iter_mut().zip(&**data);
                pairs.for_each(|(r, datum)| *r = (datum - *r) * self.unit);
                residual
            })
            .collect();
        let gain = |axis: usize| {
            let mut lines = level.lines.clone();
            lines[axis] = finer[axis].clone();
            let rows = Rows::new(&self.sites, &lines);
            let diagonal = diagonal(&rows);
            let gains = residuals.iter().map(|it| first_gain(&rows, &diagonal, it));
            gains.sum::<f64>() / (rows.control_points() - level.count()) as f64
        };
        usize::from(gain(1) > gain(0))
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
