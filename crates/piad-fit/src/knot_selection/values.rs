//! The values of all functions at all parameters, and sums of them: the most expensive part of a fit.
//!
//! Several threads share the data of long curves; sums are added up part by part, in an order that does
//! not depend on how many threads there are. The innermost loops are [`kernels`].

mod kernels;

use std::ops::{Deref, DerefMut, Range};
use std::sync::Arc;

use rayon::prelude::*;

use super::breaks::Breaks;
use crate::basis::evaluated::Evaluated;
use crate::data::blocks::{BLOCK, Block};
use crate::data::distances::{Distances, measure};
use crate::data::points::Points;
use kernels::{add, evaluate, invert_widths, multiply, multiply_all, with_width};

/// Fewer data are one group: sharing them among threads would take longer.
pub(crate) const MANY: usize = 16_384;

/// The approximate number of groups of more data.
const GROUPS: usize = 12;

/// The values of the functions of a knot line at increasing parameters: p + 1 numbers for each of
/// them, of those of its span on.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    line: Breaks,
    t: Arc<Vec<f64>>,
    /// Where the parameters of each span start.
    starts: Vec<usize>,
    parts: Vec<Part>,
    groups: Vec<Group>,
    values: Vec<f64>,
}

/// Successive data of one span, at most [`BLOCK`].
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// The span, and the first of the p + 1 functions that differ from zero there.
    pub span: usize,
    data: Range<usize>,
}

/// Successive parts, which one thread takes at a time.
#[derive(Clone, Debug)]
struct Group {
    parts: Range<usize>,
    data: Range<usize>,
}

impl Values {
    /// Evaluates all functions at increasing parameters.
    pub(crate) fn new(line: &Breaks, t: &Arc<Vec<f64>>) -> Self {
        let (starts, width, knots) = (line.starts(t), line.degree() + 1, line.knots());
        let parts = parts(&starts);
        let mut all = Self {
            line: line.clone(),
            t: Arc::clone(t),
            groups: groups(&parts, t.len()),
            starts,
            parts,
            values: Vec::new(),
        };
        let mut values = vec![0.0; t.len() * width];
        let pieces = cut(&all.groups, &mut values, |group| group.data.len() * width);
        all.each_group(pieces, |group, mut rest| {
            let mut inverses = vec![0.0; width * width];
            for part in all.parts_of(group) {
                let near = &knots[part.span..part.span + 2 * width];
                invert_widths(near, width, &mut inverses);
                let t = &t[part.data.clone()];
                let rows = rest.split_off_mut(..t.len() * width).unwrap_or_default();
                with_width!(width, evaluate(width, near, &inverses, t, rows));
            }
        });
        all.values = values;
        all
    }

    /// The knots.
    pub(crate) fn line(&self) -> &Breaks {
        &self.line
    }

    /// The parameters.
    pub(crate) fn parameters(&self) -> &Arc<Vec<f64>> {
        &self.t
    }

    /// p + 1.
    pub(super) fn width(&self) -> usize {
        self.line.degree() + 1
    }

    /// Where the parameters of each span start, and the number of parameters.
    pub(crate) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The parts, in their order.
    pub(super) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Datum by datum the functions that can differ from zero.
    pub(super) fn into_rows(self) -> Evaluated {
        let first = |part: &Part| std::iter::repeat_n(part.span as u32, part.data.len());
        Evaluated {
            width: self.width(),
            firsts: self.parts.iter().flat_map(first).collect(),
            values: self.values,
        }
    }

    /// `y = A x`, for some coordinates of control points and of data.
    pub(crate) fn apply(
        &self,
        x: &[impl Deref<Target = [f64]>],
        y: &mut [impl DerefMut<Target = [f64]>],
    ) {
        let (x, y) = (slices(x), self.by_group(y));
        self.each_group(y, |group, mut y| {
            for part in self.parts_of(group) {
                for (x, y) in x.iter().zip(&mut y) {
                    let piece = y.split_off_mut(..part.data.len()).unwrap_or_default();
                    self.combine(part, x, piece);
                }
            }
        });
    }

    /// The points of the curve of control points.
    pub(crate) fn points(&self, control_points: &Points) -> Points {
        let mut points = Points::zeros(control_points.dimension(), self.t.len());
        self.apply(control_points.lanes(), points.lanes_mut());
        points
    }

    /// How far the data are from these points, in each coordinate.
    pub(super) fn residual(&self, control_points: &Points, data: &Points) -> Points {
        let mut residual = self.points(control_points);
        for (residual, data) in residual.lanes_mut().iter_mut().zip(data.lanes()) {
            let pairs = residual.iter_mut().zip(&**data);
            pairs.for_each(|(fit, datum)| *fit = datum - *fit);
        }
        residual
    }

    /// The distances of the data from the curve of control points, by squares of lengths that are
    /// multiplied with `unit`, a power of two.
    pub(super) fn distances(
        &self,
        x: &[impl Deref<Target = [f64]>],
        data: &[impl Deref<Target = [f64]>],
        unit: f64,
    ) -> Distances {
        let (x, data) = (slices(x), slices(data));
        let mut each = vec![0.0; self.t.len()];
        let mut blocks = vec![Block::default(); self.parts.len()];
        let distances = cut(&self.groups, &mut each, |group| group.data.len());
        let norms = cut(&self.groups, &mut blocks, |group| group.parts.len());
        let pieces = distances.into_iter().zip(norms).collect();
        self.each_group(pieces, |group, (mut rest, norms)| {
            let mut room = [0.0; BLOCK];
            for (part, norms) in self.parts_of(group).iter().zip(norms) {
                let squares = rest.split_off_mut(..part.data.len()).unwrap_or_default();
                let fit = &mut room[..part.data.len()];
                for (x, data) in x.iter().zip(&data) {
                    self.combine(part, x, fit);
                    let pairs = fit.iter().zip(&data[part.data.clone()]);
                    for (square, (fit, datum)) in squares.iter_mut().zip(pairs) {
                        let distance = (datum - fit) * unit;
                        *square += distance * distance;
                    }
                }
                *norms = measure(part.data.start, squares, unit);
            }
        });
        Distances::of_blocks(each, &blocks, unit)
    }

    /// `y = Aᵀ x`, for some coordinates of data and of control points.
    pub(crate) fn apply_transposed(
        &self,
        x: &[impl Deref<Target = [f64]>],
        y: &mut [impl DerefMut<Target = [f64]>],
    ) {
        y.iter_mut().for_each(|y| y.fill(0.0));
        let (x, width) = (slices(x), self.width());
        let sums = self.sums(x.len() * width, |part, sums, _| {
            for (x, sums) in x.iter().zip(sums.chunks_exact_mut(width)) {
                self.sum_up(part, &x[part.data.clone()], sums);
            }
        });
        for (part, sums) in self.parts.iter().zip(sums.chunks_exact(x.len() * width)) {
            for (y, sums) in y.iter_mut().zip(sums.chunks_exact(width)) {
                self.add_to(y, part, sums);
            }
        }
    }

    /// For each part what it adds to `Aᵀ W (P − A x)`, p + 1 sums for each coordinate.
    pub(super) fn right_sides(
        &self,
        data: &[impl Deref<Target = [f64]>],
        x: &[impl Deref<Target = [f64]>],
        weights: Option<&[f64]>,
    ) -> Vec<f64> {
        let (data, x, width) = (slices(data), slices(x), self.width());
        self.sums(x.len() * width, |part, sums, room| {
            let fit = &mut room[..part.data.len()];
            let each = data.iter().zip(&x).zip(sums.chunks_exact_mut(width));
            for ((data, x), sums) in each {
                self.combine(part, x, fit);
                let pairs = fit.iter_mut().zip(&data[part.data.clone()]);
                pairs.for_each(|(fit, datum)| *fit = datum - *fit);
                if let Some(weights) = weights {
                    let pairs = fit.iter_mut().zip(&weights[part.data.clone()]);
                    pairs.for_each(|(x, weight)| *x *= weight);
                }
                self.sum_up(part, fit, sums);
            }
        })
    }

    /// For each part what it adds to the lower half of `AᵀWA`, row by row of p + 1 numbers.
    pub(super) fn products(&self, weights: Option<&[f64]>) -> Vec<f64> {
        let width = self.width();
        self.sums(width * width, |part, sums, _| {
            let weights = weights.map(|weights| &weights[part.data.clone()]);
            with_width!(width, multiply_all(self.rows(part), weights, sums));
        })
    }

    /// Sums of each part, of a number of them; there is room for a number of each datum of a part.
    fn sums(
        &self,
        count: usize,
        sum_up: impl Fn(&Part, &mut [f64], &mut [f64; BLOCK]) + Sync,
    ) -> Vec<f64> {
        let mut all = vec![0.0; self.parts.len() * count];
        let pieces = cut(&self.groups, &mut all, |group| group.parts.len() * count);
        self.each_group(pieces, |group, sums| {
            let mut room = [0.0; BLOCK];
            let parts = self.parts_of(group).iter();
            let pairs = parts.zip(sums.chunks_exact_mut(count));
            pairs.for_each(|(part, sums)| sum_up(part, sums, &mut room));
        });
        all
    }

    /// Adds sums of the p + 1 functions of a part to those of all functions.
    pub(super) fn add_to(&self, all: &mut [f64], part: &Part, sums: &[f64]) {
        for (k, sum) in sums.iter().enumerate() {
            all[self.line.control_point(part.span + k)] += sum;
        }
    }

    /// The values at the data of a part.
    fn rows(&self, part: &Part) -> &[f64] {
        let width = self.width();
        &self.values[part.data.start * width..part.data.end * width]
    }

    /// The curve of one coordinate at the data of a part.
    fn combine(&self, part: &Part, x: &[f64], y: &mut [f64]) {
        let places = |k: usize| self.line.control_point(part.span + k);
        let local: Vec<f64> = (0..self.width()).map(|k| x[places(k)]).collect();
        with_width!(self.width(), multiply(self.rows(part), &local, y));
    }

    /// The sums of the functions of a part, each multiplied with a number at each of its data.
    fn sum_up(&self, part: &Part, x: &[f64], sums: &mut [f64]) {
        with_width!(self.width(), add(self.rows(part), x, sums));
    }

    /// Cuts coordinates of the data into those of each group.
    fn by_group<'a>(
        &self,
        lanes: &'a mut [impl DerefMut<Target = [f64]>],
    ) -> Vec<Vec<&'a mut [f64]>> {
        let mut rest: Vec<&mut [f64]> = lanes.iter_mut().map(|lane| &mut **lane).collect();
        let mut piece = |group: &Group| {
            let lanes = rest.iter_mut();
            let lanes = lanes.filter_map(|lane| lane.split_off_mut(..group.data.len()));
            lanes.collect()
        };
        self.groups.iter().map(&mut piece).collect()
    }

    /// Calls back with each group and what belongs to it.
    fn each_group<T: Send>(&self, pieces: Vec<T>, work: impl Fn(&Group, T) + Sync) {
        if let [group] = &self.groups[..] {
            pieces.into_iter().for_each(|piece| work(group, piece));
            return;
        }
        let pairs = self.groups.par_iter().zip(pieces);
        pairs.for_each(|(group, piece)| work(group, piece));
    }

    fn parts_of(&self, group: &Group) -> &[Part] {
        &self.parts[group.parts.clone()]
    }
}

/// Spans in parts of equal length, but for the last one of each; without those that have no datum.
fn parts(starts: &[usize]) -> Vec<Part> {
    let spans = starts.windows(2).enumerate();
    let parts = spans.flat_map(|(span, range)| {
        let (start, end) = (range[0], range[1]);
        (start..end).step_by(BLOCK).map(move |start| Part {
            span,
            data: start..end.min(start + BLOCK),
        })
    });
    parts.collect()
}

/// Groups of about equally many data.
fn groups(parts: &[Part], count: usize) -> Vec<Group> {
    let least = if count < MANY { count } else { count / GROUPS };
    let mut groups = Vec::new();
    let mut first = 0;
    for (i, part) in parts.iter().enumerate() {
        let data = parts[first].data.start..part.data.end;
        if data.len() >= least || i + 1 == parts.len() {
            groups.push(Group {
                parts: first..i + 1,
                data,
            });
            first = i + 1;
        }
    }
    groups
}

/// Cuts an array into one piece for each group, with these numbers of elements.
fn cut<'a, T>(
    groups: &[Group],
    mut array: &'a mut [T],
    count: impl Fn(&Group) -> usize,
) -> Vec<&'a mut [T]> {
    let piece = |group| array.split_off_mut(..count(group));
    groups.iter().filter_map(piece).collect()
}

/// Coordinates as slices.
fn slices(lanes: &[impl Deref<Target = [f64]>]) -> Vec<&[f64]> {
    lanes.iter().map(|lane| &**lane).collect()
}
