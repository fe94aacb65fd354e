//! The control points from which a surface continues over other knots.
//!
//! Over finer knots insertion is exact. Over other knots each control point is the point of the
//! surface at its Greville abscissae (means of p successive knots): a surface near the one before
//! (Schoenberg's operator), which keeps planes.

use std::sync::Arc;

use super::lines::flipped;
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::knot_selection::values::Values;

impl Level<2> {
    /// The control points over these lines of about the same surface.
    pub(crate) fn over(&self, lines: &[Breaks; 2]) -> Points {
        match self.lines == *lines {
            true => self.control_points.clone(),
            false => following(&self.lines, &self.control_points, lines),
        }
    }
}

/// The control points over `lines` of about the surface that has these ones over others, `before`.
fn following(before: &[Breaks; 2], control_points: &Points, lines: &[Breaks; 2]) -> Points {
    let maps = [0, 1].map(|axis| Map::new(&before[axis], &lines[axis]));
    let counts = |lines: &[Breaks; 2]| [0, 1].map(|axis| lines[axis].control_points());
    let [rows, columns] = counts(before);
    let [new_rows, new_columns] = counts(lines);
    let lanes = control_points.lanes().iter();
    Points::from_lanes(lanes.map(|lane| {
        let across = maps[1].apply(lane, rows, new_columns);
        let turned = flipped(&across, rows, new_columns);
        let both = maps[0].apply(&turned, new_columns, new_rows);
        debug_assert_eq!(lane.len(), rows * columns);
        flipped(&both, new_columns, new_rows)
    }))
}

/// From the control points of one line to those of another.
struct Map {
    /// The values at the Greville abscissae in increasing order; without it the lines are the same.
    values: Option<(Values, Vec<usize>)>,
}

impl Map {
    fn new(from: &Breaks, to: &Breaks) -> Self {
        let values = (from != to).then(|| {
            let sites = greville(to);
            let mut order: Vec<usize> = (0..sites.len()).collect();
            order.sort_by(|&a, &b| sites[a].total_cmp(&sites[b]));
            let sorted: Vec<f64> = order.iter().map(|&j| sites[j]).collect();
            (Values::new(from, &Arc::new(sorted)), order)
        });
        Self { values }
    }

    /// Maps each of `count` lines to one of `length` numbers.
    fn apply(&self, lane: &[f64], count: usize, length: usize) -> Vec<f64> {
        let Some((values, order)) = &self.values else {
            return lane.to_vec();
        };
        let mut sorted = vec![0.0; count * length];
        values.apply_to_lines(lane, &mut sorted);
        let mut all = vec![0.0; count * length];
        let lines = sorted.chunks_exact(length);
        for (sorted, y) in lines.zip(all.chunks_exact_mut(length)) {
            let places = order.iter().zip(sorted);
            places.for_each(|(&j, value)| y[j] = *value);
        }
        all
    }
}

/// The Greville abscissa of each control point, between the ends of the parameters.
fn greville(line: &Breaks) -> Vec<f64> {
    let (low, high) = (line.breaks()[0], line.breaks()[line.spans()]);
    let degree = line.degree();
    let mean = |j: usize| {
        let knots = (1..=degree).map(|k| (line.knot((j + k) as isize) - low) / degree as f64);
        let t = low + knots.sum::<f64>();
        // On a closed line the first functions begin before the start.
        let t = if line.is_closed() && t < low {
            t + (high - low)
        } else {
            t
        };
        t.clamp(low, high)
    };
    (0..line.control_points()).map(mean).collect()
}
