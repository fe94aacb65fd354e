//! Missing numbers: gaps of a grid, and points that are left out of curves and clouds. Until these cases are
//! distinguished they are NaN.

use super::error::FileError;
use super::grid_detection;
use super::imported::{Hints, Kind};
use super::part::{Order, Part, check_count};
use piad_fit::data::Points;

/// Takes coordinates of this value as missing.
pub(super) fn forget(points: &mut Points, no_data: f64) {
    for number in points
        .lanes_mut()
        .iter_mut()
        .flat_map(|lane| lane.iter_mut())
    {
        if *number == no_data {
            *number = f64::NAN;
        }
    }
}

/// Turns points with gaps into the missing points of a grid, or leaves them out. Degrees are checked for a grid also
/// without gaps, before they become metres.
///
/// # Errors
///
/// If fewer than two points are left.
pub(super) fn settle(
    part: &mut Part,
    degrees: bool,
    times: bool,
    hints: &Hints,
) -> Result<(), FileError> {
    let missing = missing(&part.points);
    if degrees || !missing.is_empty() {
        find_grid(part, hints);
    }
    let is_grid = matches!(part.order, Order::Rows(_)) || has_size(part, hints);
    match is_grid {
        true => keep_missing(part, missing),
        false => leave_out(part, &missing, "coordinates")?,
    }
    settle_times(part, times)
}

/// The indices of points with gaps.
fn missing(points: &Points) -> Vec<usize> {
    let lanes = points.lanes();
    if !lanes
        .iter()
        .any(|lane| lane.iter().any(|number| number.is_nan()))
    {
        return Vec::new();
    }
    let is_missing = |index: &usize| points.point(*index).any(f64::is_nan);
    (0..points.len()).filter(is_missing).collect()
}

/// Detects a grid by x and y, or by blank lines.
fn find_grid(part: &mut Part, hints: &Hints) {
    let curve = hints.kind == Some(Kind::Curve);
    if curve || hints.size.is_some() || grid_detection::is_several(part, hints) {
        return;
    }
    if let Some(grid) = grid_detection::shown(part) {
        part.order = Order::Rows(grid);
    }
}

/// Returns true if the hints give rows and columns whose product is the number of points.
fn has_size(part: &Part, hints: &Hints) -> bool {
    let count = |size: piad_fit::data::Grid| size.rows.checked_mul(size.columns);
    hints.size.and_then(count) == Some(part.points.len())
}

/// Makes points the missing ones of a grid, with numbers instead of gaps.
fn keep_missing(part: &mut Part, missing: Vec<usize>) {
    let Some(first) = missing.first() else {
        return;
    };
    let place = place(part, *first);
    part.notices.push(match missing.len() {
        1 => format!("The point {place} is missing in the grid."),
        count => {
            format!("{count} points are missing in the grid, the first of them {place}.")
        }
    });
    for lane in part.points.lanes_mut() {
        for index in &missing {
            if let Some(number) = lane.get_mut(*index).filter(|number| number.is_nan()) {
                *number = 0.0;
            }
        }
    }
    part.missing = missing;
}

/// Leaves points out, with a notice that names the missing values.
fn leave_out(part: &mut Part, missing: &[usize], what: &str) -> Result<(), FileError> {
    let Some(first) = missing.first() else {
        return Ok(());
    };
    let place = place(part, *first);
    part.notices.push(match missing.len() {
        1 => format!("The point {place} has no {what} and is left out."),
        count => {
            format!("{count} points have no {what} and are left out, the first of them {place}.")
        }
    });
    let is_kept = |index: &usize| missing.binary_search(index).is_err();
    let kept: Vec<usize> = (0..part.points.len()).filter(is_kept).collect();
    part.keep(&kept);
    let count = part.points.len();
    part.breaks.dedup();
    part.breaks.retain(|index| (1..count).contains(index));
    check_count(count)
}

fn place(part: &Part, index: usize) -> String {
    match part.lines.get(index) {
        Some(line) => format!("in line {line}"),
        None => format!("with index {index}"),
    }
}

/// Leaves out points without a time if times are the parameters, and otherwise all times.
fn settle_times(part: &mut Part, used: bool) -> Result<(), FileError> {
    let times = part.times.as_deref().unwrap_or_default();
    let is_gap = |index: &usize| times.get(*index).is_some_and(|time| time.is_nan());
    let missing: Vec<usize> = (0..times.len()).filter(is_gap).collect();
    if missing.is_empty() {
        return Ok(());
    }
    if used && !matches!(part.order, Order::Rows(_)) {
        return leave_out(part, &missing, "time");
    }
    part.times = None;
    let place = missing.first().map(|first| place(part, *first));
    part.notices.push(format!(
        "Points have no time, the first of them {}: the times are not read.",
        place.unwrap_or_default()
    ));
    Ok(())
}
