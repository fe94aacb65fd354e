//! CSV: samples of the curve or surface with their parameters.

use super::Fitted;
use super::error::{ExportError, Place};
use super::text::Text;
use crate::fit::direction::Direction;
use crate::fit::geometry::Geometry;
use crate::fit::points::{Grid, Points};

/// Samples of a curve, and of each direction of a surface, unless asked for otherwise.
const CURVE: usize = 200;
const SURFACE: usize = 40;

/// The names of coordinates.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// A line with names (`t,x,y` of a curve, `u,v,x,y,z` of a surface), then one for each sample, at
/// equal steps of the parameters; on surfaces row by row.
pub(super) fn write(fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let problem = fitted.problem;
    let grid = fitted.samples.unwrap_or(match problem.v() {
        None => Grid {
            rows: CURVE,
            columns: 1,
        },
        Some(_) => Grid {
            rows: SURFACE,
            columns: SURFACE,
        },
    });
    let along =
        |direction: &Direction, count| Geometry::uniform_parameters(&direction.basis, count);
    let u = along(problem.u(), grid.rows);
    let v = problem.v().map(|v| along(v, grid.columns));
    let geometry = Geometry::new(problem, fitted.control_points);
    let points = geometry.evaluate(&u, v.as_deref().unwrap_or_default());
    check(&points, v.as_ref().map(Vec::len))?;
    let mut text = Text::default();
    text.push(if v.is_some() { "u,v" } else { "t" });
    for name in &COORDINATES[..points.dimension()] {
        text.put(format_args!(",{name}"));
    }
    text.push("\n");
    let columns = v.as_ref().map_or(1, Vec::len);
    for index in 0..points.len() {
        text.put(format_args!("{:?}", u[index / columns]));
        if let Some(v) = &v {
            text.put(format_args!(",{:?}", v[index % columns]));
        }
        for x in points.point(index) {
            text.put(format_args!(",{x:?}"));
        }
        text.push("\n");
    }
    Ok(text.into_bytes())
}

/// With weights that are not positive a curve can run through infinity.
fn check(points: &Points, columns: Option<usize>) -> Result<(), ExportError> {
    for (coordinate, lane) in points.lanes().iter().enumerate() {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(ExportError::NotFinite {
                what: "sample",
                place: Place::new(index, columns),
                coordinate,
                value: lane[index],
            });
        }
    }
    Ok(())
}
