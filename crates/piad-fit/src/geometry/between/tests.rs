//! Random data with control points `auto`: converged fits stay near their data between them. The measure here is
//! independent of the fit's own, and at more places: the distance of the curve from the segment between neighbours.

use std::sync::Arc;

use crate::basis::Basis;
use crate::basis::choice::{BasisChoice, Corners, DirectionChoice};
use crate::basis::knots::Knots;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::geometry::evaluation::Geometry;
use crate::iteration::Iteration;
use crate::iteration::system::System;
use crate::method::{AS_MANY_AS_DATA, LeastSquares, Method};
use crate::parameters::Parametrization;
use crate::problem::Problem;
use crate::problem::request::{Request, Tolerance};
use crate::termination::Outcome;
use crate::termination::Reason;

/// The number of polylines to test, and four times the number of grids; `PIAD_TEST_ROUNDS` overrides it.
fn rounds() -> usize {
    let set = std::env::var("PIAD_TEST_ROUNDS");
    set.map_or(120, |rounds| {
        rounds.parse().expect("PIAD_TEST_ROUNDS is a number")
    })
}

/// Numbers that seem random (SplitMix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    fn part(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [-1, 1).
    fn signed(&mut self) -> f64 {
        2.0 * self.part() - 1.0
    }

    fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }
}

fn direction(closed: bool, parameters: Parametrization) -> DirectionChoice {
    DirectionChoice {
        closed,
        ..DirectionChoice::new(
            BasisChoice::BSpline {
                degree: 3,
                knots: Knots::Usual,
            },
            parameters,
        )
    }
}

/// The last level of a fit with as few control points as it needs.
fn fit(points: Points, grid: Grid, u: DirectionChoice, tolerance: f64) -> (Iteration, Outcome) {
    let automatic = LeastSquares::automatic(AS_MANY_AS_DATA, AS_MANY_AS_DATA);
    fit_by(Method::LeastSquares(automatic), points, grid, u, tolerance)
}

/// The last level of a fit.
fn fit_by(
    method: Method,
    points: Points,
    grid: Grid,
    u: DirectionChoice,
    tolerance: f64,
) -> (Iteration, Outcome) {
    let v = grid
        .is_rows()
        .then(|| direction(false, Parametrization::Uniform));
    let request = Request {
        method,
        tolerance: Some(Tolerance::Relative(tolerance)),
        max_iterations: 100_000,
        ..Request::new(points, grid, u, v)
    };
    let problem = Problem::new(request).unwrap();
    let mut fit = Iteration::start(Arc::new(System::new(Arc::new(problem))));
    while fit.outcome().is_none() {
        fit.step();
    }
    let outcome = fit.outcome().unwrap();
    (fit, outcome)
}

/// A random walk, points anywhere in a square, or a function; some points are near others.
fn polyline(random: &mut Random) -> Points {
    let count = 5 + random.below(55);
    let kind = random.below(3);
    let mut points = Points::new(2);
    let mut at = [0.0, 0.0];
    for i in 0..count {
        let step = 0.02_f64.powf(random.part());
        at = match kind {
            0 => [random.part(), random.part()],
            1 => [
                at[0] + step * random.signed(),
                at[1] + step * random.signed(),
            ],
            _ => [at[0] + step, random.signed()],
        };
        // No two are the same.
        points.push(&[at[0] + 1e-9 * i as f64, at[1]]);
    }
    points
}

/// The distance of a point from a segment.
fn from_segment([a, b]: [[f64; 2]; 2], x: [f64; 2]) -> f64 {
    let (chord, to) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
    let square = chord[0] * chord[0] + chord[1] * chord[1];
    let along = (chord[0] * to[0] + chord[1] * to[1]) / square.max(f64::MIN_POSITIVE);
    let s = along.clamp(0.0, 1.0);
    (to[0] - s * chord[0]).hypot(to[1] - s * chord[1])
}

/// By how much a curve leaves the segments between its data beyond their lengths.
fn excess(fit: &Iteration) -> f64 {
    let gaps = distances_from_segments(fit).into_iter();
    let excesses = gaps.map(|(distance, length)| distance - length);
    excesses.fold(f64::NEG_INFINITY, f64::max)
}

/// How far a curve is from each segment between its data, but for that back to the first one, and their lengths.
fn distances_from_segments(fit: &Iteration) -> Vec<(f64, f64)> {
    let problem = fit.problem();
    let (data, t) = (&problem.points, problem.u().explicit_parameters());
    let geometry = Geometry::new(problem, fit.control_points());
    let at = |points: &Points, i: usize| [points.lane(0)[i], points.lane(1)[i]];
    let gap = |(i, pair): (usize, &[f64])| {
        let next = (i + 1) % data.len();
        let ends = [at(data, i), at(data, next)];
        let parts = (1..24).map(|k| f64::from(k) / 24.0);
        let u: Vec<f64> = parts.map(|s| (1.0 - s) * pair[0] + s * pair[1]).collect();
        let curve = geometry.evaluate(&u, &[]);
        let distances = (0..u.len()).map(|k| from_segment(ends, at(&curve, k)));
        (distances.fold(0.0, f64::max), data.distance(i, next))
    };
    t.windows(2).enumerate().map(gap).collect()
}

/// Outlines of plates with rounded corners, and brackets with a fillet: edges with a point at both ends only, which bends
/// lead to, of which there are many points, are straight.
#[test]
fn long_edges_beside_bends_are_straight() {
    let arc = |[x, y]: [f64; 2], radius: f64, from: f64, to: f64, parts: usize| {
        let angle = move |k: usize| (from + (to - from) * k as f64 / parts as f64).to_radians();
        (0..=parts).map(move |k| [x + radius * angle(k).cos(), y + radius * angle(k).sin()])
    };
    for (radius, parts, tolerance) in [
        (10.0, 10, 1e-3),
        (10.0, 10, 1e-4),
        (5.0, 6, 1e-3),
        (5.0, 6, 1e-4),
        (2.0, 5, 1e-3),
    ] {
        let corners = [[40.0, 20.0], [-40.0, 20.0], [-40.0, -20.0], [40.0, -20.0]];
        let plate = corners.into_iter().zip([0.0, 90.0, 180.0, 270.0]);
        let plate = plate.flat_map(|(at, angle)| arc(at, radius, angle, angle + 90.0, parts));
        let start = [[0.0, 0.0], [80.0, 0.0], [80.0, 20.0]];
        let fillet = arc([30.0, 30.0], radius, 270.0, 180.0, parts);
        let top = 60.0;
        let end = [[30.0 - radius, top], [0.0, top], [0.0, 0.0]];
        let shift = |[x, y]: [f64; 2]| [x, y + 10.0 - radius];
        let bracket = start.into_iter().chain(fillet.map(shift)).chain(end);
        let outlines = [
            (plate.collect::<Vec<_>>(), true, None),
            (bracket.collect(), false, Some(Corners::Found(30.0))),
        ];
        for (outline, closed, corners) in outlines {
            let points = Points::from_flat(2, &outline.concat());
            let (count, size) = (points.len(), points.bounding_diagonal());
            let grid = Grid {
                rows: count,
                columns: 1,
            };
            let choice = DirectionChoice {
                corners,
                ..direction(closed, Parametrization::ChordLength)
            };
            let (fit, outcome) = fit(points, grid, choice, tolerance);
            let farthest = distances_from_segments(&fit).into_iter();
            let farthest = farthest.map(|it| it.0).fold(0.0, f64::max);
            // An arc is that far from its own edges.
            let sagitta = radius * (1.0 - (45.0 / parts as f64).to_radians().cos());
            assert_eq!(outcome, Outcome::Converged);
            assert!(
                farthest <= sagitta + 3.0 * tolerance * size,
                "radius {radius}, {parts} parts, closed {closed}, {tolerance}: {farthest}"
            );
        }
    }
}

#[test]
fn no_polyline_is_left_between_its_points() {
    let mut random = Random(1);
    let (mut converged, mut between, mut control_points, mut points) = (0, 0, 0, 0);
    for round in 0..rounds() {
        let data = polyline(&mut random);
        let closed = random.below(4) == 0;
        let tolerance = [1e-2, 1e-3][random.below(2)];
        let (count, diagonal) = (data.len(), data.bounding_diagonal());
        let grid = Grid {
            rows: count,
            columns: 1,
        };
        let choice = direction(closed, Parametrization::ChordLength);
        let (fit, outcome) = fit(data, grid, choice, tolerance);
        match outcome {
            Outcome::Converged => {
                converged += 1;
                control_points += fit.control_points().len();
                points += count;
                let excess = excess(&fit);
                assert!(
                    excess <= tolerance * diagonal,
                    "polyline {round} of {count} points, closed {closed}, {tolerance}: {excess:e} of {diagonal}"
                );
            }
            Outcome::Stalled(Reason::Between) => between += 1,
            other => panic!("polyline {round} of {count} points: {other:?}"),
        }
    }
    // Corners take more control points than data; the aim is 1.4 of them.
    assert!(
        10 * control_points <= 14 * points,
        "{control_points} for {points} of {converged}"
    );
    assert!(
        20 * between <= rounds(),
        "{between} of {} are given up",
        rounds()
    );
}

/// Splines through points without any smoothness, by any parameters but uniform ones of uneven points, and of heights
/// at equal steps: what they do between the points is what these leave free.
#[test]
fn interpolated_points_are_not_left() {
    let mut random = Random(3);
    let (mut left, mut total) = (0, 0);
    for _ in 0..rounds() {
        let (points, parameters) = match random.below(4) {
            0 => (polyline(&mut random), Parametrization::ChordLength),
            1 => (polyline(&mut random), Parametrization::Centripetal),
            2 => {
                let heights: Vec<f64> = (0..30).map(|_| random.signed()).collect();
                (Points::from_lanes([heights]), Parametrization::Uniform)
            }
            _ => {
                let step = 2 + random.below(26);
                let heights: Vec<f64> = (0..30).map(|i| f64::from(u8::from(i >= step))).collect();
                (Points::from_lanes([heights]), Parametrization::Uniform)
            }
        };
        let grid = Grid {
            rows: points.len(),
            columns: 1,
        };
        let direction = direction(false, parameters);
        let (_, outcome) = fit_by(Method::Direct, points, grid, direction, 1e-9);
        total += 1;
        left += usize::from(outcome != Outcome::Converged);
    }
    assert!(50 * left <= total, "{left} of {total}");
}

/// The bilinear patch of a grid of heights at parts of its length and width, and how far the points of its cell, and of
/// the cells around it, are apart.
fn neighbours(heights: &[f64], grid: Grid, at: [f64; 2]) -> (f64, f64) {
    let Grid { rows, columns } = grid;
    let cell = |part: f64, count: usize| {
        let place = part * (count - 1) as f64;
        let index = (place as usize).min(count - 2);
        (index, place - index as f64)
    };
    let ((i, s), (j, t)) = (cell(at[0], rows), cell(at[1], columns));
    let height = |i: usize, j: usize| heights[i * columns + j];
    let line = |i: usize| (1.0 - t) * height(i, j) + t * height(i, j + 1);
    let near = |index: usize, count: usize| index.saturating_sub(1)..(index + 3).min(count);
    let around = near(i, rows).flat_map(|i| near(j, columns).map(move |j| (i, j)));
    let around: Vec<f64> = around.map(|(i, j)| height(i, j)).collect();
    let highest = around.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = around.iter().copied().fold(f64::INFINITY, f64::min);
    ((1.0 - s) * line(i) + s * line(i + 1), highest - lowest)
}

#[test]
fn no_grid_is_left_between_its_points() {
    let mut random = Random(2);
    let (mut converged, mut between, mut others) = (0, 0, 0);
    for round in 0..rounds() / 4 {
        let [rows, columns] = [0, 1].map(|_| 4 + random.below(27));
        let roughness = random.part().powi(2);
        let mut points = Points::new(1);
        for k in 0..rows * columns {
            let [x, y] = [k / columns, k % columns].map(|i| i as f64 / 5.0);
            points.push(&[
                (1.0 - roughness) * (x.sin() + (y + x).cos()) + roughness * random.signed()
            ]);
        }
        let extents = points.extents();
        let tolerance = [0.3, 1e-1, 1e-2, 1e-3][random.below(4)];
        let grid = Grid { rows, columns };
        let uniform = direction(false, Parametrization::Uniform);
        let (fit, outcome) = fit(points, grid, uniform, tolerance);
        let problem = fit.problem();
        let counts = problem.control_grid();
        assert!(
            counts.rows <= rows && counts.columns <= columns,
            "{counts:?} for {grid:?}"
        );
        match outcome {
            Outcome::Converged => {
                converged += 1;
                let range = extents[0].high - extents[0].low;
                let places =
                    |count: usize| (0..=8 * count).map(move |k| k as f64 / (8 * count) as f64);
                let of = |basis: &Basis, count: usize| {
                    let (low, high) = basis.domain();
                    let t = places(count).map(|s| low + s * (high - low));
                    t.collect::<Vec<f64>>()
                };
                let u = of(&problem.u().basis, rows);
                let v = of(&problem.v().unwrap().basis, columns);
                let surface = Geometry::new(problem, fit.control_points()).evaluate(&u, &v);
                let data = problem.data().lane(0);
                let all = places(rows).flat_map(|s| places(columns).map(move |t| [s, t]));
                for (at, z) in all.zip(surface.lane(0)) {
                    let (between, apart) = neighbours(data, grid, at);
                    let off = (z - between).abs();
                    assert!(
                        off <= apart + problem.tolerance(),
                        "grid {round}, {grid:?}, {tolerance}, roughness {roughness}: {off} from points {apart} apart"
                    );
                    let beyond = (extents[0].low - z).max(z - extents[0].high);
                    assert!(beyond <= range, "grid {round}: {beyond} beyond {range}");
                }
            }
            Outcome::Stalled(Reason::Between) => between += 1,
            _ => others += 1,
        }
    }
    assert!(
        10 * (between + others) <= rounds() / 4,
        "{converged} converged, {between} and {others} are given up"
    );
}
