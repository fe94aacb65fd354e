//! Settings of methods that are more than a number or a name: a relaxation, a matrix, the index of a
//! point.

use std::fmt;
use std::num::NonZeroU32;

use schemars::json_schema;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::lists::{Lists, PointNumbers};
use super::schema::schema_of;
use super::serde_helpers::{AtMost, Whole, number_or_word};
use piad_fit::data::Grid;
use piad_fit::method::{self as fit, LARGEST, Threshold};

number_or_word!(
    /// A relaxation: a number, or `"auto"` without one.
    Omega(f64),
    "auto",
    "a number between 0 and 2, or \"auto\""
);

impl From<fit::Omega> for Omega {
    fn from(omega: fit::Omega) -> Self {
        Self(omega.given())
    }
}

/// Thresholds: one for all points, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Thresholds {
    /// One for all points.
    All(f64),
    /// One for each point.
    Each(PointNumbers),
}

impl Thresholds {
    /// The thresholds of points that are arranged in a grid, row by row.
    pub(super) fn of_points(self, grid: Grid, surface: bool) -> Result<Threshold, String> {
        Ok(match self {
            Self::All(threshold) => Threshold::All(threshold),
            Self::Each(each) => {
                Threshold::Each(each.of_points(grid, surface, "thresholds")?.into())
            }
        })
    }

    /// Thresholds in the form of a request.
    pub(super) fn of(threshold: &Threshold, grid: Grid, surface: bool) -> Self {
        match threshold {
            Threshold::All(threshold) => Self::All(*threshold),
            Threshold::Each(each) => Self::Each(PointNumbers::new(each.to_vec(), grid, surface)),
        }
    }
}

impl<'de> Deserialize<'de> for Thresholds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let lists = Lists::read(deserializer, "a number, or one for each point", true, 1)?;
        match (&lists.lengths[..], &lists.values[..]) {
            ([], [threshold]) => Ok(Self::All(*threshold)),
            _ => PointNumbers::of(lists, "thresholds").map(Self::Each),
        }
    }
}

/// The rows of a matrix.
pub(crate) type Matrix = AtMost<AtMost<f64, LARGEST>, LARGEST>;

/// The index of a point: of a curve `i`, of a surface `[row, column]`. It takes eight bytes, since lists of
/// them may be as long as a body allows: a column is kept as the number behind it, which is not zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    /// Of a curve, and of scattered points.
    Single(u32),
    /// Of the points of a surface in rows: the row, and the number of columns up to this one.
    Pair(u32, NonZeroU32),
}

const _: () = assert!(size_of::<Index>() == 8);

impl Index {
    /// The index of a point in rows of `columns` points, or without rows.
    pub(crate) fn new(index: usize, columns: Option<usize>) -> Self {
        match columns {
            None => Self::Single(clamped(index)),
            Some(columns) => Self::pair(index / columns.max(1), index % columns.max(1)),
        }
    }

    /// The index of a row and a column.
    pub(crate) fn pair(row: usize, column: usize) -> Self {
        let behind = NonZeroU32::MIN.saturating_add(clamped(column));
        Self::Pair(clamped(row), behind)
    }

    /// The index in the list of all points, row by row. That a point of a curve exists is checked with the problem.
    pub(super) fn of_point(self, grid: Grid, surface: bool) -> Result<usize, String> {
        let Grid { rows, columns } = grid;
        match (self, surface && grid.is_rows()) {
            (Self::Single(i), false) => Ok(i as usize),
            (Self::Pair(i, j), true) => {
                let (i, j) = (i as usize, j.get() as usize - 1);
                if i < rows && j < columns {
                    return Ok(i * columns + j);
                }
                Err(format!(
                    "[{i}, {j}] lies outside the {rows} rows and {columns} columns"
                ))
            }
            (Self::Pair(..), false) => {
                let whose = if surface {
                    "scattered points"
                } else {
                    "the points of a curve"
                };
                Err(format!("{whose} have single indices"))
            }
            (Self::Single(_), true) => {
                Err("the points of a surface have indices [row, column]".to_owned())
            }
        }
    }
}

/// An index in four bytes; one that needs more is beyond every job.
fn clamped(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// The stored form of an index, in four bytes.
fn small<E: Error>(index: u64) -> Result<u32, E> {
    let detail = || format!("{index} is not the index of a point: no job has this many");
    u32::try_from(index).map_err(|_| E::custom(detail()))
}

impl Serialize for Index {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Single(index) => index.serialize(serializer),
            Self::Pair(row, behind) => [*row, behind.get() - 1].serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IndexVisitor;

        impl<'de> Visitor<'de> for IndexVisitor {
            type Value = Index;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the index of a point, or [row, column]")
            }

            fn visit_u64<E: Error>(self, index: u64) -> Result<Index, E> {
                small(index).map(Index::Single)
            }

            fn visit_f64<E: Error>(self, index: f64) -> Result<Index, E> {
                let index = Whole::of(index, &self)?;
                small(index as u64).map(Index::Single)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Index, A::Error> {
                let (row, column) = (list.next_element()?, list.next_element()?);
                match (row, column, list.next_element::<Whole>()?) {
                    (Some(Whole(row)), Some(Whole(column)), None) => {
                        let behind = NonZeroU32::MIN.saturating_add(small(column as u64)?);
                        Ok(Index::Pair(small(row as u64)?, behind))
                    }
                    _ => Err(A::Error::custom(
                        "an index of a surface has two numbers, [row, column]",
                    )),
                }
            }
        }

        deserializer.deserialize_any(IndexVisitor)
    }
}

schema_of!(
    Omega,
    "Omega",
    json_schema!({
        "description": "A relaxation between 0 and 2, or \"auto\": 2 / (1 + λ_min), the best one; of `local` fits of up to 200 points with λ_min of their block, of others of the whole matrix. `adaptive` needs a number.",
        "oneOf": [
            {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 2},
            {"type": "string", "const": "auto"},
        ],
        "examples": ["auto", 1.5],
    })
);

schema_of!(Thresholds, "Thresholds", {
    let number = json_schema!({"type": "number", "exclusiveMinimum": 0});
    let line = json_schema!({"type": "array", "items": number, "minItems": 2});
    json_schema!({
        "description": "One number greater than 0, or one for each data point: of a curve a list, of a surface rows of numbers.",
        "oneOf": [
            number,
            {"title": "Line", "type": "array", "items": number, "minItems": 2},
            {"title": "Rows", "type": "array", "items": line, "minItems": 2},
        ],
        "examples": [0.01, [0.01, 0.02, 0.01]],
    })
});

schema_of!(
    Index,
    "PointIndex",
    json_schema!({
        "description": "The index of a data point, from 0: of a curve and of scattered points a number, of a surface [row, column].",
        "oneOf": [
            {"type": "integer", "minimum": 0},
            {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 2, "maxItems": 2},
        ],
        "examples": [17, [2, 3]],
    })
);

schema_of!(
    Matrix,
    "Matrix",
    json_schema!({
        "description": "The rows of a square matrix, with a row and a column for each control point of the direction.",
        "type": "array",
        "items": {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 2,
            "maxItems": LARGEST,
        },
        "minItems": 2,
        "maxItems": LARGEST,
        "examples": [[[1, 0], [0, 1]]],
    })
);

/// The weights of data points in the sum of squares.
pub(crate) enum DataWeights {}

schema_of!(DataWeights, "DataWeights", {
    let number = json_schema!({"type": "number", "minimum": 0});
    let line = json_schema!({"type": "array", "items": number, "minItems": 2});
    json_schema!({
        "description": "A number for each data point, zero or greater: of a curve and of scattered points a list, of a surface rows of numbers.",
        "oneOf": [
            {"title": "Line", "type": "array", "items": number, "minItems": 2},
            {"title": "Rows", "type": "array", "items": line, "minItems": 2},
        ],
        "examples": [[1, 1, 0.5, 2]],
    })
});
