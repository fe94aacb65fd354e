//! Draws the pieces of outlines as points.

use super::scan::Transform;
use crate::import::curves::{Curve, Point};
use crate::import::sampled::{Arc, SAMPLED, cubic};

/// A place in the coordinates of an element.
pub(super) type Place = [f64; 2];

/// The ellipse that an arc is part of, in the terms of SVG.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcShape {
    pub(super) radii: [f64; 2],
    /// The angle of the first axis, in degrees.
    pub(super) rotation: f64,
    /// True if it is the longer one of the two arcs to the same place.
    pub(super) large: bool,
    /// True if its angle increases.
    pub(super) sweep: bool,
}

/// Converts drawing commands to points.
pub(super) struct Pen {
    transform: Transform,
    /// The line of all points.
    line: u32,
    /// Where it began, and where it is, in the coordinates of the element.
    pub(super) start: Place,
    pub(super) place: Place,
    curve: Curve,
    /// The outlines that are finished.
    curves: Vec<Curve>,
    count: usize,
}

impl Pen {
    pub(super) fn new(transform: Transform, line: u32) -> Self {
        Self {
            transform,
            line,
            start: [0.0; 2],
            place: [0.0; 2],
            curve: Curve::new(None),
            curves: Vec::new(),
            count: 0,
        }
    }

    /// The number of points.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Begins another outline.
    pub(super) fn move_to(&mut self, place: Place) {
        self.finish();
        (self.start, self.place) = (place, place);
    }

    pub(super) fn line_to(&mut self, place: Place) {
        self.begin();
        self.push(self.point(place));
        self.place = place;
    }

    pub(super) fn cubic_to(&mut self, first: Place, second: Place, place: Place) {
        self.begin();
        let control = [self.place, first, second, place];
        for point in cubic(control.map(|place| self.point(place))) {
            self.push(point);
        }
        self.say_sampled();
        self.place = place;
    }

    pub(super) fn quadratic_to(&mut self, middle: Place, place: Place) {
        let third = |end: Place| {
            let [x, y] = middle;
            [
                end[0] + (x - end[0]) * 2.0 / 3.0,
                end[1] + (y - end[1]) * 2.0 / 3.0,
            ]
        };
        self.cubic_to(third(self.place), third(place), place);
    }

    /// An arc; a line if its ellipse has no area.
    pub(super) fn arc_to(&mut self, shape: ArcShape, place: Place) {
        if place == self.place {
            return;
        }
        let arc = arc(self.place, shape, place);
        let Some(arc) = arc.filter(|arc| arc.sweep.is_finite()) else {
            self.line_to(place);
            return;
        };
        self.begin();
        for part in arc.parts().filter(|part| *part < 1.0) {
            let [x, y, _] = arc.at(part);
            self.push(self.point([x, y]));
        }
        self.push(self.point(place));
        self.say_sampled();
        self.place = place;
    }

    /// A line back to where the outline began.
    pub(super) fn close(&mut self) {
        self.curve.closed = true;
        self.finish();
        self.place = self.start;
    }

    /// The outlines that were drawn.
    pub(super) fn curves(mut self) -> Vec<Curve> {
        self.finish();
        self.curves
    }

    fn finish(&mut self) {
        let curve = std::mem::replace(&mut self.curve, Curve::new(None));
        if !curve.points.is_empty() {
            self.curves.push(curve);
        }
    }

    /// Takes the first point of an outline.
    fn begin(&mut self) {
        if self.curve.points.is_empty() {
            self.push(self.point(self.place));
        }
    }

    fn push(&mut self, point: Point) {
        self.curve.push(point, self.line);
        self.count += 1;
    }

    fn point(&self, place: Place) -> Point {
        let [x, y] = self.transform.apply(place);
        [x, y, 0.0]
    }

    fn say_sampled(&mut self) {
        if self.curve.notices.is_empty() {
            self.curve.notices.push(SAMPLED.to_owned());
        }
    }
}

/// The arc from one place to another, by the implementation notes of SVG (F.6.5); `None` if it is a line.
fn arc(from: Place, shape: ArcShape, to: Place) -> Option<Arc> {
    let (sine, cosine) = shape.rotation.to_radians().sin_cos();
    let [mut rx, mut ry] = shape.radii.map(f64::abs);
    if rx == 0.0 || ry == 0.0 {
        return None;
    }
    // Half of the way in the directions of the axes.
    let [dx, dy] = [(from[0] - to[0]) / 2.0, (from[1] - to[1]) / 2.0];
    let [x, y] = [cosine * dx + sine * dy, cosine * dy - sine * dx];
    let reach = (x / rx).hypot(y / ry);
    if reach > 1.0 {
        (rx, ry) = (rx * reach, ry * reach);
    }
    let [u, v] = [x / rx, y / ry];
    let square = u * u + v * v;
    let away = ((1.0 - square) / square).max(0.0).sqrt();
    let away = if shape.large == shape.sweep {
        -away
    } else {
        away
    };
    // The centre on the unit circle, and the angles from it.
    let [p, q] = [away * v, -away * u];
    let start = (v - q).atan2(u - p);
    let end = (-v - q).atan2(-u - p);
    let sweep = match shape.sweep {
        true => (end - start).rem_euclid(std::f64::consts::TAU),
        false => -(start - end).rem_euclid(std::f64::consts::TAU),
    };
    let middle = [(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0];
    let axes = [
        [rx * cosine, rx * sine, 0.0],
        [-ry * sine, ry * cosine, 0.0],
    ];
    let centre = |c: usize| middle[c] + p * axes[0][c] + q * axes[1][c];
    Some(Arc {
        centre: [centre(0), centre(1), 0.0],
        axes,
        start,
        sweep,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_are_on_their_ellipses() {
        for (large, sweep, rotation) in [
            (false, false, 0.0),
            (false, true, 30.0),
            (true, false, -200.0),
            (true, true, 90.0),
        ] {
            let shape = ArcShape {
                radii: [3.0, -2.0],
                rotation,
                large,
                sweep,
            };
            let (from, to) = ([1.0, 1.0], [2.0, 3.0]);
            let arc = arc(from, shape, to).unwrap();
            for (part, expected) in [(0.0, from), (1.0, to)] {
                let [x, y, _] = arc.at(part);
                assert!((x - expected[0]).hypot(y - expected[1]) < 1e-12);
            }
            assert_eq!(arc.sweep > 0.0, sweep);
            assert_eq!(arc.sweep.abs() > std::f64::consts::PI, large);
        }
        // Radii that do not reach: half an ellipse.
        let small = ArcShape {
            radii: [0.1, 0.1],
            rotation: 0.0,
            large: false,
            sweep: true,
        };
        let half = arc([0.0, 0.0], small, [2.0, 0.0]).unwrap();
        assert!((half.sweep - std::f64::consts::PI).abs() < 1e-7, "{half:?}");
        // None of these hangs or panics.
        for radius in [f64::MIN_POSITIVE, 1e300] {
            for place in [1e-300, 1.0, 1e300] {
                let shape = ArcShape {
                    radii: [radius, 1.0],
                    ..small
                };
                let mut pen = Pen::new(Transform::IDENTITY, 1);
                pen.arc_to(shape, [place, place]);
                assert!(pen.count() <= 73);
            }
        }
    }
}
