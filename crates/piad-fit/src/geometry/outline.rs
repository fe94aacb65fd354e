//! The outline of a surface: closed curves in its parameters that bound it.

use std::ops::Range;

use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The part of the rectangle of parameters of a surface that it has.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Closed cubic B-splines in (u, v), with clamped knots; none if the surface has all of the rectangle. The surface is on
    /// their left. They can turn at knots of multiplicity 3.
    pub loops: Vec<Nurbs>,
    /// The pieces that it is in.
    pub faces: Vec<Face>,
    /// How far the outline can be from the data, in the unit of the points.
    pub distance: f64,
}

/// A piece of a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Face {
    /// The loop around it.
    pub outer: usize,
    /// Those of its holes.
    pub holes: Range<usize>,
}

impl Outline {
    /// Returns true if the surface has all of the rectangle.
    pub fn is_whole(&self) -> bool {
        self.loops.is_empty()
    }
}

impl Face {
    /// All loops; the first is the outer one.
    pub fn loops(&self) -> impl Iterator<Item = usize> + use<> {
        std::iter::once(self.outer).chain(self.holes.clone())
    }
}

/// Points along a plane curve: at all its knots, and with steps between them bounded by the control polygon, where both
/// coordinates are multiplied by their scales. The first point is repeated at the end.
pub(crate) fn polyline(curve: &Nurbs, scales: [f64; 2], step: f64) -> Vec<[f64; 2]> {
    let [x, y] = [0, 1].map(|axis| curve.points.lane(axis));
    let mut sites = Vec::new();
    for span in curve.u.spans() {
        let control = span - curve.u.degree + 1..=span;
        let length: f64 = control
            .map(|k| ((x[k] - x[k - 1]) * scales[0]).hypot((y[k] - y[k - 1]) * scales[1]))
            .sum();
        let steps = (length / step).ceil().clamp(1.0, MOST_STEPS);
        let parts = (0..steps as usize).map(|k| k as f64 / steps);
        sites.extend(parts.map(|part| curve.u.site(span, part)));
    }
    let jets = curve.evaluate(&sites, &[]);
    let points = jets.iter().chain(jets.first());
    points.map(|jet| [jet.point[0], jet.point[1]]).collect()
}

/// The most steps along a span.
const MOST_STEPS: f64 = 65_536.0;

impl Outline {
    /// All loops as polygons in (u, v) with steps of this part of the extents of the surface.
    pub fn polygons(&self, surface: &Nurbs, part: f64) -> Vec<Vec<[f64; 2]>> {
        let scale = |knots: &KnotVector| {
            let (low, high) = knots.domain();
            1.0 / (high - low)
        };
        let scales = [scale(&surface.u), surface.v.as_ref().map_or(1.0, scale)];
        let polygon = |curve| polyline(curve, scales, part);
        self.loops.iter().map(polygon).collect()
    }
}
