//! Control nets and lists of points as JSON.

use serde::{Serialize, Serializer};

use crate::fit::geometry::Geometry;
use crate::fit::points::Points;

/// The complete control net: points for a curve, rows of points for a surface.
pub(super) struct Net<'a>(pub(super) Geometry<'a>);

impl Serialize for Net<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serialize_net(self.0, serializer, |index| Place(self.0, index))
    }
}

/// The weights of the complete control net of a homogeneous fit.
pub(super) struct NetWeights<'a>(pub(super) Geometry<'a>);

impl Serialize for NetWeights<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serialize_net(self.0, serializer, |index| self.0.weight(index))
    }
}

/// Something of each control point: a list for a curve, rows for a surface.
fn serialize_net<S: Serializer, T: Serialize>(
    geometry: Geometry<'_>,
    serializer: S,
    of: impl Fn(usize) -> T + Copy,
) -> Result<S::Ok, S::Error> {
    let rows = 0..geometry.rows();
    match geometry.columns() {
        None => serializer.collect_seq(rows.flat_map(|row| geometry.row(row)).map(of)),
        Some(_) => serializer.collect_seq(rows.map(|row| NetRow { geometry, row, of })),
    }
}

struct NetRow<'a, F> {
    geometry: Geometry<'a>,
    row: usize,
    of: F,
}

impl<T: Serialize, F: Fn(usize) -> T + Copy> Serialize for NetRow<'_, F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.geometry.row(self.row).map(self.of))
    }
}

/// The coordinates of a control point.
struct Place<'a>(Geometry<'a>, usize);

impl Serialize for Place<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.place(self.1))
    }
}

/// Rows of so many points.
pub(super) struct Lines<'a>(pub(super) &'a Points, pub(super) usize);

impl Serialize for Lines<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, columns) = *self;
        let rows = points.len() / columns;
        serializer.collect_seq((0..rows).map(|row| Line(points, row * columns, columns)))
    }
}

/// Points from an index on.
pub(super) struct Line<'a>(pub(super) &'a Points, pub(super) usize, pub(super) usize);

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(points, start, count) = *self;
        serializer.collect_seq((start..start + count).map(|index| Point(points, index)))
    }
}

struct Point<'a>(&'a Points, usize);

impl Serialize for Point<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.point(self.1))
    }
}
