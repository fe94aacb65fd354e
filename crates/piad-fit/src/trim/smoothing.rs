//! Polygons around cells as closed cubic B-splines near them.
//!
//! Between corners a polygon becomes the fit with the fewest control points within half a cell of its vertices; along sides
//! of the rectangle it stays straight. Where loops would cross, they come nearer to their polygons.

use std::sync::Arc;

use super::boundary::Vertex;
use super::crossing;
use crate::basis::choice::{BasisChoice, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::geometry::nurbs::{KnotVector, Nurbs};
use crate::iteration::Iteration;
use crate::iteration::system::System;
use crate::method::{AS_MANY_AS_DATA, LeastSquares, Method};
use crate::parameters::Parametrization;
use crate::problem::Problem;
use crate::problem::request::{Request, Tolerance};
use crate::termination::Outcome;

const DEGREE: usize = 3;

/// How near loops are to the vertices of their polygons, in cells: each where those before let them cross. The last ones are
/// the polygons themselves.
const TOLERANCES: [f64; 4] = [0.4, 0.2, 0.1, 0.0];

/// The fewest vertices that are fitted: fewer are joined by straight lines.
const FEWEST: usize = 5;

/// Closed curves near these polygons that neither cross nor leave the range of each coordinate.
pub(super) fn smooth(polygons: &[Vec<Vertex>], range: [[f64; 2]; 2]) -> Vec<Nurbs> {
    let looped = |polygon: &Vec<Vertex>, attempt: usize| {
        let mut pieces = pieces(polygon, TOLERANCES[attempt]);
        for piece in &mut pieces {
            piece.keep_within(range);
            piece.divide();
        }
        joined(pieces)
    };
    let mut attempts = vec![0; polygons.len()];
    let mut loops: Vec<Nurbs> = polygons.iter().map(|it| looped(it, 0)).collect();
    for _ in 1..TOLERANCES.len() {
        let crossing = crossing::crossing(&loops);
        if crossing.is_empty() {
            break;
        }
        for index in crossing {
            attempts[index] += 1;
            loops[index] = looped(&polygons[index], attempts[index]);
        }
    }
    // One that came nearer may cross another one that did not.
    if !crossing::crossing(&loops).is_empty() {
        let last = TOLERANCES.len() - 1;
        loops = polygons.iter().map(|it| looped(it, last)).collect();
    }
    loops
}

/// A clamped cubic piece of a loop.
#[derive(Clone, Debug)]
struct Piece {
    /// From 0 to its length.
    knots: Vec<f64>,
    points: Vec<[f64; 2]>,
}

impl Piece {
    /// Moves the control points into the range of each coordinate. Near those outside there are more of them first, which are
    /// nearer to the curve.
    fn keep_within(&mut self, range: [[f64; 2]; 2]) {
        let inside =
            |point: &[f64; 2]| [0, 1].map(|axis| point[axis].clamp(range[axis][0], range[axis][1]));
        for _ in 0..REFINEMENTS {
            let is_outside = |k: usize| inside(&self.points[k]) != self.points[k];
            let spans = (DEGREE..self.points.len()).filter(|&span| {
                let is_long = self.knots[span + 1] - self.knots[span] > SHORTEST;
                is_long && (span - DEGREE..=span).any(is_outside)
            });
            let middle = |span: usize| 0.5 * (self.knots[span] + self.knots[span + 1]);
            let middles: Vec<f64> = spans.map(middle).collect();
            for knot in middles {
                insert(knot, &mut self.knots, &mut self.points);
            }
        }
        self.points.iter_mut().for_each(|it| *it = inside(it));
    }

    /// Gives some knots multiplicity 3, so that each part between them has few spans. The curve stays the same.
    fn divide(&mut self) {
        let mut breaks = self.knots.clone();
        breaks.dedup();
        let spans = breaks.len() - 1;
        let parts = spans.div_ceil(SPANS);
        for knot in (1..parts).map(|part| breaks[part * spans / parts]) {
            while self.knots.iter().filter(|it| **it == knot).count() < DEGREE {
                insert(knot, &mut self.knots, &mut self.points);
            }
        }
    }
}

/// The most spans of a curve between two knots of multiplicity 3: kernels integrate along an edge as a whole.
const SPANS: usize = 8;

/// How often spans are halved, and the length in cells below which they are not.
const REFINEMENTS: usize = 4;
const SHORTEST: f64 = 1.0;

/// The pieces of a polygon between its corners, or all of it.
fn pieces(polygon: &[Vertex], tolerance: f64) -> Vec<Piece> {
    let around: Vec<[f64; 2]> = polygon
        .iter()
        .chain(&polygon[..1])
        .map(|it| it.at)
        .collect();
    let corners = (0..polygon.len()).filter(|&k| polygon[k].is_corner);
    let mut ends: Vec<usize> = corners.collect();
    if ends.is_empty() {
        return match fitted(&around[..polygon.len()], true, tolerance) {
            Some(piece) => vec![piece],
            None => straight(&around),
        };
    }
    ends.push(polygon.len());
    let between = ends.windows(2).flat_map(|pair| {
        let points = &around[pair[0]..=pair[1]];
        match fitted(points, false, tolerance) {
            Some(piece) => vec![piece],
            None => straight(points),
        }
    });
    between.collect()
}

/// The straight lines between these points.
fn straight(points: &[[f64; 2]]) -> Vec<Piece> {
    let line = |pair: &[[f64; 2]]| {
        let [from, to] = [pair[0], pair[1]];
        let at = |part: f64| [0, 1].map(|axis| (1.0 - part) * from[axis] + part * to[axis]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        Piece {
            knots: [[0.0; DEGREE + 1], [length; DEGREE + 1]].concat(),
            points: vec![from, at(1.0 / 3.0), at(2.0 / 3.0), to],
        }
    };
    points.windows(2).map(line).collect()
}

/// The fit with the fewest control points within a tolerance of points.
fn fitted(points: &[[f64; 2]], is_closed: bool, tolerance: f64) -> Option<Piece> {
    if tolerance == 0.0 || points.len() < FEWEST {
        return None;
    }
    let rows = points.len();
    let basis = BasisChoice::BSpline {
        degree: DEGREE,
        knots: Knots::Usual,
    };
    let u = DirectionChoice {
        closed: is_closed,
        ..DirectionChoice::new(basis, Parametrization::ChordLength)
    };
    let fewest = LeastSquares::automatic(AS_MANY_AS_DATA, AS_MANY_AS_DATA);
    let data = Points::from_flat(2, points.as_flattened());
    let request = Request {
        method: Method::LeastSquares(fewest),
        tolerance: Some(Tolerance::Absolute(tolerance)),
        ..Request::new(data, Grid { rows, columns: 1 }, u, None)
    };
    let problem = Arc::new(Problem::new(request).ok()?);
    let mut iteration = Iteration::start(Arc::new(System::new(problem)));
    while iteration.outcome().is_none() {
        iteration.step();
    }
    let is_near = matches!(
        iteration.outcome(),
        Some(Outcome::Converged | Outcome::Minimum)
    );
    let nurbs = Nurbs::of(iteration.problem(), &iteration.shared_control_points());
    let is_near = is_near && nurbs.bad_coordinate().is_none();
    is_near.then(|| clamped(&nurbs, points))
}

/// A fit as a piece, as long as the polygon through its points.
fn clamped(nurbs: &Nurbs, points: &[[f64; 2]]) -> Piece {
    let mut knots = nurbs.u.knots.clone();
    let place = |k: usize| [nurbs.points.lane(0)[k], nurbs.points.lane(1)[k]];
    let mut net: Vec<[f64; 2]> = (0..nurbs.points.len()).map(place).collect();
    let (low, high) = nurbs.u.domain();
    if nurbs.u.is_periodic() {
        for end in [low, high] {
            while knots.iter().filter(|knot| **knot == end).count() < DEGREE {
                insert(end, &mut knots, &mut net);
            }
        }
        let first = knots.iter().position(|knot| *knot == low).unwrap_or(0);
        let past = knots.iter().rposition(|knot| *knot == high).unwrap_or(0) + 1;
        knots = knots[first..past].to_vec();
        net = net[first - 1..past - DEGREE].to_vec();
        knots.insert(0, low);
        knots.push(high);
        // They are one but for rounding.
        if let [from, .., to] = &mut net[..] {
            *to = *from;
        }
    } else if let ([from, .., to], [first, .., last]) = (&mut net[..], points) {
        (*from, *to) = (*first, *last);
    }
    let length: f64 = points
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
        .sum();
    for knot in &mut knots {
        *knot = (*knot - low) / (high - low) * length;
    }
    Piece { knots, points: net }
}

/// Inserts a knot (Boehm 1980).
fn insert(t: f64, knots: &mut Vec<f64>, net: &mut Vec<[f64; 2]>) {
    // The last span that begins at or before the knot.
    let span = knots.partition_point(|knot| *knot <= t) - 1;
    let span = span.min(net.len() - 1);
    let mut moved = Vec::with_capacity(DEGREE);
    for i in span + 1 - DEGREE..=span {
        let width = knots[i + DEGREE] - knots[i];
        let part = if width > 0.0 {
            (t - knots[i]) / width
        } else {
            0.0
        };
        let (before, after) = (net[i - 1], net[i]);
        moved.push([0, 1].map(|axis| (1.0 - part) * before[axis] + part * after[axis]));
    }
    net.splice(span + 1 - DEGREE..span, moved);
    knots.insert(span + 1, t);
}

/// The closed curve of pieces that follow each other.
fn joined(pieces: Vec<Piece>) -> Nurbs {
    let mut knots = vec![0.0; DEGREE + 1];
    let mut points = Points::new(2);
    let first = pieces.first().and_then(|it| it.points.first()).copied();
    let mut start = 0.0;
    for piece in &pieces {
        let count = piece.points.len();
        piece.points[..count - 1]
            .iter()
            .for_each(|it| points.push(it));
        let end = start + piece.knots[count];
        let inner = &piece.knots[DEGREE + 1..count];
        knots.extend(inner.iter().map(|knot| start + knot));
        knots.extend([end; DEGREE]);
        start = end;
    }
    points.push(&first.unwrap_or_default());
    knots.push(start);
    Nurbs {
        u: KnotVector {
            degree: DEGREE,
            knots,
            closed: true,
        },
        v: None,
        points,
        weights: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: usize) -> Vec<[f64; 2]> {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
        let point = |k| [20.0 * f64::cos(angle(k)), 20.0 * f64::sin(angle(k))];
        (0..count).map(point).collect()
    }

    /// The closed curve of a circle is the same once its knots are clamped.
    #[test]
    fn clamped_knots_give_the_same_curve() {
        let points = ring(100);
        let piece = fitted(&points, true, 0.05).unwrap();
        assert!(piece.points.len() < 20);
        let curve = joined(vec![piece]);
        assert_eq!(curve.u.knots.len(), curve.points.len() + DEGREE + 1);
        assert!(!curve.u.is_periodic());
        for site in curve.u.sites(200) {
            let [x, y, _] = curve.evaluate(&[site], &[])[0].point;
            assert!((x.hypot(y) - 20.0).abs() < 0.06, "{x} {y}");
        }
        let (low, high) = curve.u.domain();
        let ends = [low, high].map(|t| curve.evaluate(&[curve.u.site_at(t)], &[])[0]);
        assert!((ends[0].du[1] - ends[1].du[1]).abs() < 1e-9);
        assert!((ends[0].du[0] - ends[1].du[0]).abs() < 1e-9);
    }

    #[test]
    fn corners_stay_and_lines_between_them_are_straight() {
        let vertex = |at, is_corner| Vertex { at, is_corner };
        let mut polygon = vec![
            vertex([0.0, 0.0], true),
            vertex([20.0, 0.0], true),
            vertex([20.0, 10.0], true),
        ];
        polygon.extend((1..40).map(|k| {
            let x = 20.0 - 0.5 * f64::from(k);
            vertex([x, 10.0 + f64::from(k % 2) * 0.5], false)
        }));
        polygon.push(vertex([0.0, 10.0], true));
        let curve = &smooth(&[polygon], [[0.0, 20.0], [0.0, 10.5]])[0];
        let triple = curve.u.multiplicities();
        assert_eq!(triple.iter().filter(|(_, times)| *times == 3).count(), 3);
        assert!(
            curve
                .points
                .lane(0)
                .iter()
                .all(|x| (0.0..=20.0).contains(x))
        );
        assert!(
            curve
                .points
                .lane(1)
                .iter()
                .all(|y| (0.0..=10.5).contains(y))
        );
        assert!(curve.points.len() < 20);
    }
}
