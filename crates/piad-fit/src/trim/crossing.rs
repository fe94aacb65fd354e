//! Loops that touch or cross themselves or each other.

use std::collections::BTreeSet;

use crate::geometry::nurbs::Nurbs;
use crate::geometry::outline::polyline;
use crate::interrupt::Meter;

/// The longest step along a loop, in cells.
const STEP: f64 = 0.25;

/// A straight step along a loop.
struct Segment {
    of: usize,
    /// Its number, and that of all of the loop.
    place: [usize; 2],
    from: [f64; 2],
    to: [f64; 2],
}

/// The indices of loops that touch or cross; coordinates are in cells.
pub(super) fn crossing(loops: &[Nurbs]) -> BTreeSet<usize> {
    let mut segments = Vec::new();
    for (of, curve) in loops.iter().enumerate() {
        let line = polyline(curve, [1.0; 2], STEP);
        let count = line.len() - 1;
        segments.extend(line.windows(2).enumerate().map(|(k, ends)| Segment {
            of,
            place: [k, count],
            from: ends[0],
            to: ends[1],
        }));
    }
    let mut crossing = BTreeSet::new();
    let mut meter = Meter::default();
    for near in neighbours(&segments).chunk_by(|a, b| a.0 == b.0) {
        for (k, (_, a)) in near.iter().enumerate() {
            for (_, b) in &near[k + 1..] {
                meter.add(16);
                let [a, b] = [&segments[*a], &segments[*b]];
                if meet(a, b) {
                    crossing.extend([a.of, b.of]);
                }
            }
        }
    }
    crossing
}

/// Each segment with each cell that its box touches, sorted by cells.
fn neighbours(segments: &[Segment]) -> Vec<([i64; 2], usize)> {
    let mut near = Vec::with_capacity(2 * segments.len());
    for (index, segment) in segments.iter().enumerate() {
        let ends = |axis: usize| {
            let [a, b] = [segment.from[axis], segment.to[axis]];
            a.min(b).floor() as i64..=a.max(b).floor() as i64
        };
        for i in ends(0) {
            near.extend(ends(1).map(|j| ([i, j], index)));
        }
    }
    near.sort_unstable();
    near
}

fn meet(a: &Segment, b: &Segment) -> bool {
    let turn = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let [first, second] = match a.place[0] < b.place[0] {
        true => [a, b],
        false => [b, a],
    };
    let between = second.place[0] - first.place[0];
    if a.of == b.of && (between <= 1 || between + 1 == a.place[1]) {
        // Neighbours meet at their ends, and fold if they go back.
        let along = (a.to[0] - a.from[0]) * (b.to[0] - b.from[0])
            + (a.to[1] - a.from[1]) * (b.to[1] - b.from[1]);
        let turn = turn(a.from, a.to, b.to)
            .abs()
            .max(turn(a.from, a.to, b.from).abs());
        return along < 0.0 && turn < 1e-9;
    }
    let sides =
        |s: &Segment, t: &Segment| turn(s.from, s.to, t.from) * turn(s.from, s.to, t.to) <= 0.0;
    let overlap = |axis: usize| {
        let low = |s: &Segment| s.from[axis].min(s.to[axis]);
        let high = |s: &Segment| s.from[axis].max(s.to[axis]);
        low(a) <= high(b) && low(b) <= high(a)
    };
    sides(a, b) && sides(b, a) && overlap(0) && overlap(1)
}
