//! The matrix of scattered points over the knots of both directions.
//!
//! ```text
//! A[i][(k, l)] = B_k(u_i) B_l(v_i)
//! ```
//!
//! The functions are evaluated once at each different parameter of a direction. Around a closed
//! direction the first control points follow the last ones: there products have a margin of p more
//! of them, so that those of a point are always next to each other.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::values::Values;
use crate::linear::stencil::Reach;

/// The number of points that one thread takes at a time.
const PART: usize = 16_384;

/// Points at places among the different parameters of both directions, sorted by u.
#[derive(Debug)]
pub(super) struct Sites {
    /// The different parameters of each direction, increasing.
    pub parameters: [Arc<Vec<f64>>; 2],
    /// Which of them is that of each point.
    pub places: [Vec<u32>; 2],
    /// Which ends of v are poles, at which all control points are one.
    pub poles: [bool; 2],
}

/// The functions of a direction that can differ from zero at each of its parameters.
#[derive(Debug)]
pub(super) struct Functions {
    line: Breaks,
    width: usize,
    /// The first of them.
    firsts: Vec<u32>,
    values: Vec<f64>,
}

impl Functions {
    fn new(line: &Breaks, t: &Arc<Vec<f64>>) -> Self {
        let (firsts, values) = Values::new(line, t).into_rows();
        Self {
            line: line.clone(),
            width: line.degree() + 1,
            firsts,
            values,
        }
    }

    /// The number of functions: that of control points, and of a closed direction p more.
    pub(super) fn count(&self) -> usize {
        self.line.spans() + self.line.degree()
    }

    pub(super) fn degree(&self) -> usize {
        self.width - 1
    }

    fn at(&self, place: u32) -> (usize, &[f64]) {
        let place = place as usize;
        let values = &self.values[place * self.width..(place + 1) * self.width];
        (self.firsts[place] as usize, values)
    }
}

/// The matrix.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    sites: &'a Sites,
    poles: [bool; 2],
    pub(super) u: Functions,
    pub(super) v: Functions,
}

impl<'a> Rows<'a> {
    /// Evaluates the functions over some knots.
    pub(super) fn new(sites: &'a Sites, lines: &[Breaks; 2]) -> Self {
        Self {
            u: Functions::new(&lines[0], &sites.parameters[0]),
            v: Functions::new(&lines[1], &sites.parameters[1]),
            poles: sites.poles,
            sites,
        }
    }

    /// The same with control points of poles that differ, as those of derivatives do.
    pub(super) fn without_poles(self) -> Self {
        Self {
            poles: [false; 2],
            ..self
        }
    }

    /// The number of points.
    pub(super) fn points(&self) -> usize {
        self.sites.places[0].len()
    }

    /// The number of control points.
    pub(super) fn control_points(&self) -> usize {
        self.u.line.control_points() * self.v.line.control_points()
    }

    /// The numbers of it that can differ from zero.
    pub(super) fn numbers(&self) -> usize {
        self.points() * self.u.width * self.v.width
    }

    /// `y = A x` for one coordinate of the control points.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64]) {
        let columns = self.v.count();
        let x = self.with_margin(x);
        let value = |i: usize| {
            let [(row, along), (column, across)] = self.functions(i);
            let line = |(k, a): (usize, &f64)| {
                let x = &x[(row + k) * columns + column..][..across.len()];
                let sum: f64 = x.iter().zip(across).map(|(x, b)| x * b).sum();
                a * sum
            };
            along.iter().enumerate().map(line).sum::<f64>()
        };
        let parts = y.par_chunks_mut(PART).enumerate();
        parts.for_each(|(part, y)| {
            let places = y.iter_mut().enumerate();
            places.for_each(|(i, y)| *y = value(part * PART + i));
        });
    }

    /// `y = Aᵀ x` for one coordinate of the points. The order of the sums does not depend on the
    /// number of threads.
    pub(super) fn apply_transposed(&self, x: &[f64], y: &mut [f64]) {
        let columns = self.v.count();
        let parts = x.par_chunks(PART).enumerate();
        let parts: Vec<(usize, Vec<f64>)> = parts
            .map(|(part, x)| self.sums_of_part(part * PART, x))
            .collect();
        let mut sums = vec![0.0; self.u.count() * columns];
        for (first, part) in parts {
            let pairs = sums[first * columns..].iter_mut().zip(part);
            pairs.for_each(|(sum, x)| *sum += x);
        }
        y.fill(0.0);
        self.each_with_margin(|control_point, k| y[control_point] += sums[k]);
    }

    /// What the points from one on add to the lines of u that they reach, and the first of these.
    fn sums_of_part(&self, start: usize, x: &[f64]) -> (usize, Vec<f64>) {
        let columns = self.v.count();
        let row = |i: usize| self.functions(i)[0].0;
        let (first, last) = (row(start), row(start + x.len() - 1));
        let mut sums = vec![0.0; (last + self.u.width - first) * columns];
        for (i, x) in x.iter().enumerate() {
            let [(row, along), (column, across)] = self.functions(start + i);
            for (k, a) in along.iter().enumerate() {
                let factor = a * x;
                let sums = &mut sums[(row - first + k) * columns + column..][..across.len()];
                let pairs = sums.iter_mut().zip(across);
                pairs.for_each(|(sum, b)| *sum += factor * b);
            }
        }
        (first, sums)
    }

    /// `Aᵀ 1`: the sums of the columns, and of the rows of AᵀA.
    pub(super) fn sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.control_points()];
        self.apply_transposed(&vec![1.0; self.points()], &mut sums);
        sums
    }

    /// The functions of both directions.
    pub(super) fn reach(&self) -> [Reach; 2] {
        [&self.u, &self.v].map(|it| it.line.reach())
    }

    /// The points at which the first function of u that differs from zero is one of some; points are sorted by u.
    pub(super) fn points_from(&self, firsts: Range<usize>) -> Range<usize> {
        let places = &self.sites.places[0];
        let before = |end: usize| {
            places.partition_point(|&place| (self.u.firsts[place as usize] as usize) < end)
        };
        before(firsts.start)..before(firsts.end)
    }

    /// The functions of u and of v at point `i`.
    pub(super) fn functions(&self, i: usize) -> [(usize, &[f64]); 2] {
        let [u, v] = &self.sites.places;
        [self.u.at(u[i]), self.v.at(v[i])]
    }

    /// The control points with those around the ends of closed directions.
    pub(super) fn with_margin(&self, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.u.count() * self.v.count()];
        self.each_with_margin(|control_point, k| all[k] = x[control_point]);
        all
    }

    /// Calls back with each control point, and its places with margins. The control points of a pole are the first of
    /// them.
    pub(super) fn each_with_margin(&self, mut visit: impl FnMut(usize, usize)) {
        let (columns, width) = (self.v.line.control_points(), self.v.count());
        for k in 0..self.u.count() {
            let row = self.u.line.control_point(k);
            for l in 0..width {
                let column = self.v.line.control_point(l);
                let row = if self.is_pole(column) { 0 } else { row };
                visit(row * columns + column, k * width + l);
            }
        }
    }

    /// Returns true if all control points of a column are one.
    fn is_pole(&self, column: usize) -> bool {
        let [first, last] = self.poles;
        first && column == 0 || last && column + 1 == self.v.line.control_points()
    }

    /// Returns true if there is a pole.
    pub(super) fn has_poles(&self) -> bool {
        self.poles != [false; 2]
    }

    /// Makes all control points of a pole what the first of them is, in one coordinate.
    pub(super) fn join_poles(&self, x: &mut [f64]) {
        let columns = self.v.line.control_points();
        for column in (0..columns).filter(|&column| self.is_pole(column)) {
            let first = x[column];
            x.iter_mut()
                .skip(column)
                .step_by(columns)
                .for_each(|x| *x = first);
        }
    }
}
