//! The size of drawings, and how much of the data and of the control net they show.

use crate::export::nurbs::{Nurbs, in_space};
use crate::export::text::Text;
use crate::fit::problem::Problem;

/// The width of the drawing.
pub(super) const WIDTH: f64 = 800.0;
/// Free space on all sides.
pub(super) const MARGIN: f64 = 24.0;
/// The most data points that are drawn, and the most control points of nets that are.
const MOST_POINTS: usize = 2500;
pub(super) fn shows_net(nurbs: &Nurbs) -> bool {
    nurbs.points.len() <= MOST_POINTS
}

/// The radius of data points: the more there are, the smaller.
pub(super) fn dot_radius(count: usize) -> f64 {
    match count {
        0..=80 => 3.0,
        81..=300 => 2.0,
        _ => 1.5,
    }
}

/// Draws a polygon through these places, in pixels.
pub(super) fn draw_polygon(text: &mut Text, class: &str, places: impl Iterator<Item = (f64, f64)>) {
    text.put(format_args!("<path class=\"{class}\" d=\""));
    for (i, (x, y)) in places.enumerate() {
        let command = if i == 0 { 'M' } else { 'L' };
        text.put(format_args!("{command}{x:.2} {y:.2}\n"));
    }
    text.push("\"/>\n");
}

/// The data points that are drawn.
pub(super) struct DrawnData {
    pub(super) places: Vec<[f64; 3]>,
    /// One in `stride` points is drawn.
    pub(super) stride: usize,
}

impl DrawnData {
    pub(super) fn new(problem: &Problem) -> Self {
        let points = &problem.request().points;
        let count = problem.grid().count();
        let stride = count.div_ceil(MOST_POINTS);
        let known = |index: &usize| !problem.missing().is_some_and(|it| it.contains(*index));
        let place = |index| in_space(points.point(index));
        let indices = (0..count).step_by(stride).filter(known);
        Self {
            places: indices.map(place).collect(),
            stride,
        }
    }
}
