//! Areas of surfaces.
//!
//! The area is the integral of |S_u × S_v|, by the Gauss–Legendre rule with five nodes in each direction on each
//! rectangle between knots, in quarters until it is accurate.

use crate::data::vectors::{cross, length};
use crate::geometry::arc_length::{NODES, WEIGHTS};
use crate::geometry::nurbs::sampling::SpanParameter;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The difference of a rectangle from its quarters, as a part of the whole area, with which it is accepted.
const ACCURACY: f64 = 1e-12;

/// The most rectangles whose quarters are computed for certain: those of more are small.
const MOST_QUARTERED: usize = 1 << 14;

/// The most rectangles that are divided further.
const MOST_DIVISIONS: usize = 1 << 13;

/// How often a side is halved, at places where the surface is not regular.
const MOST_HALVINGS: u32 = 12;

/// A part of a knot span.
#[derive(Clone, Copy, Debug)]
struct Side {
    span: usize,
    low: f64,
    high: f64,
}

impl Side {
    fn all(knots: &KnotVector) -> Vec<Self> {
        let side = |span: usize| Self {
            span,
            low: knots.knots[span],
            high: knots.knots[span + 1],
        };
        knots.spans().into_iter().map(side).collect()
    }

    fn halves(self) -> [Self; 2] {
        let middle = 0.5 * (self.low + self.high);
        let first = Self {
            high: middle,
            ..self
        };
        let second = Self {
            low: middle,
            ..self
        };
        [first, second]
    }

    fn width(self) -> f64 {
        self.high - self.low
    }

    fn sites(self) -> [SpanParameter; 5] {
        NODES.map(|node| SpanParameter::new(self.span, self.low + node * self.width()))
    }
}

/// A rectangle that may be divided, with its area by the rule.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    u: Side,
    v: Side,
    area: f64,
    halvings: u32,
}

/// The area of a surface with these knots in its second direction; NaN if numbers overflow.
pub(crate) fn area(nurbs: &Nurbs, across: &KnotVector) -> f64 {
    let (u, v) = (Side::all(&nurbs.u), Side::all(across));
    let rows = u.iter().map(|&u| (u, strip(nurbs, u, &v)));
    let rows: Vec<(Side, Vec<f64>)> = rows.collect();
    let rough: f64 = rows.iter().flat_map(|(_, areas)| areas).sum();
    if u.len() * v.len() > MOST_QUARTERED {
        return rough;
    }
    // Far from the origin rounding is more than that.
    let rounding = f64::EPSILON * nurbs.points.magnitude() * nurbs.points.bounding_diagonal();
    let tolerance = (ACCURACY * rough).max(rounding);
    let mut waiting = rows.into_iter().flat_map(|(u, areas)| {
        let each = v.iter().zip(areas);
        let each = each.map(move |(&v, area)| Rectangle {
            u,
            v,
            area,
            halvings: 0,
        });
        each.collect::<Vec<_>>()
    });
    let (mut total, mut divisions) = (0.0, 0);
    let mut divided: Vec<Rectangle> = Vec::new();
    while let Some(rectangle) = divided.pop().or_else(|| waiting.next()) {
        let quarters = quarters(nurbs, rectangle);
        let sum: f64 = quarters.iter().map(|quarter| quarter.area).sum();
        let is_rough = (sum - rectangle.area).abs() > tolerance;
        if is_rough && rectangle.halvings < MOST_HALVINGS && divisions < MOST_DIVISIONS {
            divisions += 1;
            divided.extend(quarters);
        } else {
            total += sum;
        }
    }
    total
}

fn quarters(nurbs: &Nurbs, rectangle: Rectangle) -> Vec<Rectangle> {
    let v = rectangle.v.halves();
    let strips = rectangle.u.halves().map(|u| (u, strip(nurbs, u, &v)));
    let quarters = strips.into_iter().flat_map(|(u, areas)| {
        v.into_iter().zip(areas).map(move |(v, area)| Rectangle {
            u,
            v,
            area,
            halvings: rectangle.halvings + 1,
        })
    });
    quarters.collect()
}

/// The areas of rectangles beside each other, by the rule.
fn strip(nurbs: &Nurbs, u: Side, v: &[Side]) -> Vec<f64> {
    let across: Vec<SpanParameter> = v.iter().flat_map(|side| side.sites()).collect();
    let jets = nurbs.second_jets(0, &u.sites(), &across);
    let mut areas = vec![0.0; v.len()];
    for (row, along) in jets.chunks_exact(across.len()).zip(WEIGHTS) {
        let cells = row.chunks_exact(NODES.len());
        for ((area, cell), side) in areas.iter_mut().zip(cells).zip(v) {
            let weighted = cell.iter().zip(WEIGHTS);
            let sum: f64 = weighted
                .map(|(jet, weight)| weight * length(cross(jet.jet.du, jet.jet.dv)))
                .sum();
            *area += along * sum * u.width() * side.width();
        }
    }
    areas
}
