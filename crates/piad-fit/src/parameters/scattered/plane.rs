//! The plane nearest to points, and their coordinates in it.
//!
//! u and v run along the sides of the least rectangle around the points, so that scans of rectangles fill it, or of one along
//! the coordinate axes if it is hardly larger; u along the longer one. The sense of each axis is that in which its largest component (the first of several) is positive.

use nalgebra::DMatrix;

use super::rectangle;
use crate::data::outliers::median;
use crate::data::points::{Points, normalizing_scale};
use crate::invalid::{Axis, Invalid, Place};
use crate::linear::triangular::Triangular;

/// Points that spread less than this part across a line lie on it.
const LINE: f64 = 1e-12;

/// Coordinate axes whose projection has this length lie nearly in a plane.
const IN_PLANE: f64 = 0.7;

/// The number of rounds to find a plane without the influence of outliers.
const PLANES: usize = 4;

/// The plane that lies nearest to points.
pub(super) struct Plane<'a> {
    points: &'a Points,
    /// Scaled by this, neither sums nor squares leave the range of numbers.
    scale: f64,
    mean: Vec<f64>,
    axes: [Vec<f64>; 2],
}

impl<'a> Plane<'a> {
    /// That of some of the points.
    ///
    /// # Errors
    ///
    /// They have one coordinate, or are on a line.
    pub(super) fn of(points: &'a Points, some: &[usize]) -> Result<Self, Invalid> {
        let dimension = points.dimension();
        if dimension < 2 {
            return Err(no_plane());
        }
        let scale = normalizing_scale(points.magnitude());
        let count = some.len() as f64;
        let lanes = points.lanes().iter();
        let mean = lanes.map(|lane| some.iter().map(|&i| lane[i] * scale / count).sum());
        let mut plane = Self {
            points,
            scale,
            mean: mean.collect(),
            axes: [Vec::new(), Vec::new()],
        };
        let mut factor = Triangular::new((0..dimension as u32).collect(), dimension);
        for &i in some {
            factor.insert_row(plane.centred(i).enumerate());
        }
        let mut matrix = DMatrix::zeros(dimension, dimension);
        for (row, entries) in factor.rows().enumerate() {
            let entries = entries.filter(|(column, _)| *column < dimension);
            entries.for_each(|(column, value)| matrix[(row, column)] = value);
        }
        plane.axes = principal_axes(matrix).ok_or_else(on_line)?;
        plane.turn(some);
        Ok(plane)
    }

    /// Turns the axes along the sides of the least rectangle around some of the points.
    fn turn(&mut self, some: &[usize]) {
        let place = |&i: &usize| [0, 1].map(|axis| self.along(axis, i));
        let places: Vec<[f64; 2]> = some.iter().map(place).collect();
        let [first, second] = &self.axes;
        let along = |[x, y]: [f64; 2]| {
            let pairs = first.iter().zip(second);
            towards_largest(pairs.map(|(a, b)| x * a + y * b).collect())
        };
        // Along the coordinate axes a surface stays in their box where its corners have no data.
        let coordinates = first.iter().zip(second).map(|(&x, &y)| [x, y]);
        let coordinates: Vec<_> = coordinates
            .filter(|[x, y]| x.hypot(*y) > IN_PLANE)
            .collect();
        if let Some(side) = rectangle::longer_side(&places, &coordinates) {
            self.axes = [along(side), along([-side[1], side[0]])];
        }
    }

    /// A point relative to the mean, scaled.
    fn centred(&self, i: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        let lanes = self.points.lanes().iter().zip(&self.mean);
        lanes.map(move |(lane, mean)| lane[i] * self.scale - mean)
    }

    /// A point along an axis, scaled.
    fn along(&self, axis: usize, i: usize) -> f64 {
        self.centred(i)
            .zip(&self.axes[axis])
            .map(|(x, a)| x * a)
            .sum()
    }

    /// All points along both axes.
    pub(super) fn parameters(&self) -> [Vec<f64>; 2] {
        let all = 0..self.points.len();
        [0, 1].map(|axis| {
            all.clone()
                .map(|i| self.along(axis, i) / self.scale)
                .collect()
        })
    }

    /// How far a point is from it, scaled.
    fn distance(&self, i: usize) -> f64 {
        let [u, v] = [0, 1].map(|axis| self.along(axis, i));
        let pairs = self.centred(i).zip(self.axes[0].iter().zip(&self.axes[1]));
        pairs.fold(0.0, |sum: f64, (x, (a, b))| sum.hypot(x - u * a - v * b))
    }
}

/// The points nearest to a plane that outliers do not influence: first the half nearest to the middle of the points,
/// then the three quarters nearest to the plane before.
pub(crate) fn nearest_to_their_plane(points: &Points) -> Result<Vec<usize>, Invalid> {
    let middle = points.lanes().iter().map(|lane| median(lane.to_vec()));
    let middle: Vec<f64> = middle.collect();
    let away = |i: usize| {
        let pairs = points.point(i).zip(&middle);
        pairs.fold(0.0, |away: f64, (x, m)| away.hypot(x - m))
    };
    let mut some = nearest(points.len() / 2, (0..points.len()).map(away).collect());
    for _ in 0..PLANES {
        let plane = Plane::of(points, &some)?;
        let distances = (0..points.len()).map(|i| plane.distance(i));
        some = nearest(points.len() * 3 / 4, distances.collect());
    }
    Ok(some)
}

/// The indices of the least of some distances.
fn nearest(count: usize, distances: Vec<f64>) -> Vec<usize> {
    let mut all: Vec<usize> = (0..distances.len()).collect();
    all.sort_by(|&i, &j| distances[i].total_cmp(&distances[j]));
    all.truncate(count);
    all
}

/// The directions in which the rows of a matrix are longest; `None` if they are all on a line.
fn principal_axes(matrix: DMatrix<f64>) -> Option<[Vec<f64>; 2]> {
    let found = matrix.svd(false, true);
    let rows = found.v_t?;
    let lengths = &found.singular_values;
    let mut order: Vec<usize> = (0..lengths.len()).collect();
    order.sort_by(|&a, &b| lengths[b].total_cmp(&lengths[a]));
    let (first, second) = (order[0], order[1]);
    if lengths[second].is_nan() || lengths[second] <= LINE * lengths[first] {
        return None;
    }
    Some([first, second].map(|row| towards_largest(rows.row(row).iter().copied().collect())))
}

/// An axis in the sense in which its largest component, the first of several, is positive.
pub(super) fn towards_largest(axis: Vec<f64>) -> Vec<f64> {
    let largest = axis.iter().fold(0.0, |m: f64, x| x.abs().max(m));
    // Components that differ by rounding only are equally large.
    let near = |x: &&f64| x.abs() >= (1.0 - 1e-9) * largest;
    let sense = axis.iter().find(near).map_or(1.0, |x| x.signum());
    axis.into_iter().map(|x| sense * x).collect()
}

/// Points of one coordinate have no plane.
pub(super) fn no_plane() -> Invalid {
    let detail =
        "points of one coordinate have no plane for their parameters: give u and v of each point";
    Invalid::at(Place::Parameters(Axis::U), detail)
}

/// Points of the plane have x and y only.
pub(super) fn no_third_coordinate() -> Invalid {
    let detail = "points of two coordinates have no z: project them to \"xy\", or give u and v of each point";
    Invalid::at(Place::Parameters(Axis::U), detail)
}

/// All points lie on a line.
fn on_line() -> Invalid {
    let detail = "all points lie on a line (or are equal), so that there is no plane nearest to them: give u and v of each point";
    Invalid::at(Place::Parameters(Axis::U), detail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{CoordinatePlane, Scattered};

    /// Parameters of points of an open surface.
    fn parameters(rule: &Scattered, points: &Points) -> Result<[Vec<f64>; 2], Invalid> {
        let pairs = rule.parameters(points, [false; 2])?;
        Ok([0, 1].map(|axis| pairs.direction(axis).0))
    }

    /// Points of a plane, which are nowhere near its axes.
    fn tilted(count: usize) -> Points {
        let mut points = Points::new(3);
        for i in 0..count {
            let (s, t) = (5.0 * (i as f64 * 1.7).sin(), (i as f64 * 0.9).cos());
            points.push(&[10.0 + 0.6 * s, -4.0 - 0.8 * s, 7.0 + t]);
        }
        points
    }

    /// Distances in the plane are those of the points, the longest spread comes first, and the sense of
    /// the axes is that of their largest component, whatever the magnitude and the order of the points.
    #[test]
    fn the_plane_is_that_of_the_points() {
        let count = 40;
        let points = tilted(count);
        let [u, v] = parameters(&Scattered::Plane, &points).unwrap();
        for i in 1..count {
            let distance = (u[i] - u[0]).hypot(v[i] - v[0]);
            assert!((distance - points.distance(0, i)).abs() < 1e-13);
        }
        let spread = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
        assert!(spread(&u) > 10.0 * spread(&v));
        // The largest component of the first axis is that of y, and of the second that of z.
        let (y, z) = (points.lane(1), points.lane(2));
        assert!((u[3] - u[8]) * (y[3] - y[8]) > 0.0);
        assert!((v[3] - v[8]) * (z[3] - z[8]) > 0.0);
        for scale in [1e-200, 1e200] {
            let lanes = points.lanes().iter();
            let scaled = lanes.map(|lane| lane.iter().rev().map(|x| x * scale).collect::<Vec<_>>());
            let scaled = Points::from_lanes(scaled);
            let [us, vs] = parameters(&Scattered::Plane, &scaled).unwrap();
            for i in 0..count {
                let k = count - 1 - i;
                assert!(
                    (us[k] / scale - u[i]).abs() < 1e-13 && (vs[k] / scale - v[i]).abs() < 1e-13
                );
            }
        }
    }

    #[test]
    fn points_on_a_line_have_no_plane() {
        let mut line = Points::new(3);
        (0..9).for_each(|i| line.push(&[0.1 * f64::from(i), 0.3 * f64::from(i), 7.0]));
        assert_eq!(parameters(&Scattered::Plane, &line), Err(on_line()));
        let mut equal = Points::new(3);
        (0..9).for_each(|_| equal.push(&[0.1, 0.2, 0.3]));
        assert_eq!(parameters(&Scattered::Plane, &equal), Err(on_line()));
        let values = Points::zeros(1, 9);
        assert_eq!(parameters(&Scattered::Plane, &values), Err(no_plane()));
        let plane = |plane| Scattered::Coordinates(plane);
        let found = parameters(&plane(CoordinatePlane::Xy), &values);
        assert_eq!(found, Err(no_plane()));
        let flat = Points::from_lanes(vec![vec![1.0, 2.0], vec![3.0, 5.0]]);
        let found = parameters(&plane(CoordinatePlane::Yz), &flat);
        assert_eq!(found, Err(no_third_coordinate()));
    }

    #[test]
    fn planes_of_coordinates_have_those_of_the_points() {
        let points = tilted(9);
        for (plane, axes) in [
            (CoordinatePlane::Xy, [0, 1]),
            (CoordinatePlane::Xz, [0, 2]),
            (CoordinatePlane::Yz, [1, 2]),
        ] {
            let found = parameters(&Scattered::Coordinates(plane), &points).unwrap();
            assert_eq!(found, axes.map(|axis| points.lane(axis).to_vec()));
        }
    }
}
