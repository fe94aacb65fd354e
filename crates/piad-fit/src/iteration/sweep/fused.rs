//! The innermost loop: `Δ = P − B X` for consecutive rows of a banded matrix, with all coordinates
//! at a time.
//!
//! For row i and coordinate c, with W entries in a row:
//!
//! ```text
//! Δ_i,c = P_i,c − Σ_k b_i,k X_{i+k,c}
//! d_i,c ← momentum d_i,c + gain Δ_i,c,   X'_i,c = X_i,c + d_i,c
//! square_i = Σ_c (scale Δ_i,c)²
//! ```
//!
//! and the squares are summed up, all of it while it is in registers: a level costs `d (W + 3)`
//! multiplications for each point, and each number is loaded once.
//!
//! The loop is written with vectors of the processor's length ([`pulp`]), as compilers do not
//! vectorize loops over this many arrays. Sums are kept in [`LANES`] lanes whatever that length is,
//! so that they are the same on every processor. Rows that are few, unusually long, or reach around
//! the end of a closed curve are computed one by one, by the same operations.

use std::array::from_fn;
use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::vectors::{VectorSums, at, shifted, vectors_of, vectors_of_mut};
use crate::data::blocks::{LANES, Sums};
use crate::linear::banded::Banded;
use crate::method::relaxation::{Coefficients, Step};

/// Stretches of fewer rows are computed row by row.
const SHORT: usize = 2 * LANES;

/// The arrays that are read and written for some rows: one for each of the D coordinates, with a
/// number for each row, but for `x`.
pub(super) struct Rows<'a, const D: usize> {
    /// The columns of X that the rows need, from column `base` on.
    pub x: [&'a [f64]; D],
    /// The column of B that is first in `x`.
    pub base: i64,
    /// The data P at the rows.
    pub data: [&'a [f64]; D],
    /// The control points X at the rows.
    pub own: [&'a [f64]; D],
    /// Gets the control points X' of the next level at the rows.
    pub next: [&'a mut [f64]; D],
    /// The last step d, which is overwritten by the next one; empty without momentum.
    pub step: [&'a mut [f64]; D],
    /// Gets the squares of the scaled residuals, one for each row.
    pub squares: &'a mut [f64],
    /// The place of the first row in its block, which says in which lanes its square is summed up.
    pub place: usize,
}

/// The matrix of the rows, and what becomes of their residuals.
#[derive(Clone, Copy)]
pub(super) struct Update<'a> {
    /// The matrix B.
    pub matrix: &'a Banded,
    /// Where the control points move by their residuals.
    pub step: Step,
    /// The power of two that residuals are multiplied with before they are squared, against over-
    /// and underflow.
    pub scale: f64,
}

impl Update<'_> {
    /// Computes the rows of a whole block, and returns what their squares add up to.
    pub(super) fn apply<const D: usize>(self, rows: Range<usize>, given: &mut Rows<'_, D>) -> Sums {
        let mut sums = Sums::default();
        self.add(rows, given, &mut sums);
        sums
    }

    /// Computes some rows of a block, and adds their squares to those of the others.
    pub(super) fn add<const D: usize>(
        self,
        rows: Range<usize>,
        given: &mut Rows<'_, D>,
        sums: &mut Sums,
    ) {
        for (offset, span) in self.matrix.spans(rows.clone()) {
            let columns = given.x[0].len();
            let whole = self
                .matrix
                .inside(offset, span.clone(), columns, given.base);
            let fused = match self.matrix.width() {
                _ if whole.len() < SHORT => span.start..span.start,
                2..=7 => whole,
                _ => span.start..span.start,
            };
            self.one_by_one(offset, span.start..fused.start, rows.start, given, sums);
            if !fused.is_empty() {
                let first = (fused.start as i64 + i64::from(offset) - given.base) as usize;
                self.fused(fused.clone(), rows.start, first, given, sums);
            }
            self.one_by_one(offset, fused.end..span.end, rows.start, given, sums);
        }
    }

    /// Computes rows of a stretch whose columns are all in `x`: those of the first row stand from
    /// place `first` on. `base` is the first of all given rows.
    fn fused<const D: usize>(
        self,
        rows: Range<usize>,
        base: usize,
        first: usize,
        given: &mut Rows<'_, D>,
        sums: &mut Sums,
    ) {
        match self.matrix.width() {
            2 => self.fused_width::<D, 2>(rows, base, first, given, sums),
            3 => self.fused_width::<D, 3>(rows, base, first, given, sums),
            4 => self.fused_width::<D, 4>(rows, base, first, given, sums),
            5 => self.fused_width::<D, 5>(rows, base, first, given, sums),
            6 => self.fused_width::<D, 6>(rows, base, first, given, sums),
            _ => self.fused_width::<D, 7>(rows, base, first, given, sums),
        }
    }

    /// The same with the number of entries in a row known to the compiler.
    fn fused_width<const D: usize, const W: usize>(
        self,
        rows: Range<usize>,
        base: usize,
        first: usize,
        given: &mut Rows<'_, D>,
        sums: &mut Sums,
    ) {
        let mut fused = Fused::<D, W> {
            b: from_fn(|k| self.matrix.diagonal(k, rows.clone())),
            x: given.x.map(|x| &x[first..]),
            range: rows.start - base..rows.end - base,
            step: self.step,
            scale: self.scale,
            rows: given,
            sums,
        };
        Arch::new().dispatch(Run(&mut fused));
    }

    /// Computes rows that are few, unusually long, or reach around the end of a closed curve.
    fn one_by_one<const D: usize>(
        self,
        offset: i32,
        rows: Range<usize>,
        base: usize,
        given: &mut Rows<'_, D>,
        sums: &mut Sums,
    ) {
        for row in rows {
            let i = row - base;
            let x = given.x;
            let products = x.map(|x| self.matrix.dot_row(row, offset, x, given.base));
            let square = finish(self.step, self.scale, given, i, products);
            sums.add((given.place + i) % LANES, square);
        }
    }
}

/// Consecutive rows of one stretch, with W entries each.
struct Fused<'a, 'b, const D: usize, const W: usize> {
    /// Entry k of all rows, for each k.
    b: [&'a [f64]; W],
    /// Each coordinate of X, from the first entry of the first row on.
    x: [&'a [f64]; D],
    /// The places of the rows among the given ones.
    range: Range<usize>,
    step: Step,
    scale: f64,
    rows: &'a mut Rows<'b, D>,
    sums: &'a mut Sums,
}

/// The loop over the rows, compiled for several instruction sets.
struct Run<'a, 'b, 'c, const D: usize, const W: usize>(&'a mut Fused<'b, 'c, D, W>);

impl<const D: usize, const W: usize> WithSimd for Run<'_, '_, '_, D, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.0.rows.step[0].is_empty() {
            self.0.run::<S, false>(simd);
        } else {
            self.0.run::<S, true>(simd);
        }
    }
}

impl<const D: usize, const W: usize> Fused<'_, '_, D, W> {
    /// Single rows up to a multiple of [`LANES`] in the block, then vectors of rows, then the rows
    /// that are left.
    #[inline(always)]
    fn run<S: Simd, const MOMENTUM: bool>(&mut self, simd: S) {
        let Range { start, end } = self.range;
        let place = self.rows.place + start;
        let head = (start + place.next_multiple_of(LANES) - place).min(end);
        let tail = end - (end - head) % LANES;
        for i in start..head {
            self.row(i);
        }
        if tail > head {
            self.vectors::<S, MOMENTUM>(simd, head..tail);
        }
        for i in tail..end {
            self.row(i);
        }
    }

    /// Rows as vectors, in rounds that fill the lanes: each round computes [`LANES`] rows, and adds
    /// their squares to the lanes in order. The branch on the step is the same in all rounds, so
    /// that the processor predicts it.
    #[inline(always)]
    fn vectors<S: Simd, const MOMENTUM: bool>(&mut self, simd: S, range: Range<usize>) {
        let (start, rounds) = (range.start, range.len() / LANES);
        let behind = start - self.range.start;
        // Vectors that fill the lanes.
        let vectors = LANES / S::F64_LANES;
        let n = rounds * vectors;
        let mut sums = VectorSums::<S>::new(self.sums);
        let rows = &mut *self.rows;
        let b = vectors_of::<S, W>(self.b, behind, n);
        let x = shifted::<S, D, W>(self.x, behind, n);
        let data = vectors_of::<S, D>(rows.data, start, n);
        let own = vectors_of::<S, D>(rows.own, start, n);
        let next = vectors_of_mut::<S, D>(&mut rows.next, start, n);
        let (start_step, n_step) = if MOMENTUM { (start, n) } else { (0, 0) };
        let step = vectors_of_mut::<S, D>(&mut rows.step, start_step, n_step);
        let squares = &mut S::as_mut_simd_f64s(&mut rows.squares[start..]).0[..n];
        let becomes = self.step;
        let Coefficients { momentum, gain } = match becomes {
            Step::Move(coefficients) => coefficients,
            Step::Keep | Step::Residual => Coefficients::default(),
        };
        let [momentum, gain] = [momentum, gain].map(|factor| simd.splat_f64s(factor));
        let scale = simd.splat_f64s(self.scale);
        for round in 0..rounds {
            for vector in 0..vectors {
                let i = round * vectors + vector;
                let row = at(&b, i);
                let mut square = simd.splat_f64s(0.0);
                for c in 0..D {
                    let mut sum = simd.mul_f64s(row[0], x[c][0][i]);
                    for k in 1..W {
                        sum = simd.add_f64s(sum, simd.mul_f64s(row[k], x[c][k][i]));
                    }
                    let delta = simd.sub_f64s(data[c][i], sum);
                    // The same branch in all rounds costs less than a loop for each.
                    next[c][i] = match becomes {
                        Step::Keep => own[c][i],
                        Step::Residual => delta,
                        Step::Move(_) => {
                            let mut move_by = simd.mul_f64s(gain, delta);
                            if MOMENTUM {
                                let kept = simd.mul_f64s(momentum, step[c][i]);
                                move_by = simd.add_f64s(kept, move_by);
                                step[c][i] = move_by;
                            }
                            simd.add_f64s(own[c][i], move_by)
                        }
                    };
                    let scaled = simd.mul_f64s(delta, scale);
                    square = simd.add_f64s(square, simd.mul_f64s(scaled, scaled));
                }
                squares[i] = square;
                sums.add(simd, vector, square);
            }
        }
        sums.store(self.sums);
    }

    /// Computes row `i` of the given ones.
    #[inline(always)]
    fn row(&mut self, i: usize) {
        let local = i - self.range.start;
        let mut products = [0.0; D];
        for (sum, x) in products.iter_mut().zip(&self.x) {
            let x = &x[local..];
            let product = |k: usize| self.b[k][local] * x[k];
            *sum = (1..W).fold(product(0), |sum, k| sum + product(k));
        }
        let place = self.rows.place + i;
        let square = finish(self.step, self.scale, self.rows, i, products);
        self.sums.add(place % LANES, square);
    }
}

/// Moves the control point of row `i`, where `products` is `(B X)_i`; returns the square of its
/// scaled residual.
#[inline(always)]
fn finish<const D: usize>(
    step: Step,
    scale: f64,
    rows: &mut Rows<'_, D>,
    i: usize,
    products: [f64; D],
) -> f64 {
    let mut square = 0.0;
    for (c, product) in products.into_iter().enumerate() {
        let delta = rows.data[c][i] - product;
        rows.next[c][i] = match (step, rows.step[c].get_mut(i)) {
            (Step::Keep, _) => rows.own[c][i],
            (Step::Residual, _) => delta,
            (Step::Move(Coefficients { gain, .. }), None) => rows.own[c][i] + gain * delta,
            (Step::Move(Coefficients { momentum, gain }), Some(step)) => {
                *step = momentum * *step + gain * delta;
                rows.own[c][i] + *step
            }
        };
        let scaled = delta * scale;
        square += scaled * scaled;
    }
    rows.squares[i] = square;
    square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::aligned::Lane;
    use crate::data::blocks::Squares;

    /// The number of rows.
    const N: usize = 83;

    /// Numbers of all signs.
    fn lane(seed: usize) -> Lane {
        let number = |i| ((i * 37 + seed * 101) as f64).sin() * 10.0;
        (0..N + 3).map(number).collect()
    }

    /// The bits of all that a loop computes, with the given instruction set.
    fn bits<S: Simd>(simd: S, place: usize, step: Step, momentum: bool) -> Vec<u64> {
        let [b, x, data, own] = [0, 3, 6, 9].map(|seed| [0, 1, 2].map(|c| lane(seed + c)));
        let [mut next, mut last] = [12, 15].map(|seed| [0, 1, 2].map(|c| lane(seed + c)));
        let (mut squares, mut sums) = (Squares::new(), Sums::default());
        let steps = if momentum { N } else { 0 };
        let mut fused = Fused::<3, 3> {
            b: b.each_ref().map(|lane| &lane[5..N]),
            x: x.each_ref().map(|lane| &lane[4..]),
            range: 5..N,
            step,
            scale: 0.125,
            rows: &mut Rows {
                x: x.each_ref().map(|lane| &lane[..]),
                base: 0,
                data: data.each_ref().map(|lane| &lane[..N]),
                own: own.each_ref().map(|lane| &lane[..N]),
                next: next.each_mut().map(|lane| &mut lane[..N]),
                step: last.each_mut().map(|lane| &mut lane[..steps]),
                squares: squares.first(N),
                place,
            },
            sums: &mut sums,
        };
        Run(&mut fused).with_simd(simd);
        let written = next.iter().chain(&last).flatten();
        let sums = [sums.max, sums.squares, sums.roots];
        let squares = squares.first(N).iter();
        let all = written.chain(squares).chain(sums.iter().flatten());
        all.map(|x| x.to_bits()).collect()
    }

    /// Vectors of any length compute the same bits.
    #[test]
    fn instruction_sets_agree() {
        /// The loop with the instructions of this processor.
        struct Here(usize, Step, bool);
        impl WithSimd for Here {
            type Output = Vec<u64>;

            fn with_simd<S: Simd>(self, simd: S) -> Vec<u64> {
                bits(simd, self.0, self.1, self.2)
            }
        }
        let coefficients = Coefficients {
            momentum: 0.3,
            gain: 1.2,
        };
        let moves = Step::Move(coefficients);
        for (step, momentum) in [
            (Step::Keep, false),
            (Step::Residual, false),
            (moves, false),
            (moves, true),
        ] {
            for place in [0, 3, 1001] {
                let here = Arch::new().dispatch(Here(place, step, momentum));
                assert_eq!(bits(pulp::Scalar::new(), place, step, momentum), here);
            }
        }
    }
}
