//! Places where derivatives vanish but for rounding.

use crate::data::points::Points;
use crate::geometry::nurbs::sampling::SpanParameter;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// The most places without a curvature that are listed.
pub const MOST_DEGENERATE: usize = 100;

/// A derivative that is this small relative to the control points is zero.
const VANISHING: f64 = 1e-12;

/// The rounding errors of a derivative, in units of those of its terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The lengths up to which derivatives by the parameter of a direction count as zero, for each knot span.
#[derive(Debug)]
pub(super) struct Vanishing(Vec<f64>);

impl Vanishing {
    /// Those of the first direction, or of a curve.
    pub(super) fn along(nurbs: &Nurbs) -> Self {
        let columns = nurbs.columns();
        let step = |i: usize| {
            let pairs = (0..columns).map(|j| (i * columns + j, (i + 1) * columns + j));
            largest(&nurbs.points, pairs)
        };
        Self::new(&nurbs.u, nurbs.points.magnitude(), step)
    }

    /// Those of the second direction of a surface, which has these knots.
    pub(super) fn across(nurbs: &Nurbs, knots: &KnotVector) -> Self {
        let columns = knots.count();
        let step = |j: usize| {
            let pairs = (0..nurbs.rows()).map(|i| (i * columns + j, i * columns + j + 1));
            largest(&nurbs.points, pairs)
        };
        Self::new(knots, nurbs.points.magnitude(), step)
    }

    /// For control points that are up to `step(i)` from the next one.
    fn new(knots: &KnotVector, magnitude: f64, step: impl Fn(usize) -> f64) -> Self {
        let (degree, u) = (knots.degree, &knots.knots);
        // Control points of the derivative (PT97 (3.4)). Between two pieces there is none.
        let lengths = (1..knots.count()).map(|i| {
            let width = u[i + degree] - u[i];
            match width > 0.0 {
                true => degree as f64 * step(i - 1) / width,
                false => 0.0,
            }
        });
        let lengths: Vec<f64> = lengths.collect();
        let limit = |span: usize| {
            let width = u[span + 1] - u[span];
            let near = lengths.get(span - degree..span).unwrap_or_default();
            let longest = near.iter().copied().fold(0.0, f64::max);
            VANISHING * longest + ROUNDING * magnitude * degree as f64 / width
        };
        let mut limits = vec![0.0; u.len()];
        for span in knots.spans() {
            limits[span] = limit(span);
        }
        Self(limits)
    }

    /// The limit in the span of a parameter.
    pub(super) fn limit(&self, site: SpanParameter) -> f64 {
        self.0.get(site.span()).copied().unwrap_or_default()
    }
}

fn largest(points: &Points, pairs: impl Iterator<Item = (usize, usize)>) -> f64 {
    let distances = pairs.map(|(i, j)| points.distance(i, j));
    distances.fold(0.0, f64::max)
}
