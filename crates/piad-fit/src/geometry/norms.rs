//! Distances of a curve from its data.
//!
//! ```text
//! max = max_i ‖Δ_i‖,   rms = √(Σ_i ‖Δ_i‖² / n),   sum = Σ_i ‖Δ_i‖,   Δ = P − B X
//! ```
//!
//! The largest one is the fitting error of the papers; Lin10 has the sum. They are computed
//! block by block (`blocks`): after a local update only the blocks that it has touched are
//! measured again, and blocks can be measured anywhere and in any order, with the same errors to
//! the last bit. Residuals are scaled by a power of two before they are squared, so that data of
//! any magnitude have the same errors in their own units.
//!
//! In a homogeneous fit residuals are those of `(w P, w)`. Then the distances are those of points,
//! `‖P_i − C(t_i)‖` with the projected curve C (Lin10, section 3.4), and the largest homogeneous
//! residual is told apart. A point at which the weight of the curve is not positive is at an
//! infinite distance.

use crate::data::blocks::{BLOCK, Block, Blocks};
use crate::data::distances::{Distances, sum_squares};
use crate::data::points::{self, Points, normalizing_scale};
use crate::setup::Setup;

/// Distances of the curve from the data, in data units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitError {
    /// The largest distance: the fitting error of the papers and of the stop rule.
    pub max: f64,
    /// The index of the data point with the largest distance, the first if there are several.
    pub at: usize,
    /// The root of the mean of the squared distances.
    pub rms: f64,
    /// The sum of the distances (the error of Lin10).
    pub sum: f64,
    /// The largest distance of the points that do not count in the other numbers: in local fits the
    /// fixed ones, in least-squares fits the missing ones, which have none.
    pub fixed_max: Option<f64>,
    /// Homogeneous fits: the largest distance in homogeneous coordinates; the other numbers are
    /// distances of points.
    pub homogeneous: Option<f64>,
    /// Least-squares fits: `‖Aᵀr‖² / ‖Aᵀr⁰‖²`, zero at the minimum.
    pub gradient: Option<f64>,
    /// Extended fits that are asked for it: the largest length of a step, `max_i ‖(U Δ)_i‖`, in data
    /// units, of homogeneous fits in homogeneous coordinates.
    pub transformed: Option<f64>,
}

impl FitError {
    /// The distances of a fit that chooses its knots.
    pub(crate) fn of(distances: &Distances) -> Self {
        Self {
            max: distances.max,
            at: distances.at,
            rms: distances.rms,
            sum: distances.sum,
            fixed_max: None,
            homogeneous: None,
            gradient: None,
            transformed: None,
        }
    }

    /// Distances that are not finite.
    pub(crate) fn unknown() -> Self {
        Self::of(&Distances {
            each: Vec::new(),
            max: f64::INFINITY,
            at: 0,
            rms: f64::INFINITY,
            sum: 0.0,
        })
    }

    /// Whether all of them are finite.
    pub fn is_finite(&self) -> bool {
        let more = [
            self.fixed_max,
            self.homogeneous,
            self.gradient,
            self.transformed,
        ];
        let all = [self.max, self.rms, self.sum]
            .into_iter()
            .chain(more.into_iter().flatten());
        all.into_iter().all(f64::is_finite)
    }
}

/// Measures residuals, and remembers the norms of every block.
#[derive(Clone, Debug)]
pub(crate) struct Norms {
    /// A power of two that brings the data to the order of one, so that squares of distances
    /// neither over- nor underflow.
    scale: f64,
    /// The same for homogeneous coordinates.
    homogeneous_scale: f64,
    /// Whether the last coordinate is a weight.
    homogeneous: bool,
    /// Which points count; all of them without it.
    counted: Option<Vec<bool>>,
    /// How many points count.
    count: usize,
    layout: Blocks,
    /// The norms of each block, as it was last measured.
    blocks: Vec<Block>,
}

impl Norms {
    /// Of the data of a fit; `counted` says which points count.
    pub(crate) fn new(setup: &Setup, counted: Option<Vec<bool>>) -> Self {
        let (data, homogeneous) = (setup.data(), setup.is_homogeneous());
        let count = counted.as_ref().map_or(data.len(), |counted| {
            counted.iter().filter(|counted| **counted).count()
        });
        let extents = setup.extents();
        let largest = points::magnitude(extents);
        // Equal points leave rounding errors of their magnitude.
        let noise = f64::EPSILON
            * match homogeneous {
                true => projected_magnitude(data),
                false => largest,
            };
        let homogeneous_length = points::diagonal(extents).max(largest * f64::EPSILON);
        let layout = Blocks::new(setup.grid());
        Self {
            scale: normalizing_scale(setup.diagonal().max(noise)),
            homogeneous_scale: normalizing_scale(homogeneous_length),
            homogeneous,
            counted,
            count,
            layout,
            blocks: vec![Block::default(); layout.count()],
        }
    }

    /// Measures all points, in O(n d).
    pub(crate) fn measure(&mut self, data: &Points, residual: &Points) -> FitError {
        for index in 0..self.blocks.len() {
            self.blocks[index] = self.block(index, data, residual);
        }
        self.error()
    }

    /// Measures again, after the residual of the points `changed` (increasing indices) has changed:
    /// only their blocks.
    pub(crate) fn measure_again(
        &mut self,
        data: &Points,
        residual: &Points,
        changed: &[usize],
    ) -> FitError {
        let mut last = None;
        for index in changed.iter().map(|&point| self.layout.of(point)) {
            if last != Some(index) {
                self.blocks[index] = self.block(index, data, residual);
                last = Some(index);
            }
        }
        self.error()
    }

    /// The Euclidean length of the residual, up to a factor: what least-squares fits minimize. In
    /// homogeneous fits it is that of homogeneous coordinates, rather than of distances of points.
    pub(crate) fn residual_length(&self) -> f64 {
        let squares = |block: &Block| match self.homogeneous {
            true => block.homogeneous_squares,
            false => block.squares,
        };
        self.blocks.iter().map(squares).sum::<f64>().sqrt()
    }

    /// The distances of the curve from consecutive data points from `start` on, in data units.
    pub(crate) fn distances(
        &self,
        data: &Points,
        residual: &Points,
        start: usize,
        distances: &mut [f64],
    ) {
        self.squares(start, data, residual, distances);
        for square in distances {
            *square = square.sqrt() / self.scale;
        }
    }

    /// The error by the norms of all blocks.
    fn error(&self) -> FitError {
        let total = Block::total(&self.blocks);
        FitError {
            fixed_max: self.counted.as_ref().map(|_| self.length(total.rest_max)),
            homogeneous: self
                .homogeneous
                .then(|| total.homogeneous_max.sqrt() / self.homogeneous_scale),
            ..self.error_of(&total)
        }
    }

    /// The error of a fit of which all points count, from all its blocks taken together.
    pub(crate) fn error_of(&self, total: &Block) -> FitError {
        FitError {
            max: self.length(total.max),
            at: total.at,
            rms: self.length(total.squares / self.count.max(1) as f64),
            sum: total.roots / self.scale,
            fixed_max: None,
            homogeneous: None,
            gradient: None,
            transformed: None,
        }
    }

    /// The power of two that residuals are multiplied with before they are squared.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// The length whose scaled square this is, in data units.
    fn length(&self, square: f64) -> f64 {
        square.sqrt() / self.scale
    }

    /// Measures a block.
    fn block(&self, index: usize, data: &Points, residual: &Points) -> Block {
        let points = self.layout.points(index);
        let start = points.start;
        let mut buffer = [0.0; BLOCK];
        let squares = &mut buffer[..points.len()];
        self.squares(start, data, residual, squares);
        let rest_max = self.take_out_uncounted(start, squares);
        let mut block = Block::of(start, squares);
        block.rest_max = rest_max;
        if self.homogeneous {
            sum_squares(residual.lanes(), start, self.homogeneous_scale, squares);
            self.take_out_uncounted(start, squares);
            let homogeneous = Block::of(start, squares);
            block.homogeneous_max = homogeneous.max;
            block.homogeneous_squares = homogeneous.squares;
        }
        block
    }

    /// Sets the squares of points that do not count to zero, and returns the largest of them.
    fn take_out_uncounted(&self, start: usize, squares: &mut [f64]) -> f64 {
        let Some(counted) = &self.counted else {
            return 0.0;
        };
        let uncounted = squares
            .iter_mut()
            .zip(&counted[start..])
            .filter(|(_, counts)| !**counts);
        uncounted.fold(0.0, |largest, (square, _)| {
            std::mem::take(square).max(largest)
        })
    }

    /// Writes the squares of the scaled distances of consecutive points from `start` on.
    fn squares(&self, start: usize, data: &Points, residual: &Points, squares: &mut [f64]) {
        if !self.homogeneous {
            return sum_squares(residual.lanes(), start, self.scale, squares);
        }
        let (Some((weights, coordinates)), Some((weight_residual, residuals))) =
            (data.lanes().split_last(), residual.lanes().split_last())
        else {
            return;
        };
        for (i, square) in squares.iter_mut().enumerate() {
            let i = start + i;
            // The weight of the curve at this parameter. Where it is not positive, the point is at
            // infinity or beyond.
            let weight = weights[i] - weight_residual[i];
            *square = if weight > 0.0 {
                let lanes = coordinates.iter().zip(residuals);
                lanes.fold(0.0, |sum, (q, delta)| {
                    let x = (q[i] / weights[i] - (q[i] - delta[i]) / weight) * self.scale;
                    sum + x * x
                })
            } else {
                f64::INFINITY
            };
        }
    }
}

/// The largest absolute coordinate of data points that are given in homogeneous coordinates.
fn projected_magnitude(data: &Points) -> f64 {
    let Some((weights, lanes)) = data.lanes().split_last() else {
        return 0.0;
    };
    let coordinates = lanes.iter().flat_map(|lane| lane.iter().zip(weights));
    coordinates.fold(0.0, |largest, (q, weight)| (q / weight).abs().max(largest))
}
