//! The matrix of scattered points over the knots of both directions.
//!
//! ```text
//! A[i][(k, l)] = B_k(u_i) B_l(v_i)
//! ```
//!
//! The functions are evaluated once at each different parameter of a direction. Products of cubic functions have a fixed
//! number of terms, which the compiler unrolls. Around a closed
//! direction the first control points follow the last ones: there products have a margin of p more
//! of them, so that those of a point are always next to each other.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::basis::evaluated::Evaluated;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::values::Values;
use crate::linear::stencil::Reach;

/// The number of points that one thread takes at a time.
const PART: usize = 16_384;

/// The number of cubic functions that can differ from zero at a place.
const CUBIC: usize = 4;

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

/// The functions of a direction that can differ from zero at each point.
#[derive(Debug)]
pub(super) struct Functions {
    line: Breaks,
    evaluated: Evaluated,
}

impl Functions {
    /// At the parameters of these places among the different ones.
    fn new(line: &Breaks, t: &Arc<Vec<f64>>, places: &[u32]) -> Self {
        let mut evaluated = Values::new(line, t).into_rows();
        let are_in_order = places.len() == t.len() && places.is_sorted();
        if !are_in_order {
            let width = evaluated.width;
            let mut values = vec![0.0; places.len() * width];
            let all = values.par_chunks_mut(width).zip(places);
            all.with_min_len(PART).for_each(|(point, &place)| {
                point.copy_from_slice(evaluated.at(place as usize).1);
            });
            let first = |&place: &u32| evaluated.firsts[place as usize];
            evaluated = Evaluated {
                width,
                firsts: places.iter().map(first).collect(),
                values,
            };
        }
        let line = line.clone();
        Self { line, evaluated }
    }

    /// The number of functions: that of control points, and of a closed direction p more.
    pub(super) fn count(&self) -> usize {
        self.line.spans() + self.line.degree()
    }

    pub(super) fn degree(&self) -> usize {
        self.evaluated.width - 1
    }
}

/// The matrix.
#[derive(Debug)]
pub(super) struct Rows {
    poles: [bool; 2],
    pub(super) u: Functions,
    pub(super) v: Functions,
}

impl Rows {
    /// Evaluates the functions over some knots.
    pub(super) fn new(sites: &Sites, lines: &[Breaks; 2]) -> Self {
        let [u, v] = [0, 1].map(|axis| {
            let (t, places) = (&sites.parameters[axis], &sites.places[axis]);
            Functions::new(&lines[axis], t, places)
        });
        Self {
            u,
            v,
            poles: sites.poles,
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
        self.u.evaluated.firsts.len()
    }

    /// The number of control points.
    pub(super) fn control_points(&self) -> usize {
        self.u.line.control_points() * self.v.line.control_points()
    }

    /// The numbers of it that can differ from zero.
    pub(super) fn numbers(&self) -> usize {
        self.points() * self.u.evaluated.width * self.v.evaluated.width
    }

    /// `y = A x` for one coordinate of the control points.
    pub(super) fn apply(&self, x: &[f64], y: &mut [f64]) {
        let columns = self.v.count();
        let x = self.with_margin(x);
        let value = |i: usize| {
            let [(row, along), (column, across)] = self.functions(i);
            let x = &x[row * columns + column..];
            match <&[f64; CUBIC]>::try_from(across) {
                Ok(across) => value_of_cubics(x, columns, along, across),
                Err(_) => value(x, columns, along, across),
            }
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
        let mut sums = vec![0.0; (last + self.u.evaluated.width - first) * columns];
        for (i, x) in x.iter().enumerate() {
            let [(row, along), (column, across)] = self.functions(start + i);
            for (k, a) in along.iter().enumerate() {
                let sums = &mut sums[(row - first + k) * columns + column..];
                add(a * x, across, sums);
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
        let before = |end: usize| {
            let firsts = &self.u.evaluated.firsts;
            firsts.partition_point(|&first| (first as usize) < end)
        };
        before(firsts.start)..before(firsts.end)
    }

    /// The functions of u and of v at point `i`.
    #[inline]
    pub(super) fn functions(&self, i: usize) -> [(usize, &[f64]); 2] {
        [self.u.evaluated.at(i), self.v.evaluated.at(i)]
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

/// The sum of the products of control points, from the first of them on in lines of `columns`, and functions.
fn value(x: &[f64], columns: usize, along: &[f64], across: &[f64]) -> f64 {
    let lines = along.iter().zip(x.chunks(columns));
    lines
        .map(|(a, x)| a * x.iter().zip(across).map(|(x, b)| x * b).sum::<f64>())
        .sum()
}

/// The same of cubic functions across.
#[inline]
fn value_of_cubics(x: &[f64], columns: usize, along: &[f64], across: &[f64; CUBIC]) -> f64 {
    let mut sums = [0.0; CUBIC];
    for (k, a) in along.iter().enumerate() {
        add_cubic(*a, &x[k * columns..], &mut sums);
    }
    sums.iter().zip(across).map(|(sum, b)| sum * b).sum()
}

/// `sums ← sums + factor x` for the first few numbers.
#[inline]
pub(super) fn add(factor: f64, x: &[f64], sums: &mut [f64]) {
    match <&[f64; CUBIC]>::try_from(x) {
        Ok(x) => {
            if let Some(sums) = sums.first_chunk_mut() {
                add_cubic(factor, x, sums);
            }
        }
        Err(_) => {
            let pairs = sums.iter_mut().zip(x);
            pairs.for_each(|(sum, x)| *sum += factor * x);
        }
    }
}

#[inline]
fn add_cubic(factor: f64, x: &[f64], sums: &mut [f64; CUBIC]) {
    let pairs = sums.iter_mut().zip(&x[..CUBIC]);
    pairs.for_each(|(sum, x)| *sum += factor * x);
}
