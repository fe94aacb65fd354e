//! Fits with a tolerance, compared with other programs.

mod few_knots;
mod rules;
mod scattered;
mod surface;
mod table;

use std::f64::consts::PI;
use std::sync::Arc;

use super::Options;
use super::breaks::Breaks;
use super::equations::LeastSquares;
use super::levels::Level;
use super::schedule::Schedule;
use crate::data::points::Points;
use crate::termination::Outcome;

/// Points of a function of numbers from one end to the other.
pub(super) fn sampled<const D: usize>(
    count: usize,
    from: f64,
    to: f64,
    f: impl Fn(f64) -> [f64; D],
) -> Points {
    let mut points = Points::new(D);
    for i in 0..count {
        let s = i as f64 / (count - 1) as f64;
        points.push(&f(from + (to - from) * s));
    }
    points
}

/// Chord lengths.
pub(super) fn chord(points: &Points) -> Vec<f64> {
    let mut t = vec![0.0];
    for i in 1..points.len() {
        t.push(t[i - 1] + points.distance(i - 1, i));
    }
    t
}

/// Options of a fit that begins with the coarsest knots.
#[derive(Clone)]
pub(super) struct Settings<const D: usize> {
    pub degrees: [usize; D],
    pub periods: [Option<f64>; D],
    pub tolerance: f64,
    pub max_control_points: [usize; D],
    pub correct_parameters: bool,
}

impl<const D: usize> Settings<D> {
    /// Cubic and open, with as many control points as needed.
    pub(super) fn cubic(tolerance: f64) -> Self {
        Self {
            degrees: [3; D],
            periods: [None; D],
            tolerance,
            max_control_points: [usize::MAX; D],
            correct_parameters: false,
        }
    }

    /// The options for data at some parameters.
    pub(super) fn options(&self, parameters: &[Arc<Vec<f64>>; D]) -> Options<D> {
        let coarsest = |axis: usize| {
            let (t, period) = (&parameters[axis], self.periods[axis]);
            let low = t.iter().copied().fold(f64::INFINITY, f64::min);
            let high = t.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let end = period.map_or(high, |period| low + period);
            Breaks::coarsest(self.degrees[axis], period.is_some(), low, end).unwrap()
        };
        Options {
            lines: std::array::from_fn(coarsest),
            first: None,
            parameters: parameters.clone(),
            tolerance: self.tolerance,
            max_control_points: self.max_control_points,
            correct_parameters: self.correct_parameters,
        }
    }
}

/// A curve of degree 3.
pub(super) fn cubic(tolerance: f64) -> Settings<1> {
    Settings::cubic(tolerance)
}

/// All levels of a fit, and how it ended.
pub(super) fn levels(
    points: &Points,
    t: Vec<f64>,
    settings: Settings<1>,
) -> (Vec<Arc<Level<1>>>, Option<Outcome>) {
    let points = Arc::new(points.clone());
    let minimum = LeastSquares::of(&points);
    let options = settings.options(&[Arc::new(t)]);
    let mut schedule = Schedule::new(points, options, minimum);
    let mut levels = Vec::new();
    while let Some(level) = schedule.next_level() {
        levels.push(level);
    }
    (levels, schedule.outcome())
}

/// Checks the rules of levels: they start with the fewest control points, go through the ends of
/// open curves, insertion keeps the curve, and the largest distance never rises while the knots
/// stay, or their number in redistribution.
pub(super) fn valid(points: &Points, levels: &[Arc<Level<1>>]) {
    let [first] = &levels[0].lines;
    assert_eq!(first.control_points(), first.degree() + 1);
    let size = points.bounding_diagonal();
    for pair in levels.windows(2) {
        let (before, after) = (&pair[0].distances, &pair[1].distances);
        let ([coarse], [fine]) = (&pair[0].lines, &pair[1].lines);
        let rises = after.max > before.max * (1.0 + 1e-9) + 1e-14 * size;
        let (from, to) = (coarse.control_points(), fine.control_points());
        assert!(from != to || !rises);
        // Of one span any knots are a refinement.
        if coarse.spans() > 1 && is_refined(coarse, fine) {
            let mut pairs = before.each.iter().zip(&after.each);
            assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-12 * size));
        }
    }
    for level in levels.iter().filter(|level| !level.lines[0].is_closed()) {
        let last = level.count() - 1;
        for (end, datum) in [(0, 0), (last, points.len() - 1)] {
            let mut pairs = level.control_points.point(end).zip(points.point(datum));
            assert!(pairs.all(|(x, p)| x == p));
        }
    }
}

/// Returns true if knots were inserted, and all others stayed.
pub(super) fn is_refined(coarse: &Breaks, fine: &Breaks) -> bool {
    let mut breaks = fine.breaks().iter();
    let stayed = coarse
        .breaks()
        .iter()
        .all(|it| breaks.any(|other| other == it));
    stayed && fine.spans() > coarse.spans()
}

/// The profile NACA 2412 with a closed trailing edge, from there over the upper side.
pub(super) fn profile() -> Points {
    sampled(401, 0.0, 2.0 * PI, |a| {
        let x: f64 = (1.0 + a.cos()) / 2.0;
        let x = x.max(0.0);
        let side = if a <= PI { 1.0 } else { -1.0 };
        let half = 0.6
            * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4));
        let (m, p) = (0.02, 0.4);
        let (camber, slope) = if x < p {
            (
                m / (p * p) * (2.0 * p * x - x * x),
                2.0 * m / (p * p) * (p - x),
            )
        } else {
            let q = m / ((1.0 - p) * (1.0 - p));
            (q * (1.0 - 2.0 * p + 2.0 * p * x - x * x), 2.0 * q * (p - x))
        };
        let turn = slope.atan();
        [
            x - side * half * turn.sin(),
            camber + side * half * turn.cos(),
        ]
    })
}

/// Half a lemniscate of Gerono.
pub(super) fn lemniscate() -> Points {
    sampled(500, -PI / 2.0, PI / 2.0, |a| [a.cos(), a.sin() * a.cos()])
}

/// r = 2 + 4 cos(2θ + π/4) + cos(3θ + π/4).
pub(super) fn rose(count: usize) -> Points {
    sampled(count, 0.0, 2.0 * PI, |a| {
        let r = 2.0 + 4.0 * (2.0 * a + PI / 4.0).cos() + (3.0 * a + PI / 4.0).cos();
        [r * a.cos(), r * a.sin()]
    })
}

/// A helix of three turns.
pub(super) fn helix() -> Points {
    sampled(1000, 0.0, 6.0 * PI, |a| [a.cos(), a.sin(), a / 2.0])
}

/// A steep step.
pub(super) fn step() -> Points {
    sampled(400, -2.0, 2.0, |x| [x, (50.0 * x).tanh()])
}
