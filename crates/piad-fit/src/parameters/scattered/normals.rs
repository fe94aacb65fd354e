//! Points of space on their way to a cylinder or a sphere: moved to their mean and scaled to the order of one, a part of
//! many; and the normals of the surface on which they lie.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rstar::RTree;

use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};

/// The points that determine an axis or a centre, and those that have normals.
const DECIDING: usize = 20_000;
const WITH_NORMALS: usize = 2_000;

/// The number of neighbours for a normal, with the point itself.
const NEIGHBOURS: usize = 12;

/// Points of space, moved and scaled.
pub(super) struct Cloud {
    pub points: Vec<Vector3<f64>>,
    mean: Vector3<f64>,
    scale: f64,
}

impl Cloud {
    /// Of points with three coordinates.
    ///
    /// # Errors
    ///
    /// They have fewer coordinates, or more; or they are all equal.
    pub(super) fn new(points: &Points, what: &str) -> Result<Self, Invalid> {
        let dimension = points.dimension();
        let [x, y, z] = points.lanes() else {
            return Err(no_surface(format!(
                "points of {dimension} coordinates have no {what}: points of space have one"
            )));
        };
        let count = points.len() as f64;
        let mean = [x, y, z].map(|lane| lane.iter().map(|x| x / count).sum::<f64>());
        let mean = Vector3::from(mean);
        let at = |i: usize| Vector3::new(x[i], y[i], z[i]) - mean;
        let largest = (0..points.len()).map(|i| at(i).amax()).fold(0.0, f64::max);
        if largest <= 0.0 || !largest.is_finite() || !largest.recip().is_finite() {
            return Err(no_surface(format!(
                "points that are all equal have no {what}"
            )));
        }
        let scale = largest.recip();
        Ok(Self {
            points: (0..points.len()).map(|i| at(i) * scale).collect(),
            mean,
            scale,
        })
    }

    /// The length in the unit of the points of one of the cloud.
    pub(super) fn length(&self, length: f64) -> f64 {
        length / self.scale
    }

    /// The length in the cloud of one in the unit of the points.
    pub(super) fn scaled(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// A place of the cloud where the points are.
    pub(super) fn place(&self, place: Vector3<f64>) -> [f64; 3] {
        (self.mean + place / self.scale).into()
    }

    /// The place in the cloud of one where the points are.
    pub(super) fn place_here(&self, place: [f64; 3]) -> Vector3<f64> {
        (Vector3::from(place) - self.mean) * self.scale
    }

    /// Those that decide, at equal distances in the list.
    pub(super) fn deciding(&self) -> impl Iterator<Item = &Vector3<f64>> + Clone {
        some(&self.points, DECIDING)
    }

    /// The directions in which the points spread, the least first.
    pub(super) fn principal_axes(&self) -> [Vector3<f64>; 3] {
        axes(spread(self.deciding()))
    }

    /// The directions in which the normals of the surface spread, the least first: around a cylinder there are none along
    /// its axis.
    pub(super) fn axes_of_normals(&self) -> [Vector3<f64>; 3] {
        let points: Vec<[f64; 3]> = some(&self.points, WITH_NORMALS)
            .map(|it| (*it).into())
            .collect();
        let tree = RTree::bulk_load(points.clone());
        let normal = |point: &[f64; 3]| {
            let near = tree.nearest_neighbor_iter(*point).take(NEIGHBOURS);
            let near: Vec<Vector3<f64>> = near.map(|it| Vector3::from(*it)).collect();
            let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
            let centred: Vec<Vector3<f64>> = near.iter().map(|it| it - mean).collect();
            let [normal, ..] = axes(spread(centred.iter()));
            normal
        };
        let normals: Vec<Vector3<f64>> = points.iter().map(normal).collect();
        axes(spread(normals.iter()))
    }
}

/// At most this number of points, at equal distances in the list.
pub(super) fn some<T>(points: &[T], most: usize) -> impl Iterator<Item = &T> + Clone {
    points.iter().step_by(points.len().div_ceil(most).max(1))
}

/// An error about a surface that the points do not have.
pub(super) fn no_surface(detail: impl Into<String>) -> Invalid {
    Invalid::at(Place::Parameters(Axis::U), detail.into())
}

/// The unit vector of an axis that is given.
pub(super) fn direction(axis: [f64; 3], what: &str) -> Result<Vector3<f64>, Invalid> {
    let axis = Vector3::from(axis);
    let length = axis.norm();
    if length > 0.0 && length.is_finite() {
        return Ok(axis / length);
    }
    Err(no_surface(format!(
        "the axis of a {what} is a direction: three finite numbers that are not all zero"
    )))
}

/// `Σ x xᵀ`.
fn spread<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> Matrix3<f64> {
    points.map(|x| x * x.transpose()).sum()
}

/// The axes of a symmetric matrix, of increasing eigenvalues.
fn axes(matrix: Matrix3<f64>) -> [Vector3<f64>; 3] {
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::new(matrix);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    order.map(|k| eigenvectors.column(k).into_owned())
}

/// Two directions across an axis and each other, so that the three are right-handed; the first is that of the coordinate
/// that the axis has least of.
pub(super) fn across(axis: Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = axis.iamin();
    let mut first = Vector3::zeros();
    first[least] = 1.0;
    let first = (first - axis * axis[least]).normalize();
    [first, axis.cross(&first)]
}

/// An axis in the sense in which its largest component is positive.
pub(super) fn towards_largest(axis: Vector3<f64>) -> Vector3<f64> {
    Vector3::from_vec(super::plane::towards_largest(
        axis.iter().copied().collect(),
    ))
}
