//! The size of drawings, and the share of the data and of the control net that they show.

use std::collections::HashMap;

use super::view::{Canvas, Projected, Projection, WIDTH};
use crate::export::deviation::stride;
use crate::export::nurbs::Nurbs;
use crate::export::options::Dots;
use crate::export::text::Text;
use piad_fit::data::Grid;
use piad_fit::engine::Problem;
use piad_fit::engine::vectors::in_space;

/// The most data points that are drawn, and the most control points of polygons that are.
const MOST_POINTS: usize = 2500;

/// The most control points of nets that are drawn: the lines of more of them would cover the surface.
const MOST_OF_NET: usize = 600;

/// Returns true if the control polygon or net is drawn.
pub(super) fn shows_net(nurbs: &Nurbs) -> bool {
    let most = if nurbs.v.is_some() {
        MOST_OF_NET
    } else {
        MOST_POINTS
    };
    nurbs.points.len() <= most
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

/// Up to this number, dots hide little.
const FEW: usize = 100;

/// The largest part of dots that may cover each other by default.
const MOST_COVERED: f64 = 1.0 / 3.0;

/// The data points of the drawing.
pub(super) struct DrawnData {
    pub(super) places: Vec<Projected>,
    /// Drawn points that a robust fit leaves out.
    outliers: Vec<Projected>,
    /// Every `stride`-th point of a curve, or row and column of a grid, is among them.
    stride: usize,
    is_grid: bool,
    is_curve: bool,
    /// They are drawn as dots.
    pub(super) dots: bool,
}

impl DrawnData {
    pub(super) fn new(problem: &Problem, view: &Projection) -> Self {
        let points = &problem.request().points;
        let Grid { rows, columns } = problem.grid();
        let stride = stride(problem.grid(), MOST_POINTS);
        let known = |index: &usize| !problem.missing().is_some_and(|it| it.contains(*index));
        let place = |index| view.project(in_space(points.point(index)));
        let some = (0..columns).step_by(stride);
        let indices = (0..rows).step_by(stride);
        let indices = indices.flat_map(|i| some.clone().map(move |j| i * columns + j));
        let outliers = problem.outliers().iter().take(MOST_POINTS);
        Self {
            places: indices.filter(known).map(place).collect(),
            outliers: outliers.map(|&index| place(index)).collect(),
            stride,
            is_grid: columns > 1,
            is_curve: problem.v().is_none(),
            dots: true,
        }
    }

    /// Decides whether dots are drawn: by default if they do not hide each other or the drawing
    /// below them.
    pub(super) fn choose(&mut self, dots: Dots, canvas: &Canvas) {
        self.dots = match dots {
            Dots::On => true,
            Dots::Off => false,
            Dots::Auto => {
                let pixels: Vec<_> = self.places.iter().map(|it| canvas.pixel(*it)).collect();
                are_sparse(&pixels, self.radius(), self.is_curve)
            }
        };
    }

    /// The radius of the dots: the more there are, the smaller.
    pub(super) fn radius(&self) -> f64 {
        match self.places.len() {
            0..=80 => 3.0,
            81..=300 => 2.0,
            _ => 1.5,
        }
    }

    /// Draws the outliers that are not beyond the drawing.
    pub(super) fn draw_outliers(&self, text: &mut Text, canvas: &Canvas) {
        let inside = |x: f64, most: f64| (0.0..=most).contains(&x);
        for (x, y) in self.outliers.iter().map(|&it| canvas.pixel(it)) {
            if inside(x, WIDTH) && inside(y, canvas.height()) {
                text.put(format_args!(
                    "<circle class=\"outlier\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"3.5\"/>\n"
                ));
            }
        }
    }

    /// The caption of the circles around outliers.
    pub(super) fn legend_of_outliers(&self) -> Option<&'static str> {
        (!self.outliers.is_empty()).then_some("outliers, left out")
    }

    /// The caption of the dots.
    pub(super) fn legend(&self) -> Option<String> {
        let text = match (self.stride, self.is_grid) {
            (1, _) => "data points".to_owned(),
            (stride, false) => format!("data points, one in {stride}"),
            (stride, true) => format!("data points, one in {stride} × {stride}"),
        };
        self.dots.then_some(text)
    }
}

/// Returns true if dots of this radius hide neither each other nor the drawing below them. Along a
/// curve there is as much space between them as they take.
pub(super) fn are_sparse(pixels: &[(f64, f64)], radius: f64, along_a_curve: bool) -> bool {
    let near = if along_a_curve { 4.0 } else { 2.0 } * radius;
    pixels.len() <= FEW || covered(pixels, near) <= MOST_COVERED
}

/// The part of the dots that have another one nearer than this.
fn covered(pixels: &[(f64, f64)], near: f64) -> f64 {
    let cell = |(x, y): (f64, f64)| ((x / near).floor() as i64, (y / near).floor() as i64);
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    for (index, &pixel) in pixels.iter().enumerate() {
        cells.entry(cell(pixel)).or_default().push(index);
    }
    let is_covered = |index: usize| {
        let ((x, y), (i, j)) = (pixels[index], cell(pixels[index]));
        let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (i + di, j + dj)));
        let mut others = around.filter_map(|it| cells.get(&it)).flatten();
        others.any(|&it| it != index && (pixels[it].0 - x).hypot(pixels[it].1 - y) < near)
    };
    let count = (0..pixels.len()).filter(|&it| is_covered(it)).count();
    count as f64 / pixels.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_that_are_near_each_other_are_counted() {
        assert_eq!(covered(&[(0.0, 0.0), (5.0, 0.0), (0.0, 5.0)], 4.0), 0.0);
        let half = covered(&[(0.0, 0.0), (3.9, 0.0), (50.0, 0.0), (0.0, -50.0)], 4.0);
        assert_eq!(half, 0.5);
        assert_eq!(covered(&[], 4.0), 0.0);
    }
}
