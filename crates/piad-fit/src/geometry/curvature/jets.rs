//! The curvature of a curve in any number of dimensions.
//!
//! With the unit tangent T = C' / |C'|, the curvature vector is the part of the second derivative across it,
//! `(C'' − (C'' · T) T) / |C'|²`, and its length the curvature. It equals `√(|C'|² |C''|² − (C' · C'')²) / |C'|³`,
//! without the cancellation. In the plane curvature has a sign: it is positive where the curve turns left.

use super::degenerate::Vanishing;
use crate::data::vectors::{dot, minus};
use crate::geometry::nurbs::Nurbs;
use crate::geometry::nurbs::derivatives::SecondJet;
use crate::geometry::nurbs::sampling::SpanParameter;

/// Coordinates that are evaluated at a time.
const TOGETHER: usize = 3;

/// A curve at several parameters: points, derivatives and curvature.
#[derive(Debug)]
pub(super) struct CurveJets {
    dimension: usize,
    /// Three coordinates of all points in each.
    parts: Vec<Vec<SecondJet>>,
    /// The lengths of the first derivatives; NaN where they vanish.
    speeds: Vec<f64>,
}

impl CurveJets {
    /// A curve at these parameters.
    pub(super) fn new(nurbs: &Nurbs, vanishing: &Vanishing, sites: &[SpanParameter]) -> Self {
        let dimension = nurbs.points.dimension();
        let parts = (0..dimension).step_by(TOGETHER);
        let parts: Vec<_> = parts
            .map(|first| nurbs.second_jets(first, sites, &[]))
            .collect();
        let speed = |(i, site): (usize, &SpanParameter)| {
            let speed = norm(parts.iter().map(|part| part[i].jet.du));
            match speed > vanishing.limit(*site) && speed.is_finite() {
                true => speed,
                false => f64::NAN,
            }
        };
        Self {
            dimension,
            speeds: sites.iter().enumerate().map(speed).collect(),
            parts,
        }
    }

    /// The coordinates of a point.
    pub(super) fn point(&self, i: usize) -> impl Iterator<Item = f64> {
        let points = self.parts.iter().flat_map(move |part| part[i].jet.point);
        points.take(self.dimension)
    }

    /// The curvature; NaN where the derivative vanishes.
    pub(super) fn curvature(&self, i: usize) -> f64 {
        let speed = self.speeds[i];
        match (self.dimension, self.parts.first()) {
            (2, Some(plane)) => {
                let [x, y, _] = plane[i].jet.du.map(|x| x / speed);
                let [xx, yy, _] = plane[i].duu.map(|x| x / speed / speed);
                x * yy - y * xx
            }
            _ => norm(self.bend(i).into_iter()),
        }
    }

    /// The curvature vector, three coordinates at a time.
    pub(super) fn bend(&self, i: usize) -> Vec<[f64; 3]> {
        let speed = self.speeds[i];
        let tangent = self.tangent(i);
        let seconds = self.parts.iter().map(|part| part[i].duu);
        let pairs = tangent.iter().zip(seconds.clone());
        let along: f64 = pairs.map(|(t, second)| dot(*t, second)).sum();
        let across = tangent.iter().zip(seconds).map(|(t, second)| {
            let across = minus(second, t.map(|x| along * x));
            across.map(|x| x / speed / speed)
        });
        across.collect()
    }

    fn tangent(&self, i: usize) -> Vec<[f64; 3]> {
        let speed = self.speeds[i];
        let firsts = self.parts.iter().map(|part| part[i].jet.du);
        firsts.map(|du| du.map(|x| x / speed)).collect()
    }

    /// The angle between the tangents at two parameters, in radians; NaN where one vanishes.
    pub(super) fn angle(&self, i: usize, j: usize) -> f64 {
        angle(&self.tangent(i), &self.tangent(j))
    }

    /// The distance between two points.
    pub(super) fn gap(&self, i: usize, j: usize) -> f64 {
        self.difference(i, j, |jet| jet.jet.point)
    }

    /// How long the difference of two first derivatives is, as a part of the longer one.
    pub(super) fn first_jump(&self, i: usize, j: usize) -> f64 {
        self.relative(i, j, |jet| jet.jet.du)
    }

    /// The same of second derivatives.
    pub(super) fn second_jump(&self, i: usize, j: usize) -> f64 {
        self.relative(i, j, |jet| jet.duu)
    }

    /// The length of the difference of two curvature vectors; NaN where one does not exist.
    pub(super) fn bend_jump(&self, i: usize, j: usize) -> f64 {
        let bends = self.bend(i).into_iter().zip(self.bend(j));
        norm(bends.map(|(a, b)| minus(a, b)))
    }

    fn relative(&self, i: usize, j: usize, of: impl Fn(&SecondJet) -> [f64; 3]) -> f64 {
        let length = |i: usize| norm(self.parts.iter().map(|part| of(&part[i])));
        match length(i).max(length(j)) {
            0.0 => 0.0,
            longer => self.difference(i, j, &of) / longer,
        }
    }

    fn difference(&self, i: usize, j: usize, of: impl Fn(&SecondJet) -> [f64; 3]) -> f64 {
        let parts = self.parts.iter();
        norm(parts.map(|part| minus(of(&part[i]), of(&part[j]))))
    }
}

/// The angle between unit vectors in parts of three coordinates. Unlike the arc cosine it is right for small ones.
pub(super) fn angle(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = || a.iter().zip(b);
    let difference = norm(pairs().map(|(a, b)| minus(*a, *b)));
    let sum = norm(pairs().map(|(a, b)| minus(*a, b.map(|x| -x))));
    2.0 * difference.atan2(sum)
}

/// The length of a vector in parts of three coordinates; NaN if one is.
fn norm(parts: impl Iterator<Item = [f64; 3]>) -> f64 {
    parts.flatten().fold(0.0, f64::hypot)
}
