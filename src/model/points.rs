//! Points, which are read from JSON directly into the arrays of the computation.

use std::ops::Range;
use std::sync::Arc;

use piad_files::json::{Rows, read_points, read_rows, read_sections};
use piad_fit::data::{Grid, Points};
use serde::de::Deserializer;
use serde::{Deserialize, Serialize, Serializer};

use super::list_limits;

/// A list of points: `[[x, y, z], …]`, all with the same number of coordinates.
#[derive(Clone, Debug)]
pub(crate) struct PointList(pub Arc<Points>);

/// Rows (u) of columns (v) of points, or of heights, which are points of one coordinate; `null` stands
/// for a missing one.
#[derive(Clone, Debug)]
pub(crate) struct PointGrid {
    /// The points, row by row; the values of missing ones are undefined.
    pub points: Arc<Points>,
    /// The indices of missing points, increasing.
    pub missing: Vec<usize>,
    /// Rows and columns.
    pub grid: Grid,
}

/// Lists of points, one after the other: the sections of a surface.
#[derive(Clone, Debug)]
pub(crate) struct SectionList {
    /// The points of all sections.
    pub points: PointList,
    /// The number of points of each.
    pub counts: Vec<usize>,
}

impl Serialize for PointList {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Part(&self.0, 0..self.0.len(), &[]).serialize(serializer)
    }
}

impl Serialize for PointGrid {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let start = |row: usize| row * self.grid.columns;
        let rows = (0..self.grid.rows).map(|row| start(row)..start(row + 1));
        serializer.collect_seq(rows.map(|row| Part(&self.points, row, &self.missing)))
    }
}

impl Serialize for SectionList {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let ends = self.counts.iter().scan(0, |end, count| {
            *end += count;
            Some(*end - count..*end)
        });
        serializer.collect_seq(ends.map(|section| Part(&self.points.0, section, &[])))
    }
}

/// Some of the points, of which those with these indices are missing.
struct Part<'a>(&'a Points, Range<usize>, &'a [usize]);

impl Serialize for Part<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, indices, missing) = self;
        let is_given = |index: &usize| missing.binary_search(index).is_err();
        let point = |index| Point(points, index);
        serializer.collect_seq(
            indices
                .clone()
                .map(|index| Some(index).filter(is_given).map(point)),
        )
    }
}

struct Point<'a>(&'a Points, usize);

impl Serialize for Point<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.point(self.1))
    }
}

impl PointList {
    /// The grid of a single column that they are.
    pub(crate) fn grid(&self) -> Grid {
        Grid {
            rows: self.0.len(),
            columns: 1,
        }
    }
}

/// As those of a grid with a single column.
impl From<PointList> for PointGrid {
    fn from(list: PointList) -> Self {
        Self {
            grid: list.grid(),
            points: list.0,
            missing: Vec::new(),
        }
    }
}

impl<'de> Deserialize<'de> for PointList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let points = read_points(deserializer, list_limits::current())?;
        Ok(Self(Arc::new(points)))
    }
}

impl<'de> Deserialize<'de> for SectionList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (points, counts) = read_sections(deserializer, list_limits::current())?;
        Ok(Self {
            points: PointList(Arc::new(points)),
            counts,
        })
    }
}

impl<'de> Deserialize<'de> for PointGrid {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Rows {
            points,
            missing,
            grid,
        } = read_rows(deserializer, list_limits::current())?;
        Ok(Self {
            points: Arc::new(points),
            missing,
            grid,
        })
    }
}
