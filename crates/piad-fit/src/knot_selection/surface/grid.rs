//! A grid of data, fitted one direction after the other.
//!
//! Least squares of a grid by a tensor-product surface are those of its lines, one direction after
//! the other: `X = L_u P L_vᵀ`. With the projections Π_u and Π_v onto the splines of each direction
//!
//! ```text
//! P − Π_u Π_v P = (P − Π_u P) + Π_u (P − Π_v P)
//! ```
//!
//! so the residual of each direction is known separately, and each has its own density of knots: that of a curve in as
//! many dimensions as there are lines across. Where both directions are open the corners are interpolated, and each
//! boundary is the fit of the data there, whatever lies inside. A grid with fewer data in a direction than p + 1 is
//! fitted as scattered points.

use std::sync::Arc;

use super::lines::{along, curves, joined};
use super::{Data, Fit, Nearest, Options, Parameters, ScatteredData};
use crate::data::distances::Distances;
use crate::data::grid::Grid;
use crate::data::points::{Points, normalizing_scale};
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::equations::{LeastSquares, Minimum};
use crate::knot_selection::levels::Level;
use crate::knot_selection::values::Values;

/// The part of the tolerance for each of the two directions.
const SHARE: f64 = 0.6;

/// The number of data points times fits with fewer knot lines: about a second.
const WORK: usize = 4_000_000;

/// The fairness of a surface that is kept near its data where there are none, decreased by decades down to its
/// tolerance: multiples of the energy of spans of equal length.
const FAIRNESS: [f64; 4] = [1e-5, 1e-6, 1e-7, 1e-8];

/// A grid of points.
#[derive(Debug)]
pub(crate) struct GridData {
    points: Arc<Points>,
    grid: Grid,
    parameters: Parameters,
    /// The data as curves in u and in v, with a coordinate for each coordinate of each line across.
    curves: [Arc<Points>; 2],
    /// The tolerance of a fit that is as fair as it allows.
    fair_within: Option<f64>,
}

impl GridData {
    /// Points row by row, where rows are successive in u, at increasing parameters in u and in v.
    pub(crate) fn new(points: &Arc<Points>, grid: Grid, parameters: Parameters) -> Self {
        let counts = [grid.rows, grid.columns];
        Self {
            points: Arc::clone(points),
            grid,
            parameters,
            curves: [0, 1].map(|axis| Arc::new(curves(points, counts, axis))),
            fair_within: None,
        }
    }

    /// The same, where fits within a tolerance are as fair as they can be.
    pub(crate) fn fair(self, tolerance: f64) -> Self {
        Self {
            fair_within: Some(tolerance),
            ..self
        }
    }

    /// The fits of all lines of a direction, and the largest distance that they leave at each
    /// parameter.
    fn project(&self, axis: usize, line: &Breaks, fairness: f64) -> Option<(Points, Vec<f64>)> {
        let (points, t) = (&self.curves[axis], &self.parameters[axis]);
        let values = Values::new(line, t);
        let fits = minimum(points, &values, fairness)?;
        let dimension = self.points.dimension();
        let lines = points.dimension() / dimension;
        let mut left = vec![0.0; t.len()];
        let residual = values.residual(&fits, points);
        for k in 0..lines {
            let mut distances = vec![0.0; t.len()];
            for c in 0..dimension {
                let residual = residual.lane(c * lines + k);
                for (sum, off) in distances.iter_mut().zip(residual) {
                    *sum = f64::hypot(*sum, *off);
                }
            }
            for (left, distance) in left.iter_mut().zip(distances) {
                *left = f64::max(*left, distance);
            }
        }
        Some((fits, left))
    }

    /// The least-squares surface with this fairness in each direction.
    fn nearest_with(&self, lines: &[Breaks; 2], fairness: f64) -> Option<Nearest> {
        let dimension = self.points.dimension();
        let (along, left_u) = self.project(0, &lines[0], fairness)?;
        let (_, left_v) = self.project(1, &lines[1], fairness)?;
        // The control points of all lines in u, as curves in v.
        let counts = [lines[0].control_points(), self.grid.columns];
        let between = curves(&joined(&along, dimension, 0), counts, 1);
        let values = Values::new(&lines[1], &self.parameters[1]);
        let across = minimum(&Arc::new(between), &values, fairness)?;
        let control_points = joined(&across, dimension, 1);
        Some(Nearest {
            distances: self.distances(lines, &control_points),
            control_points,
            left: [left_u, left_v],
        })
    }
}

impl Data for GridData {
    fn parameters(&self, axis: usize) -> &[f64] {
        &self.parameters[axis]
    }

    fn share(&self) -> f64 {
        SHARE
    }

    fn allows(&self, counts: [usize; 2]) -> bool {
        counts[0] <= self.grid.rows && counts[1] <= self.grid.columns
    }

    /// With the most fairness within the tolerance, if it has some.
    fn nearest(&self, lines: &[Breaks; 2], _from: Option<&Level<2>>) -> Option<Nearest> {
        let Some(tolerance) = self.fair_within else {
            return self.nearest_with(lines, 0.0);
        };
        let mut nearest = None;
        for fairness in FAIRNESS {
            nearest = self.nearest_with(lines, fairness);
            let is_within = |it: &Nearest| it.distances.max <= tolerance;
            if nearest.as_ref().is_some_and(is_within) {
                break;
            }
        }
        nearest
    }

    fn distances(&self, lines: &[Breaks; 2], control_points: &Points) -> Distances {
        let mut counts = lines.each_ref().map(Breaks::control_points);
        let mut residual = control_points.clone();
        for axis in [1, 0] {
            let values = Values::new(&lines[axis], &self.parameters[axis]);
            residual = along(&residual, counts, axis, |curves| values.points(curves));
            counts[axis] = self.parameters[axis].len();
        }
        for (fit, data) in residual.lanes_mut().iter_mut().zip(self.points.lanes()) {
            let pairs = fit.iter_mut().zip(&**data);
            pairs.for_each(|(fit, datum)| *fit = datum - *fit);
        }
        Distances::of_residual(&residual, normalizing_scale(self.points.magnitude()))
    }

    /// The direction with the larger residual.
    fn prefers(&self, fit: &Fit, _finer: &[Breaks; 2]) -> usize {
        let most = |axis: usize| fit.left[axis].iter().copied().fold(0.0, f64::max);
        usize::from(most(1) > most(0))
    }

    fn prunings(&self) -> usize {
        WORK / self.points.len().max(1)
    }

    /// With fewer data in a direction than the fewest control points: scattered points.
    fn undetermined(&self, options: &Options<2>) -> Option<Box<dyn Data>> {
        let [u, v] = &self.parameters;
        let columns = self.grid.columns;
        let along = u.iter().flat_map(|&u| std::iter::repeat_n(u, columns));
        let across = u.iter().flat_map(|_| v.iter().copied());
        let parameters = [Arc::new(along.collect()), Arc::new(across.collect())];
        let [rows, columns] = [0, 1].map(|axis| {
            let fewest = options.lines[axis].degree() + 1;
            self.parameters[axis].len().max(fewest)
        });
        let data = ScatteredData::new(&self.points, &parameters, [false; 2], options.tolerance);
        Some(Box::new(data.with_most(rows * columns)))
    }
}

/// Least squares of curves side by side.
fn minimum(curves: &Arc<Points>, values: &Values, fairness: f64) -> Option<Points> {
    let least_squares = LeastSquares {
        fairness,
        ..LeastSquares::of(curves)
    };
    least_squares.minimum(values, None)
}
