//! Removes points of a curve that equal the one before them: devices write them while they are at rest.

use super::part::Part;

/// Leaves out the points that equal the one before. Values of functions, which have one coordinate, may be equal; if
/// all points are equal none is left out, as that is not a curve.
pub(super) fn leave_out(part: &mut Part) {
    let points = &part.points;
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
    let line = part.lines.get(first).copied();
    let place = match line {
        Some(line) => format!("in line {line}"),
        None => format!("with index {first}"),
    };
    part.keep(&kept);
    part.notices.push(match repeated.len() {
        1 => format!("The point {place} equals the one before, and is kept once."),
        count => format!(
            "{count} points equal the one before, the first of them {place}: each is kept once."
        ),
    });
}
