//! Distances of the data from a curve or surface.
//!
//! ```text
//! d_i = min over t of ‖C(t) − P_i‖
//! ```
//!
//! Errors of levels are distances at the parameters of the data, ‖C(t_i) − P_i‖, which the methods minimize. The
//! distances here are those to the nearest points, as a gauge would measure them; they are never larger.

use super::{NoFootPoints, nearest};
use crate::data::points::Points;
use crate::data::quantiles::Position;
use crate::geometry::between::excesses;
use crate::geometry::nurbs::Nurbs;
use crate::setup::Setup;

/// The percentiles that are computed.
pub(crate) const PERCENTILES: [usize; 4] = [50, 90, 95, 99];

/// Distances of data points from the nearest points of a curve or surface.
#[derive(Clone, Debug)]
pub struct Deviation {
    /// The largest distance.
    pub max: f64,
    /// The root mean square of the distances.
    pub rms: f64,
    /// The data point with the largest distance, the first of several.
    pub at: usize,
    /// The distances below which `PERCENTILES` per cent of the data are, between neighbours in
    /// the order of distances interpolated.
    pub percentiles: [f64; PERCENTILES.len()],
    /// The distance of each point, row by row; NaN where a point is missing.
    pub distances: Vec<f64>,
    /// By how much the fit leaves the data in each gap between neighbours beyond their freedom, of grids in each cell,
    /// row by row; empty for scattered data.
    pub between: Vec<f64>,
}

impl Deviation {
    /// The deviation of the data of a setup from a level.
    ///
    /// # Errors
    ///
    /// The fit has no nearest points: its degree is too high, a weight is not positive, or the data
    /// are values of a function.
    pub fn of(setup: &Setup, control_points: &Points) -> Result<Self, NoFootPoints> {
        let points = &setup.points;
        if points.dimension() == 1 {
            return Err(NoFootPoints::OneCoordinate);
        }
        let fit = Nurbs::of(setup, control_points);
        let mut distances =
            nearest(&fit, points, |index| Some(setup.parameters_of(index)))?.distances;
        if let Some(missing) = setup.missing() {
            let indices = (0..distances.len()).filter(|&index| missing.contains(index));
            indices.for_each(|index| distances[index] = f64::NAN);
        }
        let mut sorted: Vec<f64> = distances.iter().copied().filter(|d| !d.is_nan()).collect();
        sorted.sort_by(f64::total_cmp);
        let max = sorted.last().copied().unwrap_or(0.0);
        // Relative to the largest: squares neither overflow nor vanish.
        let part = |d: &f64| if max > 0.0 { (d / max).powi(2) } else { 0.0 };
        let mean = sorted.iter().map(part).sum::<f64>() / sorted.len().max(1) as f64;
        let last = sorted.len().saturating_sub(1);
        let percentile = |&k: &usize| {
            Position::new(k, 100, last).between(|index| sorted.get(index).copied().unwrap_or(0.0))
        };
        Ok(Self {
            max,
            rms: max * mean.sqrt(),
            at: distances.iter().position(|&d| d == max).unwrap_or(0),
            percentiles: PERCENTILES.each_ref().map(percentile),
            distances,
            between: excesses(setup, control_points),
        })
    }
}
