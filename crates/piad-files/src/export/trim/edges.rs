//! The edges of a trimmed surface: curves in its parameters, and curves of space that are on it.
//!
//! A loop is divided where it turns. The curve of space of an edge has the same parameter as that in (u, v): a cubic with the
//! places and derivatives of the surface at its breaks, which are as near to each other as a tolerance needs.

use super::super::nurbs::{KnotVector, Nurbs};
use piad_fit::data::Points;
use piad_fit::engine::vectors::{length, minus};
use piad_fit::geometry::Outline;

/// The largest distance of edges from the surface, as a part of its extent.
const TOLERANCE: f64 = 1e-6;

/// The most pieces in which a span of an edge is divided.
const MOST_PIECES: usize = 1 << 10;

/// Where in a piece its distance from the surface is measured.
const MEASURED: [f64; 3] = [0.25, 0.5, 0.75];

/// An edge of a trimmed surface, from a vertex to the next.
#[derive(Clone, Debug)]
pub(in super::super) struct Edge {
    /// The curve in (u, v).
    pub in_plane: Nurbs,
    /// The curve in space.
    pub in_space: Nurbs,
}

/// The largest distance of edges from a surface.
pub(in super::super) fn tolerance(surface: &Nurbs) -> f64 {
    let extent = TOLERANCE * surface.points.bounding_diagonal();
    extent.max(surface.resolution())
}

/// The edges of each loop. Those that are points of space, as they are at a pole, are not there.
pub(in super::super) fn of_loops(surface: &Nurbs, outline: &Outline) -> Vec<Vec<Edge>> {
    let tolerance = tolerance(surface);
    let is_long = |it: &Edge| it.in_space.points.bounding_diagonal() > 10.0 * tolerance;
    let edges = |curve: &Nurbs| {
        let edges = pieces(curve).into_iter().map(|in_plane| Edge {
            in_space: on_surface(surface, &in_plane, tolerance),
            in_plane,
        });
        edges.filter(is_long).collect()
    };
    outline.loops.iter().map(edges).collect()
}

/// The number of edges of each loop, including those that are points of space.
pub(in super::super) fn counts(outline: &Outline) -> Vec<usize> {
    let loops = outline.loops.iter();
    loops.map(|curve| pieces(curve).len()).collect()
}

/// The pieces of a clamped curve between the knots at which it turns.
fn pieces(curve: &Nurbs) -> Vec<Nurbs> {
    let degree = curve.u.degree;
    let mut pieces = Vec::new();
    // The indices of the last knot of each break.
    let (mut last, mut at) = (degree, degree);
    for (knot, times) in curve.u.multiplicities().into_iter().skip(1) {
        at += times;
        if times < degree {
            continue;
        }
        let first = last - degree;
        // The control point at the break.
        let end = at.min(curve.points.len() + degree) - degree;
        let end = if times > degree {
            curve.points.len() - 1
        } else {
            end
        };
        let mut knots = vec![curve.u.knots[last]; degree + 1];
        knots.extend(&curve.u.knots[last + 1..=at - times]);
        knots.extend(vec![knot; degree + 1]);
        pieces.push(Nurbs {
            u: KnotVector {
                degree,
                knots,
                closed: false,
            },
            v: None,
            points: selected(&curve.points, first..=end),
            weights: None,
        });
        last = at;
    }
    pieces
}

fn selected(points: &Points, indices: std::ops::RangeInclusive<usize>) -> Points {
    let lanes = points.lanes().iter();
    Points::from_lanes(lanes.map(|lane| lane[indices.clone()].to_vec()))
}

/// A place on the surface and its derivative along a curve.
struct Moving {
    point: [f64; 3],
    derivative: [f64; 3],
}

fn moving(surface: &Nurbs, curve: &Nurbs, span: usize, part: f64) -> Moving {
    let on_curve = curve.evaluate(&[curve.u.site(span, part)], &[]);
    let ([u, v, _], [du, dv, _]) = on_curve
        .first()
        .map(|it| (it.point, it.du))
        .unwrap_or_default();
    let across = surface.v.iter().map(|knots| knots.site_at(v));
    let jets = surface.evaluate(&[surface.u.site_at(u)], &across.collect::<Vec<_>>());
    let jet = jets.into_iter().next().unwrap_or_default();
    Moving {
        point: jet.point,
        derivative: [0, 1, 2].map(|c| jet.du[c] * du + jet.dv[c] * dv),
    }
}

/// The curve of space along a curve of the parameters.
fn on_surface(surface: &Nurbs, curve: &Nurbs, tolerance: f64) -> Nurbs {
    let mut knots = vec![curve.u.domain().0; 4];
    let mut points = Points::new(3);
    for span in curve.u.spans() {
        let breaks = breaks(surface, curve, span, tolerance);
        let width = curve.u.knots[span + 1] - curve.u.knots[span];
        let step = width / (breaks.len() - 1) as f64;
        if points.is_empty() {
            points.push(&breaks[0].point);
        }
        for (k, pair) in breaks.windows(2).enumerate() {
            let [_, near, far, _] = control(pair, step);
            points.push(&near);
            points.push(&far);
            let end = curve
                .u
                .site(span, (k + 1) as f64 / (breaks.len() - 1) as f64);
            knots.extend([end.t; 2]);
        }
        if let Some(last) = breaks.last().filter(|_| span + 1 == curve.u.count()) {
            points.push(&last.point);
        }
    }
    knots.extend([curve.u.domain().1; 2]);
    Nurbs {
        u: KnotVector {
            degree: 3,
            knots,
            closed: false,
        },
        v: None,
        points,
        weights: None,
    }
}

/// Equally many steps of a span, as few as the tolerance needs.
fn breaks(surface: &Nurbs, curve: &Nurbs, span: usize, tolerance: f64) -> Vec<Moving> {
    let width = curve.u.knots[span + 1] - curve.u.knots[span];
    let mut pieces = 1;
    loop {
        let at = |part: f64| moving(surface, curve, span, part / pieces as f64);
        let breaks: Vec<Moving> = (0..=pieces).map(|k| at(k as f64)).collect();
        let is_near = breaks.windows(2).enumerate().all(|(k, pair)| {
            let control = control(pair, width / pieces as f64);
            MEASURED.iter().all(|&part| {
                let exact = at(k as f64 + part).point;
                length(minus(cubic(&control, part), exact)) <= tolerance
            })
        });
        if is_near || pieces >= MOST_PIECES {
            return breaks;
        }
        pieces *= 2;
    }
}

/// The Bézier points of the cubic between two breaks.
fn control(pair: &[Moving], step: f64) -> [[f64; 3]; 4] {
    let [from, to] = [&pair[0], &pair[1]];
    let moved = |it: &Moving, by: f64| [0, 1, 2].map(|c| it.point[c] + by * it.derivative[c]);
    [
        from.point,
        moved(from, step / 3.0),
        moved(to, -step / 3.0),
        to.point,
    ]
}

fn cubic(control: &[[f64; 3]; 4], part: f64) -> [f64; 3] {
    let rest = 1.0 - part;
    let values = [
        rest * rest * rest,
        3.0 * part * rest * rest,
        3.0 * part * part * rest,
        part * part * part,
    ];
    [0, 1, 2].map(|c| (0..4).map(|k| values[k] * control[k][c]).sum())
}
