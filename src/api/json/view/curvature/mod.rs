//! The shape of a curve or surface: curvature, length, area, continuity.

mod curve;
mod extremes;
mod surface;

use schemars::JsonSchema;
use serde::Serialize;

use super::document::Document;
use super::writer::Digits;
use crate::job::content::Content;
use curve::{CurveShapeView, curve_example};
use piad_files::export::shape::Shape;
use surface::SurfaceShapeView;

/// The shape of an iteration: curvature and its extremes, length or area, and continuity at knots. Null means that
/// there is no curvature, because a derivative vanishes or a surface has no normal.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Shape", extend("examples" = [curve_example()]))]
pub(crate) enum ShapeView {
    /// Of a curve.
    Curve(CurveShapeView),
    /// Of a surface.
    Surface(Box<SurfaceShapeView>),
}

/// The shape of an iteration.
pub(crate) fn shape(iteration: usize, shape: Shape) -> Content {
    let mut document = Document::new(Digits::Decimal(None));
    let view = match shape {
        Shape::Curve(shape) => {
            ShapeView::Curve(CurveShapeView::new(&mut document, iteration, *shape))
        }
        Shape::Surface(shape) => ShapeView::Surface(Box::new(SurfaceShapeView::new(
            &mut document,
            iteration,
            *shape,
        ))),
    };
    document.finish(&view)
}
