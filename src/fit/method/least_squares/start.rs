//! Level 0 of least-squares fits: samples of the data.

use crate::fit::direction::Direction;
use crate::fit::lane::Lane;
use crate::fit::points::Points;
use crate::fit::setup::Setup;
use crate::fit::shares::Position;

/// Level 0: data at equal distances of their indices, the first and the last point among them.
pub(super) fn start(setup: &Setup) -> Points {
    let (data, grid) = (setup.data(), setup.grid());
    let rows = samples(grid.rows, setup.u());
    let columns = setup
        .v()
        .map_or(vec![Position::at(0)], |v| samples(grid.columns, v));
    let pick = |lane: &Lane| {
        let row = |i: &Position| {
            let i = *i;
            let at = |row: usize, j: Position| j.between(|j| lane[row * grid.columns + j]);
            let points = columns.iter();
            points.map(move |j| i.between(|row| at(row, *j)))
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
