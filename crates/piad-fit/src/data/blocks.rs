//! Blocks of consecutive points, and the norms of their distances.
//!
//! A block has at most 1024 points: its numbers stay in the nearest cache. In a block the squares
//! of distances are summed up in eight *lanes*, number k in lane k mod 8, then the lanes pairwise,
//! and then the blocks from the first to the last. That order is the same for every loop,
//! instruction set and number of threads, so that errors are reproducible to the last bit.

use std::ops::Range;

use super::grid::Grid;

/// The most points of a block: 8 KiB for each coordinate.
pub(crate) const BLOCK: usize = 1024;

/// The number of lanes, sums that are kept side by side: the longest vectors of today's processors.
pub(crate) const LANES: usize = 8;

/// The division of a grid into blocks: several whole lines, or equal parts of one line. (A curve is
/// a grid of lines with one point each.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    grid: Grid,
    /// The number of whole lines in a block, or one if a line has several blocks.
    lines: usize,
    /// The number of blocks of a line, or one if a block has several lines.
    parts: usize,
}

impl Blocks {
    /// The blocks of a grid.
    pub(crate) fn new(grid: Grid) -> Self {
        Self {
            grid,
            lines: (BLOCK / grid.columns.max(1)).max(1),
            parts: grid.columns.div_ceil(BLOCK).max(1),
        }
    }

    /// Their number.
    pub(crate) fn count(self) -> usize {
        self.grid.rows.div_ceil(self.lines) * self.parts
    }

    /// The numbers of whole lines that make whole blocks: (lines, blocks), one of which is 1.
    pub(crate) fn unit(self) -> (usize, usize) {
        (self.lines, self.parts)
    }

    /// The block of a point.
    pub(crate) fn of(self, point: usize) -> usize {
        let (line, column) = (point / self.grid.columns, point % self.grid.columns);
        line / self.lines * self.parts + column / BLOCK
    }

    /// The points of a block.
    pub(crate) fn points(self, index: usize) -> Range<usize> {
        let Grid { rows, columns } = self.grid;
        let line = index / self.parts * self.lines;
        let end = (line + self.lines).min(rows) * columns;
        let start = line * columns + index % self.parts * BLOCK;
        start..(start + self.length()).min(end)
    }

    /// The most points of a block of this grid.
    fn length(self) -> usize {
        if self.parts == 1 {
            self.lines * self.grid.columns
        } else {
            BLOCK
        }
    }
}

/// The norms of the points of a block, by the squares of their scaled distances.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Block {
    /// The largest square.
    pub max: f64,
    /// The first point with it.
    pub at: usize,
    /// The sum of the squares.
    pub squares: f64,
    /// The sum of their roots.
    pub roots: f64,
    /// The largest square of points that do not count in the other norms.
    pub rest_max: f64,
    /// The largest square in homogeneous coordinates.
    pub homogeneous_max: f64,
    /// The sum of the squares in homogeneous coordinates.
    pub homogeneous_squares: f64,
}

/// The squares of a block, summed up in lanes: number k of a block goes to lane k mod [`LANES`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// The largest square.
    pub max: [f64; LANES],
    /// The sum of the squares.
    pub squares: [f64; LANES],
    /// The sum of their roots.
    pub roots: [f64; LANES],
}

impl Sums {
    /// The sums of all squares of a block.
    pub(crate) fn of(squares: &[f64]) -> Self {
        pulp::Arch::new().dispatch(AddUp(squares))
    }

    /// Adds a square to its lane.
    #[inline(always)]
    pub(crate) fn add(&mut self, lane: usize, square: f64) {
        self.max[lane] = larger(square, self.max[lane]);
        self.squares[lane] += square;
        self.roots[lane] += square.sqrt();
    }
}

/// Sums up a block, compiled for several instruction sets.
struct AddUp<'a>(&'a [f64]);

impl pulp::NullaryFnOnce for AddUp<'_> {
    type Output = Sums;

    #[inline(always)]
    fn call(self) -> Sums {
        let mut sums = Sums::default();
        let (chunks, rest) = self.0.as_chunks::<LANES>();
        for chunk in chunks {
            let roots = chunk.map(f64::sqrt);
            for lane in 0..LANES {
                sums.max[lane] = larger(chunk[lane], sums.max[lane]);
                sums.squares[lane] += chunk[lane];
                sums.roots[lane] += roots[lane];
            }
        }
        for (lane, &square) in rest.iter().enumerate() {
            sums.add(lane, square);
        }
        sums
    }
}

/// Room for the squares of a block, from the start of a cache line on.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Squares([f64; BLOCK]);

impl Squares {
    /// All zero.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([0.0; BLOCK])
    }

    /// The first `count`.
    #[inline(always)]
    pub(crate) fn first(&mut self, count: usize) -> &mut [f64] {
        &mut self.0[..count]
    }
}

impl Default for Squares {
    fn default() -> Self {
        Self::new()
    }
}

/// The larger one of both, where NaN is never the larger one.
#[inline(always)]
fn larger(square: f64, max: f64) -> f64 {
    if square > max { square } else { max }
}

impl Block {
    /// The norms of consecutive points from `start` on, by their squares.
    pub(crate) fn of(start: usize, squares: &[f64]) -> Self {
        Self::new(start, squares, &Sums::of(squares))
    }

    /// The same, if the squares have been summed up.
    pub(crate) fn new(start: usize, squares: &[f64], sums: &Sums) -> Self {
        let max = sums.max.into_iter().fold(0.0, f64::max);
        let mut block = Self {
            max,
            squares: add_up(sums.squares),
            roots: add_up(sums.roots),
            ..Self::default()
        };
        if max > 0.0 {
            block.at = start + pulp::Arch::new().dispatch(Position(squares, max));
        }
        block
    }

    /// The norms of consecutive blocks together.
    pub(crate) fn total(blocks: &[Self]) -> Self {
        let mut total = Self::default();
        for block in blocks {
            if block.max > total.max {
                total.max = block.max;
                total.at = block.at;
            }
            total.squares += block.squares;
            total.roots += block.roots;
            total.rest_max = total.rest_max.max(block.rest_max);
            total.homogeneous_max = total.homogeneous_max.max(block.homogeneous_max);
            total.homogeneous_squares += block.homogeneous_squares;
        }
        total
    }
}

/// The sum of all lanes, pair by pair.
#[inline(always)]
pub(crate) fn add_up(lanes: [f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// The first place of a value that occurs among others, compiled for several instruction sets. It
/// compares chunk by chunk, as comparing more numbers is quicker than a branch for each.
struct Position<'a>(&'a [f64], f64);

impl pulp::NullaryFnOnce for Position<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        const CHUNK: usize = 4 * LANES;
        let Self(values, value) = self;
        let (chunks, _) = values.as_chunks::<CHUNK>();
        let mut before = 0;
        for chunk in chunks {
            let mut found = false;
            for &x in chunk {
                found |= x == value;
            }
            if found {
                break;
            }
            before += CHUNK;
        }
        let within = values[before..].iter().position(|&x| x == value);
        before + within.unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves, grids of short lines and grids of long ones.
    #[test]
    fn blocks_cover_every_grid_without_overlap() {
        for (rows, columns) in [
            (1, 1),
            (700, 1),
            (3, 300),
            (40, 11),
            (5, 256),
            (2, 1000),
            (9, 200),
            (3000, 1),
            (2, 2500),
        ] {
            let blocks = Blocks::new(Grid { rows, columns });
            let mut next = 0;
            for index in 0..blocks.count() {
                let points = blocks.points(index);
                assert!(points.start == next && points.len() <= BLOCK && !points.is_empty());
                assert!(points.clone().all(|point| blocks.of(point) == index));
                next = points.end;
            }
            assert_eq!(next, rows * columns);
        }
    }

    /// And NaN is never the largest.
    #[test]
    fn the_first_of_equal_distances_is_named() {
        let mut squares = vec![1.0; 100];
        assert_eq!(Block::of(7, &squares).at, 7);
        squares[33] = 4.0;
        squares[34] = 4.0;
        squares[50] = f64::NAN;
        let block = Block::of(7, &squares);
        assert_eq!((block.at, block.max), (40, 4.0));
        assert_eq!(Block::of(7, &[0.0; 3]).at, 0);
        assert_eq!(Block::of(7, &[1.0; 99]).roots, 99.0);
    }
}
