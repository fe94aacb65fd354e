//! The JSON of the points of a file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use crate::api::json::plain::never_null;
use crate::model::points::{PointGrid, PointList};
use piad_files::import::Imported;

/// The points of a file as a job has them: one of `curve` and `surface` is there.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "FilePoints")]
#[schemars(extend("examples" = [{"name": "NACA 2412", "curve": {"points": [[1, 0.0013], [0.95, 0.0114]]}, "notices": []}]))]
pub(crate) struct PointsView {
    /// What the file calls itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// The points of a curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    curve: Option<CurvePoints>,
    /// Those of a surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<SurfacePoints>,
    /// What was found out about the file, in sentences.
    notices: Vec<String>,
}

/// The points of a curve.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(extend("examples" = [{"points": [[0, 0], [1, 2]]}]))]
struct CurvePoints {
    /// The points in their order.
    points: PointList,
    /// The curve is closed: the file had the first point at its end again, which is not among these.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    closed: bool,
    /// The parameters of the points: their times, where these were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<Vec<f64>>,
}

/// The points of a surface.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"points": [[[0, 0, 0], [0, 1, 1]], [[1, 0, 1], [1, 1, 2]]]}]))]
struct SurfacePoints {
    /// Rows of points.
    points: PointGrid,
}

impl PointsView {
    /// The points of a file.
    pub(crate) fn new(file: Imported) -> Self {
        let Imported {
            points,
            grid,
            missing,
            closed,
            parameters,
            name,
            notices,
            ..
        } = file;
        let points = Arc::new(points);
        let (curve, surface) = match grid {
            None => (
                Some(CurvePoints {
                    points: PointList(points),
                    closed,
                    parameters,
                }),
                None,
            ),
            Some(grid) => (
                None,
                Some(SurfacePoints {
                    points: PointGrid {
                        points,
                        missing,
                        grid,
                    },
                }),
            ),
        };
        Self {
            name,
            curve,
            surface,
            notices,
        }
    }
}
