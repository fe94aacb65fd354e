//! Points of a curve that equal the one before them: devices write them where they rest. Each is kept once.

use super::table::Table;
use piad_fit::data::Points;

/// Leaves out the points that equal the one before. Values of functions, which have one coordinate, may be equal; and of
/// points that are all equal none is left out, as that is no curve.
pub(super) fn leave_out(table: &mut Table) {
    let points = &table.points;
    let is_repeated = |i: usize| {
        i > 0
            && points
                .lanes()
                .iter()
                .all(|lane| lane.get(i) == lane.get(i - 1))
    };
    let Some(first) = (1..points.len()).find(|&i| is_repeated(i)) else {
        return;
    };
    let (repeated, kept): (Vec<usize>, Vec<usize>) =
        (0..points.len()).partition(|&i| is_repeated(i));
    if points.dimension() == 1 || kept.len() == 1 {
        return;
    }
    let some = |lane: &[f64]| {
        kept.iter()
            .filter_map(|&i| lane.get(i).copied())
            .collect::<Vec<_>>()
    };
    table.points = Points::from_lanes(points.lanes().iter().map(|lane| some(lane)));
    let line = table.lines.get(first).copied().unwrap_or_default();
    table.lines = kept
        .iter()
        .filter_map(|&i| table.lines.get(i).copied())
        .collect();
    let before = |index: usize| repeated.partition_point(|&it| it < index);
    table
        .breaks
        .iter_mut()
        .for_each(|index| *index -= before(*index));
    table.notices.push(match repeated.len() {
        1 => format!("The point in line {line} equals the one before, and is there once."),
        count => format!(
            "{count} points equal the one before, the first of them in line {line}: each is there once."
        ),
    });
}
