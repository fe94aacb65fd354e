//! The cylinder nearest to points: u goes around it, a length on it, and v along its axis.
//!
//! Its axis is searched for among the direction that the normals of the points have least of and the principal axes of
//! the points, each with the circle of Kåsa (1976) across it; from the best of them Gauss–Newton steps lead to the
//! least sum of squared distances.

use std::sync::Arc;

use nalgebra::{SMatrix, SVector, Vector3};

use super::circle::counted;
use super::normals::{Cloud, across, direction, no_surface, towards_largest};
use super::pairs::{Domain, Pairs};
use crate::data::points::Points;
use crate::invalid::Invalid;

/// Gauss–Newton steps.
const STEPS: usize = 50;

/// A sum of squares that a step lowers by less than this part of it is least.
const GAIN: f64 = 1e-12;

/// A cylinder whose radius is smaller than this part of the size of the points is a line, and one with a larger one a plane.
const SMALLEST_RADIUS: f64 = 1e-9;
const LARGEST_RADIUS: f64 = 1e4;

/// The largest root of the mean squared distance from a cylinder that is found, as a part of its radius: points of a disc
/// have .35, those of an ellipse whose axes are one and two .23.
const FARTHEST: f64 = 0.3;

/// The cylinder near points, as far as it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cylinder {
    /// The direction of its axis; `None` means that nearest to the points.
    pub axis: Option<[f64; 3]>,
    /// A place on its axis; `None` means that nearest to the points.
    pub center: Option<[f64; 3]>,
}

/// A cylinder among points that are moved and scaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub axis: Vector3<f64>,
    pub center: Vector3<f64>,
    pub radius: f64,
    /// The sum of squared distances.
    square: f64,
}

impl Cylinder {
    /// Around it and along it; closed where the points go all around, or where requested.
    pub(super) fn parameters(&self, points: &Points, is_closed: bool) -> Result<Pairs, Invalid> {
        let cloud = Cloud::new(points, "cylinder")?;
        let fit = self.fit(&cloud)?;
        let (angles, along) = fit.places(&cloud);
        let (angles, goes_around) = counted(angles, is_closed);
        let radius = cloud.length(fit.radius);
        let around = angles
            .into_iter()
            .map(|angle| angle * radius)
            .collect::<Vec<f64>>();
        let along = along
            .into_iter()
            .map(|x| cloud.length(x))
            .collect::<Vec<f64>>();
        let domain = match goes_around {
            true => Domain::Closed(std::f64::consts::TAU * radius),
            false => Domain::Data,
        };
        Ok(Pairs {
            values: Arc::new(Points::from_lanes([around, along])),
            domains: [domain, Domain::Data],
        })
    }

    /// The same with its defaults filled in.
    pub(super) fn known(&self, points: &Points) -> Result<Self, Invalid> {
        let cloud = Cloud::new(points, "cylinder")?;
        let fit = self.fit(&cloud)?;
        Ok(Self {
            axis: Some(fit.axis.into()),
            center: Some(cloud.place(fit.center)),
        })
    }

    /// The nearest one.
    ///
    /// # Errors
    ///
    /// The axis is no direction, or the points are on a plane or a line.
    pub(super) fn fit(&self, cloud: &Cloud) -> Result<Fit, Invalid> {
        let center = self.center.map(|center| cloud.place_here(center));
        let fits: Vec<Fit> = match self.axis {
            Some(axis) => {
                let axis = direction(axis, "cylinder")?;
                Fit::around(cloud, axis, center).into_iter().collect()
            }
            None => {
                let [of_normals, ..] = cloud.axes_of_normals();
                let axes = cloud.principal_axes().into_iter().chain([of_normals]);
                let fits =
                    axes.filter_map(|axis| Fit::around(cloud, towards_largest(axis), center));
                fits.map(|fit| fit.refined(cloud, center.is_none()))
                    .collect()
            }
        };
        let nearest = fits
            .into_iter()
            .min_by(|a, b| a.square.total_cmp(&b.square));
        let count = cloud.deciding().count() as f64;
        let is_near = |fit: &Fit| {
            let distance = (fit.square / count).sqrt();
            (SMALLEST_RADIUS..LARGEST_RADIUS).contains(&fit.radius)
                && (self.axis.is_some() || distance <= FARTHEST * fit.radius)
        };
        nearest.filter(is_near).ok_or_else(|| {
            no_surface("there is no cylinder near the points: they may be on a plane or on a line")
        })
    }
}

impl Fit {
    /// The cylinder around an axis.
    fn around(cloud: &Cloud, axis: Vector3<f64>, center: Option<Vector3<f64>>) -> Option<Self> {
        let [first, second] = across(axis);
        let place = |point: &Vector3<f64>| [point.dot(&first), point.dot(&second)];
        let center = match center {
            Some(center) => center - axis * center.dot(&axis),
            None => {
                // |x|² = 2 c · x + k.
                let mut matrix = SMatrix::<f64, 3, 3>::zeros();
                let mut right = SVector::<f64, 3>::zeros();
                for [x, y] in cloud.deciding().map(place) {
                    let row = SVector::<f64, 3>::new(2.0 * x, 2.0 * y, 1.0);
                    matrix += row * row.transpose();
                    right += row * (x * x + y * y);
                }
                let solution = matrix.cholesky()?.solve(&right);
                first * solution[0] + second * solution[1]
            }
        };
        let away = |point: &Vector3<f64>| {
            let from = point - center;
            (from - axis * from.dot(&axis)).norm()
        };
        let count = cloud.deciding().count() as f64;
        let radius = cloud.deciding().map(away).sum::<f64>() / count;
        let fit = Self {
            axis,
            center,
            radius,
            square: 0.0,
        };
        let fit = fit.measured(cloud);
        fit.square.is_finite().then_some(fit)
    }

    fn measured(self, cloud: &Cloud) -> Self {
        let squares = cloud.deciding().map(|point| {
            let from = point - self.center;
            let away = (from - self.axis * from.dot(&self.axis)).norm() - self.radius;
            away * away
        });
        Self {
            square: squares.sum(),
            ..self
        }
    }

    /// After steps to the least sum of squared distances; the centre moves if it may.
    fn refined(mut self, cloud: &Cloud, center_moves: bool) -> Self {
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let next = self.step(cloud, damping, center_moves);
            let next = next.map(|next| next.measured(cloud));
            match next.filter(|next| next.square < self.square) {
                Some(next) => {
                    let is_least = next.square > (1.0 - GAIN) * self.square;
                    self = next;
                    damping = f64::max(damping * 0.1, 1e-12);
                    if is_least {
                        break;
                    }
                }
                None if damping > 1e6 => break,
                None => damping *= 10.0,
            }
        }
        self
    }

    /// A damped step of the axis, the centre and the radius (Levenberg, Marquardt).
    fn step(&self, cloud: &Cloud, damping: f64, center_moves: bool) -> Option<Self> {
        let [first, second] = across(self.axis);
        let mut matrix = SMatrix::<f64, 5, 5>::zeros();
        let mut right = SVector::<f64, 5>::zeros();
        for point in cloud.deciding() {
            let from = point - self.center;
            let along = from.dot(&self.axis);
            let out = from - self.axis * along;
            let length = out.norm();
            if length <= 0.0 {
                continue;
            }
            let [x, y] = [out.dot(&first) / length, out.dot(&second) / length];
            let center = if center_moves { [-x, -y] } else { [0.0; 2] };
            // What the distance changes by as the axis tilts, the centre moves and the radius grows.
            let row = SVector::<f64, 5>::from([-x * along, -y * along, center[0], center[1], -1.0]);
            matrix += row * row.transpose();
            right -= row * (length - self.radius);
        }
        for k in 0..5 {
            matrix[(k, k)] += damping * matrix[(k, k)] + f64::MIN_POSITIVE;
        }
        let step = matrix.cholesky()?.solve(&right);
        let axis = (self.axis + first * step[0] + second * step[1]).normalize();
        Some(Self {
            axis,
            center: self.center + first * step[2] + second * step[3],
            radius: self.radius + step[4],
            square: 0.0,
        })
    }

    /// The angle of each point around the axis, and its position along it.
    pub(super) fn places(&self, cloud: &Cloud) -> (Vec<f64>, Vec<f64>) {
        let [first, second] = across(self.axis);
        let place = |point: &Vector3<f64>| {
            let from = point - self.center;
            let angle = from.dot(&second).atan2(from.dot(&first));
            (angle, point.dot(&self.axis))
        };
        cloud.points.iter().map(place).unzip()
    }
}
