//! Angles around a centre: whether points go all around, and the origin of the angles.

use std::f64::consts::TAU;

/// The largest gap of points that go all around.
const GAP: f64 = TAU / 12.0;

/// Angles, counted from the middle of the largest gap between them, or where they go all around, or are to, from zero on;
/// returns true then.
pub(super) fn counted(mut angles: Vec<f64>, is_closed: bool) -> (Vec<f64>, bool) {
    let mut sorted = angles.clone();
    sorted.sort_by(f64::total_cmp);
    let ends = sorted.iter().skip(1).copied();
    let ends = ends.chain(sorted.first().map(|first| first + TAU));
    let gaps = sorted
        .iter()
        .zip(ends)
        .map(|(start, end)| (end - start, end));
    let (gap, start) = gaps.fold(
        (0.0, 0.0),
        |most, gap| if gap.0 > most.0 { gap } else { most },
    );
    let goes_around = is_closed || gap <= GAP;
    // In the middle of the gap, so that rounding takes no point around.
    let start = if goes_around { 0.0 } else { start - 0.5 * gap };
    for angle in &mut angles {
        *angle = (*angle - start).rem_euclid(TAU);
        if *angle >= TAU {
            *angle = 0.0;
        }
    }
    (angles, goes_around)
}
