//! Ordered points, stored coordinate by coordinate.

use super::invalid::Axis;
use super::lane::Lane;

/// Points of R^d as `d` arrays of coordinates ("lanes") of equal length.
///
/// Kernels run over one coordinate at a time, so each coordinate is contiguous. The points of a
/// surface are stored row by row: point (i, j) of a grid with `c` columns has index `i·c + j`.
#[derive(Clone, Debug, PartialEq)]
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
            lanes: (0..dimension).map(|_| Lane::zeros(count)).collect(),
        }
    }

    /// Points of given lanes of equal length.
    pub fn from_lanes(lanes: impl IntoIterator<Item: Into<Lane>>) -> Self {
        Self {
            lanes: lanes.into_iter().map(Into::into).collect(),
        }
    }

    /// Appends one point; coordinates beyond the dimension are not looked at.
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

    /// Whether there is no point.
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

    /// Euclidean distance between points `i` and `j`, without intermediate over- or underflow.
    pub fn distance(&self, i: usize, j: usize) -> f64 {
        norm(self.lanes.iter().map(|lane| lane[j] - lane[i]))
    }

    /// Diagonal of the axis-aligned bounding box; infinite if the extent exceeds the number range.
    pub fn bounding_diagonal(&self) -> f64 {
        norm(self.lanes.iter().map(|lane| {
            let low = lane.iter().copied().fold(f64::INFINITY, f64::min);
            let high = lane.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if lane.is_empty() { 0.0 } else { high - low }
        }))
    }

    /// The largest absolute value of a coordinate.
    pub fn magnitude(&self) -> f64 {
        let coordinates = self.lanes.iter().flatten();
        coordinates.fold(0.0, |largest, x| x.abs().max(largest))
    }

    /// Puts a point elsewhere; coordinates beyond the dimension are not looked at.
    pub fn set(&mut self, index: usize, coordinates: impl IntoIterator<Item = f64>) {
        for (lane, x) in self.lanes.iter_mut().zip(coordinates) {
            lane[index] = x;
        }
    }

    /// Gives back memory that growing has left over.
    pub fn shrink_to_fit(&mut self) {
        self.lanes.iter_mut().for_each(Lane::shrink_to_fit);
    }
}

/// Euclidean norm by nested `hypot`: right for every magnitude of the coordinates.
fn norm(coordinates: impl Iterator<Item = f64>) -> f64 {
    coordinates.fold(0.0, f64::hypot)
}

/// The arrangement of points: a curve has one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Number of points in the u direction.
    pub rows: usize,
    /// Number of points in the v direction.
    pub columns: usize,
}

impl Grid {
    /// Number of points.
    pub fn count(self) -> usize {
        self.rows * self.columns
    }

    /// Number of points along a direction.
    pub fn along(self, axis: Axis) -> usize {
        match axis {
            Axis::U => self.rows,
            Axis::V => self.columns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
