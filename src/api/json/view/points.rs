//! The JSON of the points of a file.

use std::ops::Range;

use schemars::JsonSchema;
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

use crate::api::json::points::{PointGrid, PointList};
use crate::api::json::schema::plain::never_null;
use crate::fit::points::{Grid, Points};
use crate::import::Imported;

/// The points of a file as a job has them: one of `curve` and `surface` is there.
#[derive(Serialize, JsonSchema)]
#[schemars(transform = never_null)]
#[schemars(rename = "FilePoints")]
#[schemars(extend("examples" = [{"name": "NACA 2412", "curve": {"points": [[1, 0.0013], [0.95, 0.0114]]}, "notices": []}]))]
pub struct PointsView {
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
#[schemars(extend("examples" = [{"points": [[0, 0], [1, 2]]}]))]
struct CurvePoints {
    /// The points in their order.
    #[schemars(with = "PointList")]
    points: List,
    /// The curve is closed: the file had the first point at its end again, which is not among these.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    closed: bool,
}

/// The points of a surface.
#[derive(Serialize, JsonSchema)]
#[schemars(extend("examples" = [{"points": [[[0, 0, 0], [0, 1, 1]], [[1, 0, 1], [1, 1, 2]]]}]))]
struct SurfacePoints {
    /// Rows of points.
    #[schemars(with = "PointGrid")]
    points: Rows,
}

impl PointsView {
    /// The points of a file.
    pub fn new(file: Imported) -> Self {
        let Imported {
            points,
            grid,
            closed,
            name,
            notices,
            ..
        } = file;
        let (curve, surface) = match grid {
            None => (
                Some(CurvePoints {
                    points: List(points),
                    closed,
                }),
                None,
            ),
            Some(grid) => (
                None,
                Some(SurfacePoints {
                    points: Rows(points, grid),
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

struct List(Points);

impl Serialize for List {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Part(&self.0, 0..self.0.len()).serialize(serializer)
    }
}

struct Rows(Points, Grid);

impl Serialize for Rows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, grid) = self;
        let start = |row: usize| row * grid.columns;
        serializer.collect_seq((0..grid.rows).map(|row| Part(points, start(row)..start(row + 1))))
    }
}

/// Some of the points.
struct Part<'a>(&'a Points, Range<usize>);

impl Serialize for Part<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.1.len()))?;
        for index in self.1.clone() {
            list.serialize_element(&Point(self.0, index))?;
        }
        list.end()
    }
}

struct Point<'a>(&'a Points, usize);

impl Serialize for Point<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let lanes = self.0.lanes().iter();
        serializer.collect_seq(lanes.filter_map(|lane| lane.get(self.1)))
    }
}
