//! The control points from which a surface continues over other knots.
//!
//! Over finer knots insertion is exact. Over other knots each control point is the point of the
//! surface at its Greville abscissae (means of p successive knots): a surface near the one before
//! (Schoenberg's operator), which keeps planes.

use std::sync::Arc;

use super::lines::along;
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::levels::Level;
use crate::knot_selection::values::Values;

impl Level<2> {
    /// The control points over these lines of about the same surface.
    pub(crate) fn over(&self, lines: &[Breaks; 2]) -> Points {
        let (mut points, mut counts) = (self.control_points.clone(), self.counts());
        for axis in [1, 0] {
            let (before, line) = (&self.lines[axis], &lines[axis]);
            if before != line {
                points = along(&points, counts, axis, |it| followed(before, it, line));
                counts[axis] = line.control_points();
            }
        }
        points
    }
}

/// The control points over a line of about the curves that have these ones over another.
fn followed(before: &Breaks, control_points: &Points, line: &Breaks) -> Points {
    let sites = greville(line);
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|&a, &b| sites[a].total_cmp(&sites[b]));
    let sorted: Vec<f64> = order.iter().map(|&j| sites[j]).collect();
    let sorted = Values::new(before, &Arc::new(sorted)).points(control_points);
    Points::from_lanes(sorted.lanes().iter().map(|sorted| {
        let mut all = vec![0.0; order.len()];
        let places = order.iter().zip(&**sorted);
        places.for_each(|(&j, value)| all[j] = *value);
        all
    }))
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
