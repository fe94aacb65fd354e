//! The sphere nearest to points: u is the longitude and v the latitude, lengths on it.
//!
//! The axis stands across the direction of the points where they are a part of the sphere, so that they are around its
//! equator; where they are most of it, it is that direction; and the third coordinate where they are all around.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use nalgebra::{SMatrix, SVector, Vector3};

use super::circle::counted;
use super::normals::{Cloud, across, direction, no_surface, towards_largest};
use super::pairs::{Domain, Pairs};
use crate::data::points::Points;
use crate::invalid::Invalid;

/// Gauss–Newton steps.
const STEPS: usize = 30;

/// A sphere whose radius is smaller than this part of the size of the points is a point, and one with a larger one a plane.
const SMALLEST_RADIUS: f64 = 1e-9;
const LARGEST_RADIUS: f64 = 1e4;

/// Points whose mean direction from the centre is shorter than this are on all sides of it.
const ALL_AROUND: f64 = 0.2;

/// Points within this angle of their mean direction have it on the equator.
const PART: f64 = 75.0 * PI / 180.0;

/// The surface reaches a pole if it is nearer to a point than this.
const AT_POLE: f64 = 15.0 * PI / 180.0;

/// The sphere near points, with its known parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// Its centre; `None` means that nearest to the points.
    pub center: Option<[f64; 3]>,
    /// The direction from its centre to a pole; `None` means one that suits the points.
    pub axis: Option<[f64; 3]>,
}

/// A sphere among points that are moved and scaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub center: Vector3<f64>,
    pub radius: f64,
}

impl Sphere {
    /// Longitude and latitude; closed where the points go all around, or where requested.
    pub(super) fn parameters(&self, points: &Points, is_closed: bool) -> Result<Pairs, Invalid> {
        let cloud = Cloud::new(points, "sphere")?;
        let fit = self.fit(&cloud)?;
        let axis = match self.axis {
            Some(axis) => direction(axis, "sphere")?,
            None => fit.axis(&cloud),
        };
        let [first, second] = across(axis);
        let place = |point: &Vector3<f64>| {
            let from = point - fit.center;
            let [x, y, z] = [&first, &second, &axis].map(|it| from.dot(it));
            (y.atan2(x), z.atan2(x.hypot(y)))
        };
        let (longitudes, latitudes): (Vec<f64>, Vec<f64>) = cloud.points.iter().map(place).unzip();
        let (longitudes, goes_around) = counted(longitudes, is_closed);
        let radius = cloud.length(fit.radius);
        let low = latitudes.iter().copied().fold(f64::INFINITY, f64::min);
        let high = latitudes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let poles = [low + FRAC_PI_2, FRAC_PI_2 - high].map(|gap| goes_around && gap <= AT_POLE);
        let of_pole = [-FRAC_PI_2, FRAC_PI_2];
        let ends = [0, 1].map(|k| radius * if poles[k] { of_pole[k] } else { [low, high][k] });
        let lane = |angles: Vec<f64>| angles.into_iter().map(|x| x * radius).collect::<Vec<f64>>();
        let around = match goes_around {
            true => Domain::Closed(TAU * radius),
            false => Domain::Data,
        };
        let along = match poles {
            [false, false] => Domain::Data,
            _ => Domain::Between { ends, poles },
        };
        Ok(Pairs {
            values: Arc::new(Points::from_lanes([lane(longitudes), lane(latitudes)])),
            domains: [around, along],
        })
    }

    /// The same with its defaults filled in.
    pub(super) fn known(&self, points: &Points) -> Result<Self, Invalid> {
        let cloud = Cloud::new(points, "sphere")?;
        let fit = self.fit(&cloud)?;
        Ok(Self {
            center: Some(cloud.place(fit.center)),
            axis: self.axis.or(Some(fit.axis(&cloud).into())),
        })
    }

    /// The nearest one: of Kåsa's sum of squares, then by Gauss–Newton steps of the distances.
    pub(super) fn fit(&self, cloud: &Cloud) -> Result<Fit, Invalid> {
        let mean_radius = |center: Vector3<f64>| {
            let count = cloud.deciding().count() as f64;
            cloud
                .deciding()
                .map(|point| (point - center).norm())
                .sum::<f64>()
                / count
        };
        let center = match self.center {
            Some(center) => Some(cloud.place_here(center)),
            None => algebraic(cloud).map(|center| moved(cloud, center)),
        };
        let fit = center.map(|center| Fit {
            center,
            radius: mean_radius(center),
        });
        let fit = fit.filter(|fit| (SMALLEST_RADIUS..LARGEST_RADIUS).contains(&fit.radius));
        fit.ok_or_else(|| {
            no_surface("there is no sphere near the points: they may be on a plane or on a line")
        })
    }
}

impl Fit {
    /// An axis that suits the points.
    fn axis(&self, cloud: &Cloud) -> Vector3<f64> {
        let direction = |point: &Vector3<f64>| (point - self.center).try_normalize(0.0);
        let directions: Vec<Vector3<f64>> = cloud.deciding().filter_map(direction).collect();
        let mean = directions.iter().sum::<Vector3<f64>>() / directions.len().max(1) as f64;
        if mean.norm() < ALL_AROUND {
            return Vector3::z();
        }
        let mean = mean.normalize();
        let cosines = directions.iter().map(|it| it.dot(&mean));
        let farthest = cosines.fold(1.0, f64::min).acos();
        match farthest <= PART {
            true => towards_largest(across(mean)[1]),
            false => mean,
        }
    }
}

/// The centre for which `|x|² − 2 c · x` is most alike.
fn algebraic(cloud: &Cloud) -> Option<Vector3<f64>> {
    let mut matrix = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    for x in cloud.deciding() {
        let row = SVector::<f64, 4>::new(2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 1.0);
        matrix += row * row.transpose();
        right += row * x.norm_squared();
    }
    let solution = matrix.cholesky()?.solve(&right);
    Some(solution.fixed_rows::<3>(0).into_owned())
}

/// The centre with the least sum of squared distances from its sphere.
fn moved(cloud: &Cloud, mut center: Vector3<f64>) -> Vector3<f64> {
    for _ in 0..STEPS {
        let mut matrix = SMatrix::<f64, 4, 4>::zeros();
        let mut right = SVector::<f64, 4>::zeros();
        for point in cloud.deciding() {
            let from = point - center;
            let length = from.norm();
            if length > 0.0 {
                let out = from / length;
                let row = SVector::<f64, 4>::new(out[0], out[1], out[2], 1.0);
                matrix += row * row.transpose();
                right += row * length;
            }
        }
        let Some(factor) = matrix.cholesky() else {
            break;
        };
        let step = factor.solve(&right).fixed_rows::<3>(0).into_owned();
        if !step.amax().is_finite() {
            break;
        }
        center += step;
        if step.amax() < 1e-14 {
            break;
        }
    }
    center
}
