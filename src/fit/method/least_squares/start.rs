//! Level 0 of least-squares fits: samples of the data.

use crate::fit::lane::Lane;
use crate::fit::points::Points;
use crate::fit::setup::Setup;

/// Level 0: data points at equal distances of their indices, the first and the last among them.
pub(super) fn start(setup: &Setup) -> Points {
    let (data, grid) = (setup.data(), setup.grid());
    let rows = samples(grid.rows, setup.u().free(), setup.u().is_closed());
    let columns = setup
        .v()
        .map_or(vec![0], |v| samples(grid.columns, v.free(), v.is_closed()));
    let pick = |lane: &Lane| {
        let row = |i: &usize| {
            let start = i * grid.columns;
            columns.iter().map(move |j| lane[start + j])
        };
        rows.iter().flat_map(row).collect::<Vec<f64>>()
    };
    Points::from_lanes(data.lanes().iter().map(pick))
}

/// Which of `count` data points the control points of a direction start from.
fn samples(count: usize, control_points: usize, closed: bool) -> Vec<usize> {
    let parts = if closed {
        control_points
    } else {
        control_points - 1
    };
    (0..control_points)
        .map(|i| (count * i / parts).min(count - 1))
        .collect()
}
