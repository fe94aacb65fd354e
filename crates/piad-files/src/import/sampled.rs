//! Points on arcs and other smooth curves of drawings.

use std::f64::consts::PI;

use super::curves::Point;

/// The notice about a part with points of arcs or other curves.
pub(super) const SAMPLED: &str = "Arcs and curves are sampled: an arc every 5 degrees or less, other curves at 16 places or more of each piece.";

/// The largest angle of an arc between two points.
const LARGEST_ANGLE: f64 = 5.0 * PI / 180.0;

/// The fewest pieces of an arc.
const FEWEST_OF_ARC: usize = 2;

/// The fewest and the most pieces of a curve that is not an arc.
const MIN_PIECES: usize = 16;
const MAX_PIECES: usize = 64;

/// Curves that are no arcs are no further from their polygon than this part of the length of their control polygon,
/// unless they have the most pieces.
const TOLERANCE: f64 = 1e-3;

/// A vector times a number, from a point on.
pub(super) fn along(point: Point, vector: Point, factor: f64) -> Point {
    let [x, y, z] = point;
    let [dx, dy, dz] = vector;
    [x + factor * dx, y + factor * dy, z + factor * dz]
}

/// An arc of a circle or an ellipse: `centre + cos(t) first + sin(t) second`, from an angle on over another one, which is
/// at most a full turn, in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) centre: Point,
    pub(super) axes: [Point; 2],
    pub(super) start: f64,
    pub(super) sweep: f64,
}

impl Arc {
    /// The point at a part of the arc from 0 to 1.
    pub(super) fn at(&self, part: f64) -> Point {
        let (sine, cosine) = (self.start + part * self.sweep).sin_cos();
        let [first, second] = self.axes;
        along(along(self.centre, first, cosine), second, sine)
    }

    /// The parts of the arc where its points are, without its start.
    pub(super) fn parts(&self) -> impl Iterator<Item = f64> + use<> {
        // The number of a full turn if the sweep is not finite.
        let pieces = self.sweep.abs().min(2.0 * PI) / LARGEST_ANGLE;
        // Rounding makes no piece more.
        let pieces = (pieces - 1e-9).ceil();
        let pieces = (pieces as usize).max(FEWEST_OF_ARC);
        (1..=pieces).map(move |i| i as f64 / pieces as f64)
    }

    /// Its points, without its start.
    pub(super) fn points(self) -> impl Iterator<Item = Point> {
        self.parts().map(move |part| self.at(part))
    }

    /// Points from its start on.
    pub(super) fn all_points(self) -> impl Iterator<Item = Point> {
        [self.at(0.0)].into_iter().chain(self.points())
    }
}

/// The points of a cubic Bézier curve, without its start.
pub(super) fn cubic(control: [Point; 4]) -> impl Iterator<Item = Point> {
    let pieces = pieces(&control);
    let [a, b, c, d] = control;
    (1..=pieces).map(move |i| {
        let t = i as f64 / pieces as f64;
        // Its ends are points of it exactly.
        if i == pieces {
            return d;
        }
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let points = [a, b, c, d].into_iter().zip(weights);
        points.fold([0.0; 3], |sum, (point, weight)| along(sum, point, weight))
    })
}

/// The number of pieces of a Bézier curve with these control points.
fn pieces(control: &[Point; 4]) -> usize {
    let minus = |a: &Point, b: &Point| along(*a, *b, -1.0);
    let length = |[x, y, z]: Point| x.hypot(y).hypot(z);
    let [a, b, c, d] = control;
    let edges = [minus(b, a), minus(c, b), minus(d, c)];
    let bend = |before: &Point, after: &Point| length(minus(after, before));
    let bend = bend(&edges[0], &edges[1]).max(bend(&edges[1], &edges[2]));
    let tolerance = TOLERANCE * edges.map(length).iter().sum::<f64>();
    // The second derivative is at most six times the largest bend; a chord is off by an eighth of it.
    let pieces = (0.75 * bend / tolerance).sqrt().ceil();
    // An even number, so that the middle of the curve is a point.
    (pieces as usize)
        .clamp(MIN_PIECES, MAX_PIECES)
        .next_multiple_of(2)
}

/// The number of pieces between two knots of a spline.
pub(super) const PIECES_OF_SPAN: usize = MIN_PIECES;

/// An angle as one from 0 to a full turn, without 0: two equal angles are a full turn apart.
pub(super) fn turn(angle: f64) -> f64 {
    let angle = angle.rem_euclid(2.0 * PI);
    match angle > 0.0 {
        true => angle,
        false => 2.0 * PI,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::curves::distance;

    #[test]
    fn arcs_have_points_every_five_degrees() {
        let arc = |sweep: f64| Arc {
            centre: [1.0, 2.0, 3.0],
            axes: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            start: 0.3,
            sweep,
        };
        for (degrees, count) in [(360.0, 72), (-90.0, 18), (91.0, 19), (0.1, 2)] {
            let arc = arc(f64::to_radians(degrees));
            assert_eq!(arc.points().count(), count, "{degrees}");
            for point in arc.all_points() {
                assert!((distance(&point, &arc.centre) - 2.0).abs() < 1e-12);
            }
        }
        for sweep in [f64::NAN, f64::INFINITY, 1e300, 0.0] {
            assert!(arc(sweep).points().count() <= 72);
        }
    }

    #[test]
    fn cubics_keep_to_their_tolerance() {
        let flat = |x: f64, y: f64| [x, y, 0.0];
        let line = [0.0, 1.0, 2.0, 3.0].map(|x| flat(x, 0.0));
        assert_eq!(cubic(line).count(), MIN_PIECES);
        let loops = [
            flat(0.0, 0.0),
            flat(1e6, 1e6),
            flat(-1e6, 1e6),
            flat(1.0, 0.0),
        ];
        let points: Vec<Point> = cubic(loops).collect();
        assert!(points.len() > 20 && points.len() <= MAX_PIECES);
        assert_eq!(points.last(), Some(&loops[3]));
        let wild = [
            flat(0.0, 0.0),
            flat(1e308, -1e308),
            flat(-1e308, 1e308),
            flat(1.0, 0.0),
        ];
        assert!(cubic(wild).count() <= MAX_PIECES);
    }

    #[test]
    fn turns_are_positive() {
        for (angle, expected) in [(0.0, 2.0 * PI), (-PI, PI), (5.0 * PI, PI), (1.0, 1.0)] {
            assert!((turn(angle) - expected).abs() < 1e-12, "{angle}");
        }
    }
}
