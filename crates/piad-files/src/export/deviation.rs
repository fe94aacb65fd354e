//! Distances of the curve or surface from the data points at their parameters.

use super::nurbs::{KnotVector, Nurbs};
use piad_fit::data::Grid;
use piad_fit::engine::nurbs::SpanParameter;
use piad_fit::engine::vectors::{in_space, length, minus};
use piad_fit::engine::{Direction, Problem};

/// The most data points whose distance is computed; of more, some rows and columns are left out.
pub const MOST_MEASURED: usize = 1 << 18;

/// The most multiplications for the points of scattered data, which have no rows to share.
const MOST_OPERATIONS: usize = 1 << 28;

/// Points that are evaluated at a time.
const CHUNK: usize = 1 << 16;

/// Distances of data points from the curve or surface at their parameters.
#[derive(Clone, Debug)]
pub(super) struct Deviations {
    /// The distances, of a grid row by row; NaN where there is no data point.
    pub(super) distances: Vec<f64>,
    /// The parameters: those of rows and of columns of a grid, or u and v of each scattered point.
    pub(super) u: Vec<f64>,
    /// Empty for curves.
    pub(super) v: Vec<f64>,
    /// Each point has its own parameters, instead of a row and a column.
    pub(super) scattered: bool,
}

impl Deviations {
    /// The distances of all data points, or of those in every `stride`-th row and column.
    pub(super) fn of(problem: &Problem, nurbs: &Nurbs) -> Self {
        match (problem.v(), &nurbs.v) {
            (Some(across), Some(knots)) if problem.is_scattered() => {
                scattered(problem, nurbs, (across, knots))
            }
            (across, knots) => grid(problem, nurbs, across.zip(knots.as_ref())),
        }
    }

    /// The largest distance.
    pub(super) fn most(&self) -> f64 {
        let known = self.distances.iter().copied().filter(|it| !it.is_nan());
        known.fold(0.0, f64::max)
    }
}

fn grid(problem: &Problem, nurbs: &Nurbs, across: Option<(&Direction, &KnotVector)>) -> Deviations {
    let Grid { rows, columns } = problem.grid();
    let points = &problem.request().points;
    let stride = stride(problem.grid(), MOST_MEASURED);
    let some = |count: usize| (0..count).step_by(stride);
    let u: Vec<f64> = some(rows).map(|i| problem.u().parameters[i]).collect();
    let v = across.map(|(direction, _)| some(columns).map(|j| direction.parameters[j]).collect());
    let v: Vec<f64> = v.unwrap_or_default();
    let along: Vec<SpanParameter> = u.iter().map(|&t| nurbs.u.site_at(t)).collect();
    let knots = across.map(|(_, knots)| v.iter().map(|&t| knots.site_at(t)).collect());
    let knots: Vec<SpanParameter> = knots.unwrap_or_default();
    let width = v.len().max(1);
    let chunk = (CHUNK / width).max(1);
    let mut distances = Vec::with_capacity(u.len() * width);
    for (number, sites) in along.chunks(chunk).enumerate() {
        let jets = nurbs.evaluate(sites, &knots);
        for (index, jet) in jets.iter().enumerate() {
            let (row, column) = (number * chunk + index / width, index % width);
            let data = row * stride * columns + column * stride;
            let missing = problem.missing().is_some_and(|it| it.contains(data));
            distances.push(match missing {
                true => f64::NAN,
                false => length(minus(jet.point, in_space(points.point(data)))),
            });
        }
    }
    Deviations {
        distances,
        u,
        v,
        scattered: false,
    }
}

/// The smallest stride of rows and columns that leaves at most `most` points.
pub(super) fn stride(Grid { rows, columns }: Grid, most: usize) -> usize {
    let mut stride = 1;
    while rows.div_ceil(stride) * columns.div_ceil(stride) > most {
        stride += 1;
    }
    stride
}

fn scattered(
    problem: &Problem,
    nurbs: &Nurbs,
    (across, knots): (&Direction, &KnotVector),
) -> Deviations {
    let points = &problem.request().points;
    let cost = 8 * nurbs.columns() * (nurbs.u.degree + 1);
    let most = (MOST_OPERATIONS / cost).clamp(1, MOST_MEASURED);
    let is_there = |index: &usize| !problem.missing().is_some_and(|it| it.contains(*index));
    let some = (0..points.len()).step_by(points.len().div_ceil(most));
    let some = some.filter(is_there);
    let (mut u, mut v, mut distances) = (Vec::new(), Vec::new(), Vec::new());
    for index in some {
        let (s, t) = (problem.u().parameters[index], across.parameters[index]);
        let jets = nurbs.evaluate(&[nurbs.u.site_at(s)], &[knots.site_at(t)]);
        let place = in_space(points.point(index));
        let distance = jets.first().map(|jet| length(minus(jet.point, place)));
        u.push(s);
        v.push(t);
        distances.push(distance.unwrap_or(f64::NAN));
    }
    Deviations {
        distances,
        u,
        v,
        scattered: true,
    }
}
