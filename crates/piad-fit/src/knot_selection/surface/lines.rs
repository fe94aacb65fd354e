//! The lines of grids as curves: what holds for a curve holds for all lines of a direction at once.

use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::insertion::refine;

/// The control points of the same surface with more knots in a direction, `fine`.
pub(super) fn refined(lines: &[Breaks; 2], points: &Points, axis: usize, fine: &Breaks) -> Points {
    let coarse = &lines[axis];
    let [rows, columns] = [0, 1].map(|axis| lines[axis].control_points());
    let dimension = points.dimension();
    if axis == 1 {
        let curves = refine(coarse, fine, &lines_of(points, rows, columns));
        joined(&curves, dimension, rows, fine.control_points())
    } else {
        let turned = lines_of(&transposed(points, rows, columns), columns, rows);
        let curves = refine(coarse, fine, &turned);
        let joined = joined(&curves, dimension, columns, fine.control_points());
        transposed(&joined, columns, fine.control_points())
    }
}

/// The lines of a grid side by side: coordinate c of line k becomes lane c · lines + k.
pub(super) fn lines_of(points: &Points, lines: usize, length: usize) -> Points {
    let all = points.lanes().iter();
    debug_assert_eq!(points.len(), lines * length);
    Points::from_lanes(all.flat_map(|lane| lane.chunks_exact(length)))
}

/// The inverse of [`lines_of`].
pub(super) fn joined(curves: &Points, dimension: usize, lines: usize, length: usize) -> Points {
    Points::from_lanes((0..dimension).map(|c| {
        let mut lane = Vec::with_capacity(lines * length);
        (0..lines).for_each(|k| lane.extend_from_slice(curves.lane(c * lines + k)));
        lane
    }))
}

/// The grid with rows and columns exchanged.
pub(super) fn transposed(points: &Points, rows: usize, columns: usize) -> Points {
    let lanes = points.lanes().iter();
    Points::from_lanes(lanes.map(|lane| flipped(lane, rows, columns)))
}

/// The same for one coordinate.
pub(super) fn flipped(lane: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..columns)
        .flat_map(|j| (0..rows).map(move |i| lane[i * columns + j]))
        .collect()
}
