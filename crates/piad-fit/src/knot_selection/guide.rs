//! Points between the data, for curves that deviate there.
//!
//! A curve with nearly as many control points as data can be within the tolerance at all of them and deviate far
//! between them. In that case the fit is repeated with three points between each two data points, and with eleven if it
//! deviates between those: an edge with several knots has room for loops. The points lie between two curves, both cubic
//! between the data with a common derivative at each datum:
//!
//! - that of the parabola through three data (Bessel), which follows circles;
//! - that of the chord between both neighbours, shorter the more the data turn back: it is straight along long edges,
//!   and has a small derivative at sharp corners.
//!
//! The points lie between both: each derivative is that of the second curve and a quarter of the difference to the
//! first, or less at an end of a long edge beside a densely sampled bend: such edges are straight. The same part of the
//! difference is *freedom* that the data leave: distances within it count as zero, and it lowers the weight of a point
//! in the sum of squares. Neither curve is further from the edge between two data than the edge is long.

use std::sync::Arc;

use super::levels::Level;
use crate::data::distances::Distances;
use crate::data::points::{Points, normalizing_scale};
use crate::geometry::freedom::{length, limited, part_beside};

/// The least number of parts that points divide the parameters between two data into.
const PARTS: usize = 4;

/// The number of such parts of a long edge beside a densely sampled bend, and of all edges in a dense guide.
const DENSE_PARTS: usize = 12;

/// The largest part of the first curve in the points, and of the difference of both that is freedom.
const MOST_OF_FIRST: f64 = 0.25;

/// The most control points beyond the number of data.
const MOST_MORE: usize = 1000;

/// The greatest ratio of a derivative to the chord of either side.
const LONGEST: f64 = 1.5;

/// The least weight of a guide point as a part of a datum's weight, so that it determines the fit where there is
/// nothing else.
const LEAST_WEIGHT: f64 = 1e-6;

/// Data with points between them.
#[derive(Clone, Debug)]
pub(crate) struct Guide {
    /// The points, those of the data among them.
    pub(crate) points: Arc<Points>,
    /// Their parameters.
    pub(crate) parameters: Arc<Vec<f64>>,
    /// Distances that do not count.
    pub(crate) freedom: Arc<[f64]>,
    /// True if there are as many points between all data as on long edges.
    pub(crate) is_dense: bool,
    /// The parameters of the data.
    of_data: Arc<Vec<f64>>,
    /// The index of each datum among the points.
    data: Vec<usize>,
}

impl Guide {
    /// The most control points of a curve through `data` data with points between them. It is more than the number of
    /// data, as few data do not resolve corners, and long lists hardly need more.
    pub(crate) fn most_control_points(data: usize) -> usize {
        data.saturating_add(MOST_MORE.min((PARTS - 1) * data))
    }

    /// Between data at increasing parameters, of a closed curve also between the last and the first.
    pub(crate) fn new(
        data: &Points,
        parameters: &Arc<Vec<f64>>,
        period: Option<f64>,
        is_dense: bool,
    ) -> Self {
        let line = Line::new(data, parameters, period);
        let mut points = Points::new(data.dimension());
        let (mut t, mut freedom, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..data.len() {
            places.push(points.len());
            points.push(&line.datum(i));
            t.push(parameters[i]);
            freedom.push(0.0);
            if i + 1 == data.len() && period.is_none() {
                break;
            }
            let [from, to] = [line.parameter(i), line.parameter(i + 1)];
            let parts = if is_dense { DENSE_PARTS } else { line.parts(i) };
            for part in (1..parts).map(|k| k as f64 / parts as f64) {
                let (point, free) = line.between(i, part);
                points.push(&point);
                t.push((1.0 - part) * from + part * to);
                freedom.push(free);
            }
        }
        Self {
            points: Arc::new(points),
            parameters: Arc::new(t),
            freedom: freedom.into(),
            is_dense,
            of_data: Arc::clone(parameters),
            data: places,
        }
    }

    /// The weight of each point, where the data have these weights.
    pub(crate) fn weights(&self, tolerance: f64, of_data: Option<&[f64]>) -> Vec<f64> {
        let weight = |(k, freedom): (usize, &f64)| {
            let share = tolerance / (tolerance + freedom);
            let datum = self.data.partition_point(|&place| place <= k) - 1;
            of_data.map_or(1.0, |weights| weights[datum]) * (share * share).max(LEAST_WEIGHT)
        };
        self.freedom.iter().enumerate().map(weight).collect()
    }

    /// A level with the distances of the data alone.
    pub(crate) fn of_data(&self, level: &Level<1>) -> Level<1> {
        let unit = normalizing_scale(self.points.magnitude());
        let each = self.data.iter().map(|&place| level.distances.each[place]);
        let squares = each.map(|distance| (distance * unit) * (distance * unit));
        Level {
            distances: Distances::of_squares(squares.collect(), unit),
            parameters: [Arc::clone(&self.of_data)],
            lines: level.lines.clone(),
            control_points: level.control_points.clone(),
        }
    }
}

/// Both derivatives at each datum.
struct Line<'a> {
    data: &'a Points,
    parameters: &'a [f64],
    period: Option<f64>,
    derivatives: Vec<[Vec<f64>; 2]>,
}

impl<'a> Line<'a> {
    fn new(data: &'a Points, parameters: &'a [f64], period: Option<f64>) -> Self {
        let mut line = Self {
            data,
            parameters,
            period,
            derivatives: Vec::new(),
        };
        let count = data.len();
        let is_inside = |i: &usize| period.is_some() || (1..count - 1).contains(i);
        let nothing = || [0, 1].map(|_| vec![0.0; data.dimension()]);
        line.derivatives = (0..count)
            .map(|i| match is_inside(&i) {
                true => line.inside((i + count - 1) % count, i),
                false => nothing(),
            })
            .collect();
        if period.is_none() {
            line.derivatives[0] = line.at_end(0, 1.min(count - 1));
            line.derivatives[count - 1] =
                line.at_end(count.saturating_sub(2), count.saturating_sub(2));
        }
        line
    }

    fn datum(&self, i: usize) -> Vec<f64> {
        self.data.point(i % self.data.len()).collect()
    }

    fn parameter(&self, i: usize) -> f64 {
        let turns = (i / self.parameters.len()) as f64;
        self.parameters[i % self.parameters.len()] + turns * self.period.unwrap_or(0.0)
    }

    /// The chord from datum i to the next one over the difference of their parameters, and that difference.
    fn chord(&self, i: usize) -> (Vec<f64>, f64) {
        let width = self.parameter(i + 1) - self.parameter(i);
        let (from, to) = (self.datum(i), self.datum(i + 1));
        let chord = from.iter().zip(to).map(|(from, to)| (to - from) / width);
        (chord.collect(), width)
    }

    /// At the datum between the gaps after `before` and after `i`.
    fn inside(&self, before: usize, i: usize) -> [Vec<f64>; 2] {
        let ((before, h), (after, k)) = (self.chord(before), self.chord(i));
        let [a, b] = [&before, &after].map(|chord| length(chord));
        let longest = LONGEST * a.min(b);
        let product: f64 = before
            .iter()
            .zip(&after)
            .map(|(x, y)| (x / a) * (y / b))
            .sum();
        let turned = if a > 0.0 && b > 0.0 {
            (1.0 + product).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mixed = |of_before: f64, factor: f64| {
            let pairs = before.iter().zip(&after);
            let mean = pairs.map(|(x, y)| factor * (of_before * x + (1.0 - of_before) * y));
            limited(mean.collect(), longest)
        };
        [mixed(k / (h + k), 1.0), mixed(h / (h + k), turned)]
    }

    /// At the end of the gap after datum `gap`, whose other end is known: as of a parabola.
    fn at_end(&self, gap: usize, other: usize) -> [Vec<f64>; 2] {
        let (chord, _) = self.chord(gap);
        if self.data.len() < 3 {
            return [chord.clone(), chord];
        }
        let longest = LONGEST * length(&chord);
        [0, 1].map(|k| {
            let pairs = chord.iter().zip(&self.derivatives[other][k]);
            let of_parabola = pairs.map(|(chord, known)| (3.0 * chord - known) / 2.0);
            limited(of_parabola.collect(), longest)
        })
    }

    /// The parts of its freedom that a gap has at both of its ends; where there is no gap beside it, that of the other
    /// end.
    fn parts_of_freedom(&self, gap: usize) -> [f64; 2] {
        let count = self.data.len();
        let is_closed = self.period.is_some();
        let part = |indices: [usize; 3]| part_beside(self.data, indices.map(|i| i % count));
        let before = (is_closed || gap > 0).then(|| part([gap + count - 1, gap, gap + 1]));
        let after = (is_closed || gap + 2 < count).then(|| part([gap + 2, gap + 1, gap]));
        [before.or(after), after.or(before)].map(|part| part.unwrap_or(1.0))
    }

    /// The number of parts into which the points divide a gap.
    fn parts(&self, gap: usize) -> usize {
        let [before, after] = self.parts_of_freedom(gap);
        match before.min(after) < 1.0 {
            true => DENSE_PARTS,
            false => PARTS,
        }
    }

    /// The point at a part of the gap after datum i, and its freedom.
    fn between(&self, i: usize, s: f64) -> (Vec<f64>, f64) {
        let (from, to) = (self.datum(i), self.datum(i + 1));
        let width = self.parameter(i + 1) - self.parameter(i);
        let count = self.data.len();
        let [before, after] = self.parts_of_freedom(i).map(|part| MOST_OF_FIRST * part);
        // The weights of the derivatives at both ends in a cubic, and the part of the first curve in them.
        let of_ends = [
            (i % count, s * (1.0 - s) * (1.0 - s) * width, before),
            ((i + 1) % count, -s * s * (1.0 - s) * width, after),
        ];
        let (mut point, mut free) = (Vec::new(), 0.0_f64);
        for c in 0..from.len() {
            let mut value =
                (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s) * from[c] + s * s * (3.0 - 2.0 * s) * to[c];
            let mut difference = 0.0;
            for (datum, weight, part_of_first) in of_ends {
                let [first, second] = [0, 1].map(|k| self.derivatives[datum][k][c]);
                let part = weight * part_of_first * (first - second);
                value += weight * second + part;
                difference += part;
            }
            point.push(value);
            free = free.hypot(difference);
        }
        (point, free)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No point is further from the edge between its neighbours than this is long, and on an edge of a rectangle all
    /// are on it but for their freedom.
    #[test]
    fn points_stay_near_their_edges() {
        let outlines: [&[[f64; 2]]; 4] = [
            &[[0.0, 0.0], [9.0, 0.0], [9.0, 1.0], [0.0, 1.0]],
            &[
                [0.0, 0.0],
                [1.0, 5.0],
                [1.1, 5.0],
                [1.2, -5.0],
                [1.2, -5.0],
                [7.0, 0.0],
            ],
            &[[0.0, 0.0], [1.0, 0.0]],
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1e-9], [2.0, 0.0]],
        ];
        for (outline, period) in outlines.iter().flat_map(|it| [(it, None), (it, Some(1.0))]) {
            let data = Points::from_flat(2, &outline.concat());
            let count = data.len() as f64 + 0.25;
            let t = (0..data.len()).map(|i| i as f64 / count).collect();
            let guide = Guide::new(&data, &Arc::new(t), period, false);
            let gaps = data.len() - usize::from(period.is_none());
            assert!(guide.points.len() >= data.len() + 3 * gaps);
            assert!(guide.parameters.windows(2).all(|pair| pair[0] < pair[1]));
            for k in 0..guide.points.len() {
                let i = guide.data.partition_point(|&place| place <= k) - 1;
                let edge = data.distance(i, (i + 1) % data.len());
                assert!(
                    guide.points.distance(k, guide.data[i]) + guide.freedom[k] <= 1.5 * edge,
                    "{outline:?} {k}"
                );
            }
        }
    }

    /// Data of a circle: the points are on it within the freedom.
    #[test]
    fn points_follow_circles() {
        let count = 12;
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
        let circle = (0..count).flat_map(|k| [angle(k).cos(), angle(k).sin()]);
        let data = Points::from_flat(2, &circle.collect::<Vec<_>>());
        let t = Arc::new((0..count).map(|k| k as f64).collect());
        let guide = Guide::new(&data, &t, Some(count as f64), false);
        for (k, freedom) in guide.freedom.iter().enumerate() {
            let off = guide.points.point(k).fold(0.0, f64::hypot) - 1.0;
            assert!(
                off.abs() <= freedom + 2e-3,
                "{k}: {off:e}, free {freedom:e}"
            );
        }
    }
}
