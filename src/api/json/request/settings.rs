//! The JSON of settings that are more than a number or a name: a relaxation, a matrix, the index of a
//! point.

use std::fmt;
use std::num::NonZeroU32;
use std::sync::Arc;

use schemars::json_schema;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

use crate::api::json::lists::WeightList;
use crate::api::json::schema::schema_of;
use crate::fit::method::{LARGEST, Threshold};
use crate::fit::points::Grid;
use crate::model::either::{Whole, number_or_word, read_at_most};

number_or_word!(
    /// A relaxation: a number, or `"auto"` without one.
    Omega(f64),
    "auto",
    "a number between 0 and 2, or \"auto\""
);

/// Thresholds: one for all points, or one for each.
#[derive(Clone, Debug)]
pub(in crate::api) enum Thresholds {
    All(f64),
    Each(WeightList),
}

impl Thresholds {
    /// The thresholds of points that are arranged in a grid, row by row.
    pub(super) fn of_points(self, grid: Grid, surface: bool) -> Result<Threshold, String> {
        match self {
            Self::All(threshold) => Ok(Threshold::All(threshold)),
            Self::Each(each) => each_point(each, grid, surface, "thresholds").map(Threshold::Each),
        }
    }
}

/// A number for each point of a curve, or rows of them for a surface. Whether a curve has as many of
/// them as points is checked with the problem.
pub(super) fn each_point(
    list: WeightList,
    grid: Grid,
    surface: bool,
    things: &str,
) -> Result<Arc<[f64]>, String> {
    match (list, surface && grid.is_rows()) {
        (WeightList::Line(each), false) => Ok(each.into()),
        (WeightList::Grid { values, columns }, true) => {
            let rows = values.len() / columns.max(1);
            if (rows, columns) == (grid.rows, grid.columns) {
                return Ok(values.into());
            }
            let Grid {
                rows: needed,
                columns: each,
            } = grid;
            Err(format!(
                "{rows} rows of {columns} {things} for {needed} rows of {each} points"
            ))
        }
        (_, false) if surface => Err(format!(
            "the {things} of scattered points are a list of numbers"
        )),
        (_, false) => Err(format!("the {things} of a curve are a list of numbers")),
        (_, true) => Err(format!("the {things} of a surface are rows of numbers")),
    }
}

impl<'de> Deserialize<'de> for Thresholds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ThresholdVisitor;

        impl<'de> Visitor<'de> for ThresholdVisitor {
            type Value = Thresholds;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or one for each point")
            }

            fn visit_f64<E: Error>(self, x: f64) -> Result<Thresholds, E> {
                Ok(Thresholds::All(x))
            }

            fn visit_u64<E: Error>(self, x: u64) -> Result<Thresholds, E> {
                self.visit_f64(x as f64)
            }

            fn visit_i64<E: Error>(self, x: i64) -> Result<Thresholds, E> {
                self.visit_f64(x as f64)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Thresholds, A::Error> {
                WeightList::deserialize(SeqAccessDeserializer::new(list)).map(Thresholds::Each)
            }
        }

        deserializer.deserialize_any(ThresholdVisitor)
    }
}

/// The rows of a matrix.
#[derive(Clone, Debug)]
pub(in crate::api) struct Matrix(pub(in crate::api) Vec<Vec<f64>>);

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_at_most(deserializer, LARGEST, "rows").map(Self)
    }
}

/// The index of a point: of a curve `i`, of a surface `[row, column]`. It takes eight bytes, since lists of
/// them may be as long as a body allows: a column is kept as the number behind it, which is not zero.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) enum Index {
    Single(u32),
    Pair(u32, NonZeroU32),
}

const _: () = assert!(size_of::<Index>() == 8);

impl Index {
    /// The index in the list of all points, row by row. Whether a point of a curve exists is
    /// checked with the problem.
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

/// An index as it is kept, in four bytes.
fn small<E: Error>(index: u64) -> Result<u32, E> {
    let detail = || format!("{index} is not the index of a point: no job has so many");
    u32::try_from(index).map_err(|_| E::custom(detail()))
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

/// How much data points count.
pub(super) enum DataWeights {}

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
