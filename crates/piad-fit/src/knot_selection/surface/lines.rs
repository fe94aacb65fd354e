//! The lines of grids as curves: what holds for a curve holds for all lines of a direction at once.

use crate::data::points::Points;

/// The lines of a grid along a direction side by side: coordinate c of line k becomes lane c · lines + k.
pub(super) fn curves(points: &Points, [rows, columns]: [usize; 2], axis: usize) -> Points {
    debug_assert_eq!(points.len(), rows * columns);
    let lines = [columns, rows][axis];
    let line = |lane: &[f64], k: usize| -> Vec<f64> {
        match axis {
            0 => lane[k..].iter().step_by(columns).copied().collect(),
            _ => lane[k * columns..][..columns].to_vec(),
        }
    };
    let lanes = points.lanes().iter();
    Points::from_lanes(lanes.flat_map(|lane| (0..lines).map(move |k| line(lane, k))))
}

/// The grid of such lines, of points of some dimension.
pub(super) fn joined(curves: &Points, dimension: usize, axis: usize) -> Points {
    let coordinates = curves.lanes().chunks_exact(curves.dimension() / dimension);
    Points::from_lanes(coordinates.map(|lines| -> Vec<f64> {
        match axis {
            0 => (0..curves.len())
                .flat_map(|i| lines.iter().map(move |line| line[i]))
                .collect(),
            _ => lines.iter().flat_map(|line| line.iter().copied()).collect(),
        }
    }))
}

/// The grid with other lines along a direction.
pub(super) fn along(
    points: &Points,
    counts: [usize; 2],
    axis: usize,
    change: impl FnOnce(&Points) -> Points,
) -> Points {
    let changed = change(&curves(points, counts, axis));
    joined(&changed, points.dimension(), axis)
}
