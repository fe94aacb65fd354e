//! Level 0 of least-squares fits: samples of the data, or means of scattered points.

use super::objective::NO_DATA;
use crate::basis::direction::Direction;
use crate::data::aligned::Lane;
use crate::data::missing::Missing;
use crate::data::points::Points;
use crate::data::quantiles::Position;
use crate::method::equations::Equations;
use crate::setup::Setup;

/// Level 0: data at equal distances of their indices, the first and the last point among them.
pub(super) fn start(setup: &Setup) -> Points {
    let (data, grid) = (setup.data(), setup.grid());
    let there = &setup.rows();
    let rows = samples(there.len(), setup.u());
    let columns = setup
        .v()
        .map_or(vec![Position::at(0)], |v| samples(grid.columns, v));
    let pick = |lane: &Lane| {
        let row = |i: &Position| {
            let i = *i;
            let at = |row: usize, j: Position| j.between(|j| lane[row * grid.columns + j]);
            let points = columns.iter();
            points.map(move |j| i.between(|row| at(there[row], *j)))
        };
        rows.iter().flat_map(row).collect::<Vec<f64>>()
    };
    Points::from_lanes(data.lanes().iter().map(pick))
}

/// Which of `count` data points the control points of a direction start from, or between which two
/// of them.
fn samples(count: usize, direction: &Direction) -> Vec<Position> {
    let control_points = direction.free();
    let parts = if direction.is_closed() {
        control_points
    } else {
        control_points - 1
    };
    let position = |i| {
        if direction.starts_spread() {
            Position::new(i, parts, count - 1)
        } else {
            Position::at((count * i / parts).min(count - 1))
        }
    };
    (0..control_points).map(position).collect()
}

/// Level 0 of scattered points: each control point is the mean of all points. From there the first
/// step of `diagonal` leads to the means of the points in the support of each function, weighted with
/// it, `x_j = (AᵀP)_j / (Aᵀ1)_j`. Control points without points in their support stay where they are,
/// so they have the weighted mean of the nearest one that has some, counted in steps of the control
/// grid.
pub(super) fn means(equations: &Equations) -> Points {
    let (setup, matrix) = (&equations.setup, &equations.collocation);
    let (data, grid) = (setup.data(), setup.control_grid());
    let mut scratch = vec![0.0; matrix.scratch()];
    let mut weights = vec![0.0; grid.count()];
    let mut counted = vec![1.0; data.len()];
    if let Some(missing) = setup.missing() {
        missing.clear(&mut counted);
    }
    matrix.apply_transposed(&counted, &mut weights, &mut scratch);
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let is_lost = |j: &usize| weights[*j] <= NO_DATA * largest;
    let lost: Vec<usize> = (0..weights.len()).filter(is_lost).collect();
    let mut means = Points::zeros(data.dimension(), grid.count());
    let missing = Missing::new(&lost, grid.count());
    if let Some(missing) = &missing {
        for (means, lane) in means.lanes_mut().iter_mut().zip(data.lanes()) {
            let lane: Vec<f64> = lane.iter().zip(&counted).map(|(x, one)| x * one).collect();
            matrix.apply_transposed(&lane, means, &mut scratch);
            let means = means.iter_mut().zip(&weights);
            means.for_each(|(mean, weight)| *mean /= weight);
        }
        missing.fill(&mut means, grid);
    }
    let count: f64 = counted.iter().sum();
    for (means, lane) in means.lanes_mut().iter_mut().zip(data.lanes()) {
        let mean: f64 = lane
            .iter()
            .zip(&counted)
            .map(|(x, one)| one * x / count)
            .sum();
        for (j, place) in means.iter_mut().enumerate() {
            if !missing.as_ref().is_some_and(|it| it.contains(j)) {
                *place = mean;
            }
        }
    }
    means
}
