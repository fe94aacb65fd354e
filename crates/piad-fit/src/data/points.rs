//! Ordered points, stored coordinate by coordinate.
//!
//! Data points, control points and residuals of R^d (a weight of homogeneous coordinates is the last
//! one). The points of a surface are stored row by row: point (i, j) of a
//! [`Grid`] with c columns has index `i c + j`.

use std::ops::Range;

use rayon::prelude::*;
#[cfg(feature = "serde")]
use serde::de::Error;
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer};

use super::aligned::{self, Lane};
use super::bounds::Extent;

/// The most coordinates of a data point of a curve.
pub const MAX_DIMENSION: usize = 16;

/// The most coordinates of a data point of a surface.
pub const MAX_SURFACE_DIMENSION: usize = 3;

/// From this number of points on, extents are found by several threads.
const PARALLEL: usize = 100_000;

/// Points of R^d as `d` arrays of coordinates ("lanes") of equal length.
///
/// Kernels run over one coordinate at a time, so each coordinate is contiguous. The memory is 8 d
/// bytes for each point.
///
/// ```
/// use piad_fit::data::Points;
///
/// let mut points = Points::new(2);
/// points.push(&[0.0, 1.0]);
/// points.push(&[3.0, 5.0]);
/// assert_eq!(points.lane(0), [0.0, 3.0]);
/// assert_eq!(points.distance(0, 1), 5.0);
/// ```
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Points {
    lanes: Vec<Lane>,
}

impl Points {
    /// No points yet, of the given dimension (number of coordinates).
    pub fn new(dimension: usize) -> Self {
        Self {
            lanes: vec![Lane::new(); dimension],
        }
    }

    /// `count` points at the origin.
    pub fn zeros(dimension: usize, count: usize) -> Self {
        Self {
            lanes: aligned::lanes(dimension, count, |_| Lane::zeros(count)),
        }
    }

    /// Points of given lanes of equal length.
    pub fn from_lanes(lanes: impl IntoIterator<Item: Into<Lane>>) -> Self {
        Self {
            lanes: lanes.into_iter().map(Into::into).collect(),
        }
    }

    /// Points whose coordinates follow one another, point by point.
    pub fn from_flat(dimension: usize, flat: &[f64]) -> Self {
        Self::from_parts(dimension, &[flat])
    }

    /// The same of parts that follow one another, each of whole points.
    pub(crate) fn from_parts(dimension: usize, parts: &[&[f64]]) -> Self {
        let numbers: usize = parts.iter().map(|part| part.len()).sum();
        let mut points = Self::with_room(dimension, numbers / dimension);
        points.extend_from_parts(parts);
        points
    }

    /// No points, with capacity for `count`.
    pub fn with_room(dimension: usize, count: usize) -> Self {
        let lanes = (0..dimension).map(|_| Lane::with_room(count));
        Self {
            lanes: lanes.collect(),
        }
    }

    /// Appends points whose coordinates follow one another, in parts of whole points; many of them by several
    /// threads.
    pub fn extend_from_parts(&mut self, parts: &[&[f64]]) {
        let dimension = self.lanes.len();
        let extend = |(c, lane): (usize, &mut Lane)| {
            for part in parts {
                let numbers = part.iter().skip(c).step_by(dimension);
                numbers.for_each(|x| lane.push(*x));
            }
        };
        let numbers: usize = parts.iter().map(|part| part.len()).sum();
        match numbers / dimension.max(1) {
            PARALLEL.. => self.lanes.par_iter_mut().enumerate().for_each(extend),
            _ => self.lanes.iter_mut().enumerate().for_each(extend),
        }
    }

    /// Copies the coordinates of the points from `start` on, point by point, until `numbers` is full.
    pub fn copy_flat(&self, start: usize, numbers: &mut [f64]) {
        let points = start..start + numbers.len() / self.dimension().max(1);
        let part = |c: usize| &self.lanes[c][points.clone()];
        match self.lanes.len() {
            1 => numbers.copy_from_slice(part(0)),
            2 => interleave([part(0), part(1)], numbers),
            3 => interleave([part(0), part(1), part(2)], numbers),
            dimension => {
                for c in 0..dimension {
                    let to = numbers.iter_mut().skip(c).step_by(dimension);
                    to.zip(part(c)).for_each(|(to, x)| *to = *x);
                }
            }
        }
    }

    /// The coordinates, point by point.
    pub fn to_flat(&self) -> Vec<f64> {
        let mut flat = vec![0.0; self.len() * self.dimension()];
        self.copy_flat(0, &mut flat);
        flat
    }

    /// Appends one point; coordinates beyond the dimension are ignored.
    pub fn push(&mut self, coordinates: &[f64]) {
        for (lane, &x) in self.lanes.iter_mut().zip(coordinates) {
            lane.push(x);
        }
    }

    /// Number of coordinates of each point.
    pub fn dimension(&self) -> usize {
        self.lanes.len()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.lanes.first().map_or(0, |lane| lane.len())
    }

    /// Returns true if there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All values of coordinate `c`.
    pub fn lane(&self, c: usize) -> &[f64] {
        &self.lanes[c]
    }

    /// The lanes, one for each coordinate.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// The lanes, to be written.
    pub fn lanes_mut(&mut self) -> &mut [Lane] {
        &mut self.lanes
    }

    /// The coordinates of point `i`.
    pub fn point(&self, i: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.lanes.iter().map(move |lane| lane[i])
    }

    /// Some of the points, in this order.
    pub(crate) fn selected(&self, indices: impl Iterator<Item = usize> + Clone) -> Self {
        let lanes = self.lanes.iter();
        Self::from_lanes(lanes.map(|lane| indices.clone().map(|i| lane[i]).collect::<Vec<_>>()))
    }

    /// Euclidean distance between points `i` and `j`, without intermediate over- or underflow.
    pub fn distance(&self, i: usize, j: usize) -> f64 {
        norm(self.lanes.iter().map(|lane| lane[j] - lane[i]))
    }

    /// Writes the distances between points `from + i` and `to + i` to each place i of `distances`,
    /// several at a time; where squares would over- or underflow, one by one.
    pub fn distances(&self, from: usize, to: usize, distances: &mut [f64]) {
        pulp::Arch::new().dispatch(Squares {
            lanes: &self.lanes,
            from,
            to,
            squares: distances,
        });
        let extent = Extent::of(distances);
        if SAFE.contains(&extent.low) && SAFE.contains(&extent.high) && extent.is_finite {
            pulp::Arch::new().dispatch(|| distances.iter_mut().for_each(|x| *x = x.sqrt()));
        } else {
            for (i, distance) in distances.iter_mut().enumerate() {
                *distance = self.distance(from + i, to + i);
            }
        }
    }

    /// Adds the coordinates of other points, one to one.
    pub fn add(&mut self, others: &Self) {
        for (lane, others) in self.lanes.iter_mut().zip(&others.lanes) {
            let parts = lane
                .par_chunks_mut(PARALLEL)
                .zip(others.par_chunks(PARALLEL));
            parts.for_each(|(lane, others)| lane.iter_mut().zip(others).for_each(|(x, y)| *x += y));
        }
    }

    /// The extent of each coordinate.
    pub(crate) fn extents(&self) -> Vec<Extent> {
        let lanes = self.lanes.iter().map(|lane| &lane[..]);
        if self.len() < PARALLEL {
            lanes.map(Extent::of).collect()
        } else {
            let lanes: Vec<&[f64]> = lanes.collect();
            lanes.into_par_iter().map(Extent::of).collect()
        }
    }

    /// Returns true if all coordinates are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.extents().iter().all(|extent| extent.is_finite)
    }

    /// Diagonal of the axis-aligned bounding box; infinite if the extent exceeds the number range.
    pub fn bounding_diagonal(&self) -> f64 {
        diagonal(&self.extents())
    }

    /// The diagonal of the box that has the shortest interval of nine tenths of each coordinate. Of many points a
    /// sample at equal distances in the list is used.
    pub(crate) fn inner_diagonal(&self) -> f64 {
        let step = self.len().div_ceil(MOST_SORTED).max(1);
        let shortest = |lane: &[f64]| {
            let mut sorted: Vec<f64> = lane.iter().copied().step_by(step).collect();
            sorted.sort_unstable_by(f64::total_cmp);
            let left_out = sorted.len() / 10;
            let ends = sorted.iter().zip(&sorted[sorted.len() - 1 - left_out..]);
            let lengths = ends.map(|(low, high)| high - low);
            lengths.fold(f64::INFINITY, f64::min)
        };
        norm(self.lanes.iter().map(|lane| shortest(lane)))
    }

    /// The largest absolute value of a coordinate.
    pub fn magnitude(&self) -> f64 {
        magnitude(&self.extents())
    }

    /// Moves a point; coordinates beyond the dimension are ignored.
    pub fn set(&mut self, index: usize, coordinates: impl IntoIterator<Item = f64>) {
        for (lane, x) in self.lanes.iter_mut().zip(coordinates) {
            lane[index] = x;
        }
    }

    /// Keeps the first `count` points.
    pub fn truncate(&mut self, count: usize) {
        for lane in &mut self.lanes {
            lane.truncate(count);
        }
    }

    /// Makes room for `more` points, and for no others.
    pub fn make_room(&mut self, more: usize) {
        self.lanes.iter_mut().for_each(|lane| lane.make_room(more));
    }

    /// Releases memory that growing has left over.
    pub fn shrink_to_fit(&mut self) {
        self.lanes.iter_mut().for_each(Lane::shrink_to_fit);
    }
}

/// Coordinates lane by lane become coordinates point by point.
fn interleave<const D: usize>(lanes: [&[f64]; D], numbers: &mut [f64]) {
    let (points, _) = numbers.as_chunks_mut::<D>();
    // Slices of one length, so that the compiler can omit bounds checks.
    let lanes = lanes.map(|lane| &lane[..points.len()]);
    for (i, point) in points.iter_mut().enumerate() {
        *point = std::array::from_fn(|c| lanes[c][i]);
    }
}

impl Clone for Points {
    /// Copies long lanes by several threads.
    fn clone(&self) -> Self {
        let lane = |c: usize| self.lanes[c].clone();
        Self {
            lanes: aligned::lanes(self.dimension(), self.len(), lane),
        }
    }
}

#[cfg(feature = "serde")]
impl<'de> Deserialize<'de> for Points {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let points = Self {
            lanes: Vec::deserialize(deserializer)?,
        };
        let count = points.len();
        if count == 0 || points.lanes.iter().any(|lane| lane.len() != count) {
            return Err(D::Error::custom("coordinates are missing"));
        }
        Ok(points)
    }
}

/// Sums of squares within this range have neither overflown nor lost digits to underflow.
const SAFE: Range<f64> = 1e-240..1e240;

/// The squares of distances, compiled for several instruction sets.
struct Squares<'a> {
    lanes: &'a [Lane],
    from: usize,
    to: usize,
    squares: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let squares = self.squares;
        squares.fill(0.0);
        for lane in self.lanes {
            let (from, to) = (&lane[self.from..], &lane[self.to..]);
            for ((square, a), b) in squares.iter_mut().zip(from).zip(to) {
                let difference = b - a;
                *square += difference * difference;
            }
        }
    }
}

/// The diagonal of the box with these extents, in data units; infinite if it exceeds the range of
/// numbers.
pub(crate) fn diagonal(extents: &[Extent]) -> f64 {
    norm(extents.iter().map(|extent| extent.length()))
}

/// The most coordinates that are sorted for an inner box.
const MOST_SORTED: usize = 2000;

/// Rounding errors of coordinates, relative to the largest absolute coordinate.
pub(crate) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The largest absolute value within these extents.
pub(crate) fn magnitude(extents: &[Extent]) -> f64 {
    let filled = extents.iter().filter(|extent| extent.low <= extent.high);
    let ends = filled.flat_map(|extent| [extent.low, extent.high]);
    ends.fold(0.0, |largest, end| end.abs().max(largest))
}

/// Euclidean norm by nested `hypot`: accurate for every magnitude of the coordinates.
fn norm(coordinates: impl Iterator<Item = f64>) -> f64 {
    coordinates.fold(0.0, f64::hypot)
}

/// A power of two near `1 / length`: squares of lengths like this neither over- nor underflow, as those
/// above 10¹⁵⁴ or below 10⁻¹⁵⁴ would, and multiplying with it is exact. It is 1 if the length is zero or NaN.
pub(crate) fn normalizing_scale(length: f64) -> f64 {
    if length > 0.0 {
        (-length.log2().floor()).clamp(-1022.0, 1022.0).exp2()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where squares of coordinates would over- or underflow, too.
    #[test]
    fn distances_are_right_at_every_magnitude() {
        for exponent in [-300, -160, 0, 160, 300] {
            let s = 10f64.powi(exponent);
            let mut points = Points::new(3);
            points.push(&[0.0, 0.0, 0.0]);
            points.push(&[2.0 * s, 3.0 * s, 6.0 * s]);
            assert!((points.distance(0, 1) / (7.0 * s) - 1.0).abs() < 1e-15);
            assert!((points.bounding_diagonal() / (7.0 * s) - 1.0).abs() < 1e-15);
        }
    }
}
