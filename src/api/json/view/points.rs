//! The JSON of the points of a file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use crate::api::json::plain::never_null;
use crate::model::numbers::ScatteredPoints;
use crate::model::points::{PointGrid, PointList};
use crate::model::scattered::SurfaceParameters;
use piad_files::import::Imported;
use piad_fit::data::Points;
use piad_fit::parameters::{Mesh, MeshUnfolding, Scattered, Sections};

/// The points of a file as a job has them: one of `curve` and `surface` is there.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "FilePoints")]
#[schemars(extend("examples" = [{"name": "NACA 2412", "curve": {"points": [[1, 0.0013], [0.95, 0.0114]]}, "notices": []}]))]
pub(crate) struct PointsView {
    /// The name in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// The points of a curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    curve: Option<CurvePoints>,
    /// The points of a surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<SurfacePoints>,
    /// Notices about the file, in sentences.
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
    /// The parameters of the points: their times, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<Vec<f64>>,
}

/// The points of a surface: in rows, or those of sections.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(extend("examples" = [{"points": [[[0, 0, 0], [0, 1, 1]], [[1, 0, 1], [1, 1, 2]]]}]))]
struct SurfacePoints {
    /// Rows of points.
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<PointGrid>,
    /// The points of sections, one after the other, or the vertices of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<ScatteredPoints>")]
    scattered: Option<PointList>,
    /// The number of points of each section, the triangles of the mesh, or the parameters of the rows and columns of a
    /// grid with missing points, if x and y say them.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<SurfaceParameters>,
}

impl SurfacePoints {
    /// The points of sections or of a mesh.
    fn scattered(points: Arc<Points>, parameters: Scattered) -> Self {
        Self {
            points: None,
            scattered: Some(PointList(points)),
            parameters: Some(SurfaceParameters::Scattered(parameters)),
        }
    }
}

impl PointsView {
    /// The points of a file; those without rows are scattered ones if a rule for their parameters is given.
    pub(crate) fn new(file: Imported, scattered: Option<Scattered>) -> Self {
        let Imported {
            points,
            grid,
            sections,
            triangles,
            missing,
            closed,
            parameters,
            line_parameters,
            name,
            notices,
            ..
        } = file;
        let points = Arc::new(points);
        let (curve, surface) = match grid {
            None if !triangles.is_empty() => {
                let mesh = Mesh {
                    triangles: Arc::new(triangles),
                    unfolding: MeshUnfolding::Auto,
                };
                (
                    None,
                    Some(SurfacePoints::scattered(points, Scattered::Mesh(mesh))),
                )
            }
            None if !sections.is_empty() => (
                None,
                Some(SurfacePoints::scattered(
                    points,
                    Scattered::Sections(Sections::new(sections)),
                )),
            ),
            None => match scattered {
                Some(rule) => (None, Some(SurfacePoints::scattered(points, rule))),
                None => {
                    let points = PointList(points);
                    let curve = CurvePoints {
                        points,
                        closed,
                        parameters,
                    };
                    (Some(curve), None)
                }
            },
            Some(grid) => (
                None,
                Some(SurfacePoints {
                    points: Some(PointGrid {
                        points,
                        missing,
                        grid,
                    }),
                    scattered: None,
                    parameters: line_parameters.map(SurfaceParameters::of_lines),
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
