//! The corners of a polyline: points at which it turns, but not those of sampled arcs or noise.
//!
//! A point is a corner if it turns by more than an angle and by more than [`TIMES`] the turn of the points around it.
//! These count the less, the further away they are: the next corner of an outline is further away than the next sample
//! of an arc.
//!
//! ```text
//! turn_i > angle,   turn_i > 3 turn_j |j − i| h / s_ij,   0 < |j − i| ≤ 2
//! ```
//!
//! with the length s_ij of the polyline between two points, and the shortest edge h among the six around point i. Those that
//! turn by more than [`SHARP`] may be beside each other, as in rectangles. Where many points turn it is noise, and there is
//! no corner.

use super::points::Points;

/// The default angle, in degrees.
pub(crate) const USUAL_ANGLE: f64 = 30.0;

/// The least ratio of a corner's turn to the turn around it.
const TIMES: f64 = 3.0;

/// Points of arcs turn by less than this angle, in degrees: a circle would have four of them.
const SHARP: f64 = 75.0;

/// Where more points than this turn, and more than one in [`PART`], they are noise.
const FEW: usize = 16;

/// See [`FEW`].
const PART: usize = 5;

/// The number of neighbours examined on either side.
const AROUND: usize = 2;

/// The points, in order, at which a polyline turns by more than an angle in radians, as corners do; of an open one not its
/// ends.
pub(crate) fn find(points: &Points, closed: bool, angle: f64) -> Vec<usize> {
    let turning = turns(points, closed, angle);
    if turning.len() > FEW.max(points.len() / PART) {
        return Vec::new();
    }
    let polyline = Polyline { points, closed };
    let is_corner = |i: &usize| polyline.is_corner(*i);
    turning.into_iter().filter(is_corner).collect()
}

/// The points, in order, at which a polyline turns by more than an angle in radians, whatever the points around them
/// do.
pub(crate) fn turns(points: &Points, closed: bool, angle: f64) -> Vec<usize> {
    let polyline = Polyline { points, closed };
    (0..points.len())
        .filter(|&i| polyline.turn(i) > angle)
        .collect()
}

struct Polyline<'a> {
    points: &'a Points,
    closed: bool,
}

impl Polyline<'_> {
    /// The point that is `places` after another one, if there is one.
    fn after(&self, index: usize, places: isize) -> Option<usize> {
        let count = self.points.len() as isize;
        let at = index as isize + places;
        match self.closed {
            true => Some(at.rem_euclid(count) as usize),
            false => (0..count).contains(&at).then_some(at as usize),
        }
    }

    /// The angle by which it turns at a point, in radians; 0 at the ends of an open one.
    fn turn(&self, index: usize) -> f64 {
        let (Some(before), Some(after)) = (self.after(index, -1), self.after(index, 1)) else {
            return 0.0;
        };
        let lengths = [
            self.points.distance(before, index),
            self.points.distance(index, after),
        ];
        if lengths.contains(&0.0) {
            return 0.0;
        }
        let (mut sum, mut difference) = (0.0_f64, 0.0_f64);
        for lane in self.points.lanes() {
            let a = (lane[index] - lane[before]) / lengths[0];
            let b = (lane[after] - lane[index]) / lengths[1];
            sum = sum.hypot(a + b);
            difference = difference.hypot(b - a);
        }
        2.0 * difference.atan2(sum)
    }

    /// The edge after a point.
    fn edge(&self, index: usize) -> Option<f64> {
        Some(self.points.distance(index, self.after(index, 1)?))
    }

    /// Returns true if a point that turns does so as corners do.
    fn is_corner(&self, index: usize) -> bool {
        let turn = self.turn(index);
        let reach = AROUND as isize;
        let edges = (-reach - 1..=reach).filter_map(|places| self.edge(self.after(index, places)?));
        let shortest = edges.fold(f64::INFINITY, f64::min);
        let outnumbered = |way: isize| {
            let mut length = 0.0;
            (1..=reach).any(|places| {
                let (from, to) = (way * (places - 1), way * places);
                let (Some(from), Some(beside)) = (self.after(index, from), self.after(index, to))
                else {
                    return false;
                };
                length += self.points.distance(from, beside);
                let near = places as f64 * shortest / length;
                let other = self.turn(beside);
                let both = turn.min(other) > SHARP.to_radians();
                beside != index && !both && turn <= TIMES * other * near
            })
        };
        !outnumbered(-1) && !outnumbered(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    fn of(points: &[[f64; 2]]) -> Points {
        Points::from_flat(2, &points.concat())
    }

    const ANGLE: f64 = USUAL_ANGLE / 180.0 * std::f64::consts::PI;

    /// A zigzag with samples on its edges, an outline with short and long edges, and a teardrop.
    #[test]
    fn corners_are_found() {
        let zigzag: Vec<[f64; 2]> = (0..=24)
            .map(|i| [f64::from(i), f64::from((i % 8 - 4_i32).abs())])
            .collect();
        assert_eq!(find(&of(&zigzag), false, ANGLE), [4, 8, 12, 16, 20]);
        let edge = (0..=10).map(|i| [3.0 * f64::from(i), 0.0]);
        let fillet = (1..10).map(|k| f64::from(k) * FRAC_PI_2 / 10.0);
        let fillet = fillet.map(|a| [30.0 + 50.0 * a.sin(), 50.0 - 50.0 * a.cos()]);
        let bracket: Vec<[f64; 2]> = edge
            .chain(fillet)
            .chain([[80.0, 50.0], [80.0, 62.0], [0.0, 62.0], [0.0, 12.0]])
            .collect();
        assert_eq!(find(&of(&bracket), false, ANGLE), [21, 22]);
        // Closed, the point before the first edge is one, too, and so is the first.
        assert_eq!(find(&of(&bracket), true, ANGLE), [0, 21, 22]);
        let drop = (0..40).map(|i| f64::from(i) * TAU / 40.0);
        let drop: Vec<[f64; 2]> = drop
            .map(|a| [a.cos(), a.sin() * (a / 2.0).sin().powi(3)])
            .collect();
        assert_eq!(find(&of(&drop), true, ANGLE), [0]);
    }

    /// Arcs, coarse circles, lines and noise have none.
    #[test]
    fn smooth_and_noisy_points_have_none() {
        for count in [5_u32, 8, 100] {
            let circle = (0..count).map(|i| f64::from(i) * TAU / f64::from(count));
            let circle: Vec<[f64; 2]> = circle.map(|a| [a.cos(), a.sin()]).collect();
            for closed in [false, true] {
                assert!(
                    find(&of(&circle), closed, ANGLE).is_empty(),
                    "{count} {closed}"
                );
            }
        }
        let mut random = 7_u64;
        let mut uniform = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for size in [0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0] {
            let mut found = 0;
            for _ in 0..100 {
                let noisy: Vec<[f64; 2]> = (0..80)
                    .map(|i| {
                        [
                            f64::from(i) + size * 3.46 * uniform(),
                            size * 3.46 * uniform(),
                        ]
                    })
                    .collect();
                found += find(&of(&noisy), false, ANGLE).len();
            }
            assert!(found <= 8, "{size}: {found}");
        }
        let wave: Vec<[f64; 2]> = (0..50)
            .map(f64::from)
            .map(|x| [x, 3.0 * (0.4 * x).sin()])
            .collect();
        assert!(find(&of(&wave), false, ANGLE).is_empty());
    }
}
