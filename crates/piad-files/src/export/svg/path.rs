//! Curves alone, as paths of cubic Bézier curves in the units of the data: for editors, plotters and cutters.
//!
//! y points upwards in data and downwards in SVG, so that all y have the opposite sign. Of curves in space x and y are
//! drawn.

use super::cubics::{Cubic, Pieces, pieces};
use crate::export::document::{Document, Shape};
use crate::export::error::ExportError;
use crate::export::text::{Text, escape};

/// The width of lines, as a fraction of the size of the drawing.
const LINE_WIDTH: f64 = 3e-3;

/// The paths as an SVG file.
pub(in crate::export) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut curves = Vec::with_capacity(document.shapes.len());
    document.try_each(|shape| {
        curves.push(pieces(shape.nurbs)?);
        Ok(())
    })?;
    let frame = Frame::of(&curves)?;
    let mut text = Text::default();
    text.push("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"");
    numbers(&mut text, &frame.view_box());
    text.put(format_args!(
        "\">\n<desc>{}</desc>\n",
        description(document, &curves)
    ));
    // Not as attributes of the paths: FontForge would import the outlines of their lines.
    text.push("<style>path{stroke:#000;stroke-width:");
    numbers(&mut text, &[frame.line]);
    text.push("}</style>\n");
    for (shape, curve) in document.shapes.iter().zip(&curves) {
        path(&mut text, shape, curve);
    }
    text.push("</svg>\n");
    Ok(text.into_bytes())
}

/// A description of the paths, and their distance from the curves.
fn description(document: &Document<'_>, curves: &[Pieces]) -> String {
    let is_exact = curves.iter().all(|curve| curve.is_exact);
    let accuracy = match is_exact {
        true => "exactly",
        false => "within 1e-4 of the size of each curve",
    };
    let is_spatial = document
        .shapes
        .iter()
        .any(|it| it.nurbs.points.dimension() > 2);
    let view = if is_spatial { ", seen from above" } else { "" };
    format!(
        "{}, {accuracy}, in the units of the data with y negated{view}",
        document.description
    )
}

fn path(text: &mut Text, shape: &Shape<'_>, curve: &Pieces) {
    text.push("<path fill=\"none\" d=\"");
    if let Some(first) = curve.cubics.first() {
        text.push("M");
        numbers(text, &on_page(first[0]));
    }
    for cubic in &curve.cubics {
        text.push("\n");
        if curve.is_straight {
            text.push("L");
            numbers(text, &on_page(cubic[3]));
        } else {
            text.push("C");
            let points = [cubic[1], cubic[2], cubic[3]].map(on_page);
            numbers(text, points.as_flattened());
        }
    }
    text.push(if shape.nurbs.u.closed { "Z\"" } else { "\"" });
    match shape.name {
        None => text.push("/>\n"),
        Some(name) => text.put(format_args!("><title>{}</title></path>\n", escape(name))),
    }
}

/// The point with y downwards, without negative zeros.
fn on_page([x, y]: [f64; 2]) -> [f64; 2] {
    [x, 0.0 - y]
}

/// Numbers with blanks between them.
fn numbers(text: &mut Text, numbers: &[f64]) {
    for (index, number) in numbers.iter().enumerate() {
        let digits = format!("{number:?}");
        text.push(if index > 0 { " " } else { "" });
        text.push(digits.strip_suffix(".0").unwrap_or(&digits));
    }
}

/// The box around all curves.
struct Frame {
    low: [f64; 2],
    high: [f64; 2],
    /// The width of lines, and of the margin around the curves.
    line: f64,
}

impl Frame {
    fn of(curves: &[Pieces]) -> Result<Self, ExportError> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for cubic in curves.iter().flat_map(|curve| &curve.cubics) {
            for axis in [0, 1] {
                for x in extremes(cubic, axis) {
                    low[axis] = low[axis].min(x);
                    high[axis] = high[axis].max(x);
                }
            }
        }
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        if !size.is_finite() {
            return Err(ExportError::Extent);
        }
        let line = if size > 0.0 { LINE_WIDTH * size } else { 1.0 };
        Ok(Self { low, high, line })
    }

    /// Left, top, width and height on the page. A straight line has no height: it needs a margin to be seen.
    fn view_box(&self) -> [f64; 4] {
        let margin = self.line;
        let [width, height] = [0, 1].map(|c| self.high[c] - self.low[c] + 2.0 * margin);
        let [left, top] = on_page([self.low[0] - margin, self.high[1] + margin]);
        [left, top, width, height]
    }
}

/// The values at both ends, and where the derivative of the coordinate vanishes.
fn extremes(cubic: &Cubic, axis: usize) -> impl Iterator<Item = f64> + use<> {
    let x = cubic.map(|point| point[axis]);
    let [a, b, c] = [x[1] - x[0], x[2] - x[1], x[3] - x[2]];
    // a (1 − t)² + 2 b (1 − t) t + c t² = 0, with roots that do not cancel.
    let (square, linear) = (a - 2.0 * b + c, b - a);
    let root = (linear * linear - square * a).max(0.0).sqrt();
    let q = -(linear + root.copysign(linear));
    let inside = |t: &f64| (0.0..=1.0).contains(t);
    let at = move |t: f64| {
        let s = 1.0 - t;
        s * s * s * x[0] + 3.0 * s * t * (s * x[1] + t * x[2]) + t * t * t * x[3]
    };
    let turns = [q / square, a / q].into_iter().filter(inside).map(at);
    [x[0], x[3]].into_iter().chain(turns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_those_of_the_curve() {
        for x in [
            [0.0, 1.0, -2.0, 3.0],
            [0.0, 0.0, 1.0, 1.0],
            [1.0, 3.0, 3.0, 1.0],
            [0.0, 1.0, 2.0, 3.0],
            [5.0, 5.0, 5.0, 5.0],
            [0.0, 4.0, 4.0, -1.0],
        ] {
            let cubic = x.map(|x| [x, 0.0]);
            let samples = (0..=10_000).map(|i| {
                let t = f64::from(i) / 1e4;
                let s = 1.0 - t;
                s * s * s * x[0]
                    + 3.0 * s * s * t * x[1]
                    + 3.0 * s * t * t * x[2]
                    + t * t * t * x[3]
            });
            let (low, high) = range(samples);
            let (least, most) = range(extremes(&cubic, 0));
            assert!(
                (low - least).abs() < 1e-7 && (high - most).abs() < 1e-7,
                "{x:?}"
            );
        }
    }

    fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    }
}
