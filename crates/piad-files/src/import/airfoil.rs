//! Airfoils. A Selig file goes around from the trailing edge and is a curve as it stands. A Lednicer file begins with
//! the numbers of points of both sides, which follow from the leading edge on. An MSES file begins with the domain of a
//! grid, and may have several elements.

use super::part::Part;
use piad_fit::data::Points;

/// The separator between the elements of an airfoil in an MSES file.
pub(super) const NEXT_ELEMENT: [f64; 2] = [999.0, 999.0];

/// Returns true if these numbers can be the domain of a grid: the ends of an interval of x and of one of y.
pub(super) fn is_domain(numbers: &[f64]) -> bool {
    matches!(numbers, [left, right, bottom, top] if left < right && bottom < top)
}

/// Turns a Lednicer file into a curve around the airfoil, as in a Selig file; others are unchanged.
pub(super) fn around(mut table: Part) -> Part {
    let Some((upper, lower)) = sides(&table) else {
        return table;
    };
    // The first point holds the numbers. The leading edge occurs twice.
    let first_lower = upper + 1;
    let same = table.points.distance(1, first_lower) == 0.0;
    let order = (1..=upper).rev();
    let order: Vec<usize> = order
        .chain(first_lower + usize::from(same)..=upper + lower)
        .collect();
    let lanes = table.points.lanes().iter();
    let lanes: Vec<Vec<f64>> = lanes
        .map(|lane| {
            order
                .iter()
                .filter_map(|&index| lane.get(index).copied())
                .collect()
        })
        .collect();
    table.points = Points::from_lanes(lanes);
    let line = |index: &usize| table.lines.get(*index).copied().unwrap_or_default();
    table.lines = order.iter().map(line).collect();
    table.breaks.clear();
    table.notices.push(format!(
        "The file has the {upper} points of the upper side and the {lower} of the lower one from the leading edge on (Lednicer); the curve goes around from the trailing edge."
    ));
    table
}

/// The numbers of points of the upper and the lower side, if the file begins with them.
fn sides(table: &Part) -> Option<(usize, usize)> {
    let points = &table.points;
    if points.dimension() != 2 || table.breaks.first() != Some(&1) || table.times.is_some() {
        return None;
    }
    let count = |c: usize| {
        let number = *points.lane(c).first()?;
        let is_count = number >= 2.0 && number.fract() == 0.0 && number < points.len() as f64;
        is_count.then_some(number as usize)
    };
    let (upper, lower) = (count(0)?, count(1)?);
    (upper + lower + 1 == points.len()).then_some((upper, lower))
}
