//! Arc length: samples of a curve at equal distances along it.

use super::nurbs::Nurbs;
use super::nurbs::sampling::SpanParameter;
use crate::interrupt;

/// Nodes and weights of the Gauss–Legendre rule with five nodes, on [0, 1].
pub(super) const NODES: [f64; 5] = [
    0.046_910_077_030_668_004,
    0.230_765_344_947_158_45,
    0.5,
    0.769_234_655_052_841_6,
    0.953_089_922_969_332,
];
pub(super) const WEIGHTS: [f64; 5] = [
    0.118_463_442_528_094_54,
    0.239_314_335_249_683_24,
    0.284_444_444_444_444_44,
    0.239_314_335_249_683_24,
    0.118_463_442_528_094_54,
];

/// The difference of a piece from its halves, as a fraction of the length of the curve, with which it is accepted.
const ACCURACY: f64 = 1e-12;

/// The number of times that a span is halved, at cusps, where the rule converges slowly.
const MOST_HALVINGS: u32 = 24;

/// The most pieces of a curve that is nowhere smooth; from then on they are not halved any more.
const MOST_PIECES: usize = 1 << 20;

/// The most steps to find a parameter; each at least halves the interval that it is in.
const MOST_STEPS: usize = 60;

/// Coordinates that are evaluated at a time.
const TOGETHER: usize = 3;

/// The number of evaluations between checks for an abandoned computation: about a millisecond.
const BETWEEN_CHECKS: usize = 1 << 8;

/// The lengths of pieces of a curve, each short enough for the quadrature.
#[derive(Debug)]
pub struct ArcLength<'a> {
    nurbs: &'a Nurbs,
    pieces: Vec<Piece>,
    total: f64,
    /// The number of evaluations.
    evaluations: usize,
}

/// A part of a knot span.
#[derive(Clone, Copy, Debug)]
struct Piece {
    span: usize,
    start: f64,
    end: f64,
    /// The length of all pieces before it.
    before: f64,
    length: f64,
}

impl<'a> ArcLength<'a> {
    /// The lengths of a curve.
    pub fn new(nurbs: &'a Nurbs) -> Self {
        let mut lengths = Self {
            nurbs,
            pieces: Vec::new(),
            total: 0.0,
            evaluations: 0,
        };
        let spans = nurbs.u.spans();
        let rough: Vec<f64> = spans
            .iter()
            .map(|&span| lengths.of(span, ends(nurbs, span)))
            .collect();
        // Far from the origin rounding is more than that.
        let rounding = f64::EPSILON * nurbs.points.magnitude();
        let tolerance = (ACCURACY * rough.iter().sum::<f64>()).max(rounding);
        for (span, rough) in spans.into_iter().zip(rough) {
            lengths.add(span, ends(nurbs, span), rough, tolerance);
        }
        lengths
    }

    /// The length of the whole curve.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// `steps + 1` sites with equal distances along the curve, from one end to the other.
    pub fn sites(&mut self, steps: usize) -> Vec<SpanParameter> {
        let knots = &self.nurbs.u;
        let (Some(&first), Some(&last)) = (knots.spans().first(), knots.spans().last()) else {
            return Vec::new();
        };
        let mut sites = Vec::with_capacity(steps + 1);
        sites.push(knots.site(first, 0.0));
        let mut piece = 0;
        for i in 1..steps {
            let target = self.total * (i as f64 / steps as f64);
            let has_more = |piece: usize| piece + 1 < self.pieces.len();
            while has_more(piece) && self.pieces[piece + 1].before <= target {
                piece += 1;
            }
            if let Some(&piece) = self.pieces.get(piece) {
                sites.push(self.find(piece, target - piece.before));
            }
        }
        sites.push(knots.site(last, 1.0));
        sites
    }

    /// Appends a part of a span with this length, as it is or in halves until they are accurate.
    fn add(&mut self, span: usize, ends: (f64, f64), length: f64, tolerance: f64) {
        let mut waiting = vec![(ends, length, 0)];
        while let Some(((start, end), length, halvings)) = waiting.pop() {
            let middle = 0.5 * (start + end);
            let halves = [(start, middle), (middle, end)].map(|ends| (ends, self.of(span, ends)));
            let sum = halves[0].1 + halves[1].1;
            // Comparisons with NaN are false: it is accepted, and the total is NaN.
            let is_rough = (sum - length).abs() > tolerance;
            if is_rough && halvings < MOST_HALVINGS && self.pieces.len() < MOST_PIECES {
                let [first, second] = halves.map(|(ends, length)| (ends, length, halvings + 1));
                waiting.extend([second, first]);
                continue;
            }
            self.pieces.push(Piece {
                span,
                start,
                end,
                before: self.total,
                length: sum,
            });
            self.total += sum;
        }
    }

    /// The place in a piece at this distance from its start: Newton's method, with bisection where it leaves the
    /// interval.
    fn find(&mut self, piece: Piece, distance: f64) -> SpanParameter {
        let (mut low, mut high) = (piece.start, piece.end);
        let part = (distance / piece.length).clamp(0.0, 1.0);
        let mut t = low + part * (high - low);
        let tolerance = 4.0 * f64::EPSILON * self.total;
        for _ in 0..MOST_STEPS {
            let excess = self.of(piece.span, (piece.start, t)) - distance;
            if excess.abs() <= tolerance || low >= high {
                break;
            }
            if excess > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let speed = self.speed(&[SpanParameter::new(piece.span, t)]);
            let next = t - excess / speed[0];
            let inside = low < next && next < high;
            t = if inside { next } else { 0.5 * (low + high) };
        }
        SpanParameter::new(piece.span, t)
    }

    /// The length of a part of a span by the rule.
    fn of(&mut self, span: usize, (start, end): (f64, f64)) -> f64 {
        let width = end - start;
        let sites = NODES.map(|node| SpanParameter::new(span, start + node * width));
        let speeds = self.speed(&sites);
        let weighted = speeds
            .iter()
            .zip(WEIGHTS)
            .map(|(speed, weight)| weight * speed);
        width * weighted.sum::<f64>()
    }

    /// The length of the derivative at sites.
    fn speed(&mut self, sites: &[SpanParameter]) -> Vec<f64> {
        let dimension = self.nurbs.points.dimension();
        self.evaluations += 1;
        if self.evaluations.is_multiple_of(BETWEEN_CHECKS) {
            interrupt::check();
        }
        let mut speeds = vec![0.0_f64; sites.len()];
        for first in (0..dimension).step_by(TOGETHER) {
            let jets = self.nurbs.evaluate_from(first, sites, &[]);
            for (speed, jet) in speeds.iter_mut().zip(jets) {
                *speed = jet.du.iter().fold(*speed, |sum, x| sum.hypot(*x));
            }
        }
        speeds
    }
}

fn ends(nurbs: &Nurbs, span: usize) -> (f64, f64) {
    (nurbs.u.knots[span], nurbs.u.knots[span + 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::points::Points;
    use crate::geometry::nurbs::KnotVector;

    fn curve(degree: usize, knots: &[f64], places: &[[f64; 2]]) -> Nurbs {
        let mut points = Points::new(2);
        places.iter().for_each(|place| points.push(place));
        Nurbs {
            u: KnotVector {
                degree,
                knots: knots.to_vec(),
                closed: false,
            },
            v: None,
            points,
            weights: None,
        }
    }

    /// A quarter of a circle: equal distances are equal angles.
    #[test]
    fn circles_are_divided_by_angles() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut arc = curve(
            2,
            &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            &[[3.0, 0.0], [3.0, 3.0], [0.0, 3.0]],
        );
        arc.weights = Some(vec![1.0, half, 1.0]);
        let mut lengths = ArcLength::new(&arc);
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((lengths.total() - 3.0 * quarter).abs() < 1e-13);
        let sites = lengths.sites(90);
        assert_eq!(sites.len(), 91);
        for (degree, jet) in arc.evaluate(&sites, &[]).iter().enumerate() {
            let angle = jet.point[1].atan2(jet.point[0]);
            assert!((angle.to_degrees() - degree as f64).abs() < 1e-11);
        }
        assert_eq!((sites[0].t, sites[90].t), (0.0, 1.0));
    }

    /// A parabola, with its length in closed form.
    #[test]
    fn parabolas_have_their_length() {
        let parabola = curve(
            2,
            &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            &[[0.0, 0.0], [5.0, 0.0], [10.0, 100.0]],
        );
        // y = x² from 0 to 10.
        let root = 401_f64.sqrt();
        let expected = 0.25 * (20.0 * root + 20_f64.asinh());
        let mut lengths = ArcLength::new(&parabola);
        assert!((lengths.total() - expected).abs() < 1e-11 * expected);
        let sites = lengths.sites(7);
        for (i, jet) in parabola.evaluate(&sites, &[]).iter().enumerate() {
            let x = jet.point[0];
            let to = 0.5 * x * (1.0 + 4.0 * x * x).sqrt() + 0.25 * (2.0 * x).asinh();
            assert!((to - expected * i as f64 / 7.0).abs() < 1e-10 * expected);
        }
    }

    /// Control points that coincide: the derivative vanishes at both ends, at a cusp and along a whole span.
    #[test]
    fn standing_still_is_no_obstacle() {
        let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0];
        let places = [
            [0.0, 0.0],
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 0.0],
            [4.0, 0.0],
            [4.0, 0.0],
            [8.0, 0.0],
        ];
        let line = curve(3, &knots, &places);
        let mut lengths = ArcLength::new(&line);
        assert!((lengths.total() - 8.0).abs() < 1e-11);
        let sites = lengths.sites(16);
        for (i, jet) in line.evaluate(&sites, &[]).iter().enumerate() {
            assert!((jet.point[0] - 0.5 * i as f64).abs() < 1e-9, "{i} {jet:?}");
        }
        let cusp = curve(
            3,
            &[[0.0; 4], [1.0; 4]].concat(),
            &[[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]],
        );
        let polygon: f64 = {
            let jets = cusp.evaluate(&cusp.u.sites(100_000), &[]);
            let steps = jets.windows(2);
            let step = |c: usize, pair: &[crate::geometry::nurbs::sampling::Jet]| {
                pair[1].point[c] - pair[0].point[c]
            };
            steps.map(|pair| step(0, pair).hypot(step(1, pair))).sum()
        };
        assert!((ArcLength::new(&cusp).total() - polygon).abs() < 1e-9);
    }

    #[test]
    fn a_point_has_no_length() {
        let point = curve(1, &[0.0, 0.0, 1.0, 1.0], &[[1.0, 2.0], [1.0, 2.0]]);
        let mut lengths = ArcLength::new(&point);
        assert_eq!(lengths.total(), 0.0);
        assert_eq!(lengths.sites(4).len(), 5);
    }
}
