//! The rows of the collocation matrix of a B-spline direction.
//!
//! Row i has the values `B_j(t_i)` of the p + 1 functions that can differ from zero at parameter
//! t_i. Parameters and knots usually advance together: row i lies in the knot span i + s for long
//! *runs* of rows, with knots at the data all of them but the first and the last few. The functions
//! of a run are evaluated for many rows at a time, by the same operations in the same order as for
//! a single one: O(n p²) in all, on all threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::basis::direction::Direction;
use crate::basis::{Basis, bspline};
use crate::data::aligned::{self, Lane};
use crate::linear::banded::{Banded, Stretch};

/// The number of rows that a thread evaluates at a time.
const CHUNK: usize = 1 << 15;

/// Runs of fewer rows are evaluated row by row.
const SHORT: usize = 8;

/// The matrix with respect to the free control points, n rows of at most p + 1 entries: the columns
/// of end copies are added to the column of the control point that they copy.
pub(crate) fn banded(direction: &Direction) -> Banded {
    let (rows, support) = (direction.parameters.len(), direction.basis.support_width());
    let mut lanes = aligned::lanes(support, rows, |_| Lane::zeros(rows));
    let mut chunks: Vec<Chunk> = (0..rows)
        .step_by(CHUNK)
        .map(|start| Chunk {
            direction,
            rows: start..rows.min(start + CHUNK),
            lanes: Vec::with_capacity(support),
            stretches: Vec::new(),
            values: Vec::new(),
        })
        .collect();
    for lane in &mut lanes {
        for (chunk, lane) in chunks.iter_mut().zip(lane.chunks_mut(CHUNK)) {
            chunk.lanes.push(lane);
        }
    }
    chunks.par_iter_mut().for_each(Chunk::evaluate);
    let mut stretches: Vec<Stretch> = Vec::new();
    for stretch in chunks.into_iter().flat_map(|chunk| chunk.stretches) {
        if stretches
            .last()
            .is_none_or(|last| last.offset != stretch.offset)
        {
            stretches.push(stretch);
        }
    }
    Banded::pack(lanes, &stretches, direction.free())
}

/// Consecutive rows, to be evaluated by one thread.
struct Chunk<'a> {
    direction: &'a Direction,
    /// The rows, by index.
    rows: Range<usize>,
    /// Gets the first entries of these rows, the second ones, and so on.
    lanes: Vec<&'a mut [f64]>,
    /// Gets where the entries of rows start.
    stretches: Vec<Stretch>,
    /// Room for a single row.
    values: Vec<f64>,
}

impl Chunk<'_> {
    /// Evaluates all rows, run by run; rows between runs, and at the end of the domain, by
    /// themselves.
    fn evaluate(&mut self) {
        let direction = self.direction;
        let Basis::BSpline { degree, knots } = &direction.basis else {
            return;
        };
        let (degree, t) = (*degree, &direction.parameters);
        let (low, high) = direction.basis.domain();
        let (mut row, mut span) = (self.rows.start, degree);
        if t[row] < high {
            span = bspline::find_span(degree, knots, t[row]);
        }
        while row < self.rows.end {
            // Parameters of closed directions may lie before their first corner.
            if t[row] >= high || t[row] < low {
                self.single(row, |values| direction.evaluate(t[row], values));
                row += 1;
                continue;
            }
            while knots[span + 1] <= t[row] {
                span += 1;
            }
            let count = self.run(knots, row, span, degree);
            if count < SHORT {
                self.single(row, |values| {
                    bspline::evaluate(degree, knots, span, t[row], values);
                    direction.weigh(span - degree, values)
                });
                row += 1;
            } else {
                self.push(row, direction.free_index(span - degree));
                self.several(knots, row, span, degree, count);
                row += count;
                span += count - 1;
            }
        }
    }

    /// The number of rows from `row` on that lie in knot spans that advance with them, `row + k` in
    /// `span + k`, and have functions each of which has a control point of its own.
    fn run(&self, knots: &[f64], row: usize, span: usize, degree: usize) -> usize {
        let own = self.direction.own_functions();
        let first = span - degree;
        if !own.contains(&first) {
            return 0;
        }
        let most = (self.rows.end - row).min(own.end - first);
        let t = &self.direction.parameters[row..row + most];
        let spans = knots[span..].windows(2);
        let inside = |(t, span): &(&f64, &[f64])| span[0] <= **t && **t < span[1];
        t.iter().zip(spans).take_while(inside).count()
    }

    /// Evaluates the `count` rows of a run from `row`, in `span`, on.
    fn several(&mut self, knots: &[f64], row: usize, span: usize, degree: usize, count: usize) {
        let t = &self.direction.parameters[row..row + count];
        for (k, t) in t.chunks(bspline::BLOCK).enumerate() {
            let behind = k * bspline::BLOCK;
            let (knots, start) = (
                &knots[span - degree + behind..],
                row - self.rows.start + behind,
            );
            let lanes = self.lanes.iter_mut();
            let mut values: Vec<&mut [f64]> = lanes
                .map(|lane| &mut lane[start..start + t.len()])
                .collect();
            bspline::evaluate_run(degree, knots, t, &mut values);
            if let Some(weights) = self.direction.weights() {
                weigh_run(&weights[span - degree + behind..], &mut values);
            }
        }
    }

    /// Evaluates a row by itself, and adds up functions that share a control point.
    fn single(&mut self, row: usize, evaluate: impl FnOnce(&mut [f64]) -> usize) {
        let direction = self.direction;
        let columns = direction.free();
        let mut values = std::mem::take(&mut self.values);
        values.resize(self.lanes.len(), 0.0);
        let start = evaluate(&mut values);
        direction.share(start, &mut values);
        let first = direction.free_index(start);
        for (k, value) in values.iter().enumerate() {
            let column = direction.free_index(start + k);
            let place = (column + columns - first) % columns;
            self.lanes[place][row - self.rows.start] += value;
        }
        self.values = values;
        self.push(row, first);
    }

    /// Notes that from a row on entries start at a column that advances with the rows.
    fn push(&mut self, row: usize, column: usize) {
        let offset = column as i32 - row as i32;
        if self
            .stretches
            .last()
            .is_none_or(|last| last.offset != offset)
        {
            let start = row as u32;
            self.stretches.push(Stretch { start, offset });
        }
    }
}

/// Makes the functions of a run rational, `w_j B_j / Σ w_k B_k` (LBW05 (3.7)), where place i of
/// lane k holds the value of function `i + k`.
fn weigh_run(weights: &[f64], values: &mut [&mut [f64]]) {
    let mut sums = vec![0.0; values.first().map_or(0, |values| values.len())];
    for (k, values) in values.iter_mut().enumerate() {
        for ((value, weight), sum) in values.iter_mut().zip(&weights[k..]).zip(&mut sums) {
            *value *= weight;
            *sum += *value;
        }
    }
    for values in values {
        values
            .iter_mut()
            .zip(&sums)
            .for_each(|(value, sum)| *value /= sum);
    }
}
