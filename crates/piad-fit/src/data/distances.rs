//! How far a curve or a surface is from the data.

use pulp::Arch;
use rayon::prelude::*;

use super::aligned::Lane;
use super::blocks::{BLOCK, Block};
use super::points::Points;

/// The distances of more data are computed by several threads.
const PARALLEL: usize = 32_768;

/// Distances of the data, in data units. If one of them is not a number, no norm is.
#[derive(Clone, Debug)]
pub(crate) struct Distances {
    /// `‖P_i − C(t_i)‖`.
    pub each: Vec<f64>,
    /// The largest.
    pub max: f64,
    /// The first datum that has it.
    pub at: usize,
    /// The root of the mean of the squared ones.
    pub rms: f64,
    /// Their sum.
    pub sum: f64,
}

impl Distances {
    /// Of a residual, with lengths that are multiplied with `unit`, a power of two, before they are
    /// squared.
    pub(crate) fn of_residual(residual: &Points, unit: f64) -> Self {
        Self::by_blocks(vec![0.0; residual.len()], unit, |start, squares| {
            sum_squares(residual.lanes(), start, unit, squares);
        })
    }

    /// Of squares.
    pub(crate) fn of_squares(squares: Vec<f64>, unit: f64) -> Self {
        Self::by_blocks(squares, unit, |_, _| ())
    }

    /// Those of the first data alone.
    pub(crate) fn of_first(&self, count: usize, unit: f64) -> Self {
        let first = self.each[..count].iter();
        let squares = first.map(|distance| (distance * unit) * (distance * unit));
        Self::of_squares(squares.collect(), unit)
    }

    /// The same without what is free of each.
    pub(crate) fn beyond(&self, freedom: &[f64], unit: f64) -> Self {
        let left = |(distance, free): (&f64, &f64)| match distance - free {
            left if left < 0.0 => 0.0,
            left => (left * unit) * (left * unit),
        };
        let squares = self.each.iter().zip(freedom).map(left);
        Self::of_squares(squares.collect(), unit)
    }

    /// Of squares that are completed block by block before they are measured.
    fn by_blocks(
        mut each: Vec<f64>,
        unit: f64,
        complete: impl Fn(usize, &mut [f64]) + Sync,
    ) -> Self {
        let block = |(index, squares): (usize, &mut [f64])| {
            complete(index * BLOCK, squares);
            measure(index * BLOCK, squares, unit)
        };
        let blocks: Vec<Block> = if each.len() < PARALLEL {
            each.chunks_mut(BLOCK).enumerate().map(block).collect()
        } else {
            let blocks = each.par_chunks_mut(BLOCK).enumerate();
            blocks
                .with_min_len(PARALLEL / BLOCK / 4)
                .map(block)
                .collect()
        };
        Self::of_blocks(each, &blocks, unit)
    }

    /// Of distances that have been measured in blocks.
    pub(crate) fn of_blocks(each: Vec<f64>, blocks: &[Block], unit: f64) -> Self {
        let total = Block::total(blocks);
        let max = match total.squares.is_nan() {
            true => f64::NAN,
            false => total.max.sqrt() / unit,
        };
        Self {
            max,
            at: total.at,
            rms: (total.squares / each.len() as f64).sqrt() / unit,
            sum: total.roots / unit,
            each,
        }
    }
}

/// Writes `Σ_c (unit Δ_i,c)²` for consecutive points from `start` on.
pub(crate) fn sum_squares(residual: &[Lane], start: usize, unit: f64, squares: &mut [f64]) {
    squares.fill(0.0);
    for lane in residual {
        for (square, x) in squares.iter_mut().zip(&lane[start..]) {
            let x = x * unit;
            *square += x * x;
        }
    }
}

/// The norms of a block of data from `start` on, by their squares, in the place of which it puts the
/// distances.
pub(crate) fn measure(start: usize, squares: &mut [f64], unit: f64) -> Block {
    let block = Block::of(start, squares);
    Arch::new().dispatch(|| {
        let squares = squares.iter_mut();
        squares.for_each(|square| *square = square.sqrt() * (1.0 / unit));
    });
    block
}
