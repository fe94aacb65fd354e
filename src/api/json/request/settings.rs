//! The JSON of settings that are more than a number or a name: a relaxation, a matrix, the index of a
//! point.

use std::sync::Arc;

use schemars::json_schema;
use serde::de::SeqAccess;

use crate::api::json::numbers::WeightList;
use crate::api::json::read::values::Element;
use crate::api::json::read::{ListLimits, Most, Numeral, Of, Read, Reader, Reading};
use crate::api::json::schema::schema_of;
use crate::fit::method::{LARGEST, Threshold};
use crate::fit::points::Grid;
use crate::model::short::quoted;

/// A relaxation: a number or `"auto"`.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) enum Omega {
    Auto,
    Given(f64),
}

impl Reader for Of<Omega> {
    type Value = Omega;

    fn expected(&self) -> String {
        "a number between 0 and 2, or \"auto\"".to_owned()
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<Omega> {
        Some(Omega::Given(value.real()))
    }

    fn text(self, value: &str, at: &mut Reading) -> Option<Omega> {
        if value == "auto" {
            return Some(Omega::Auto);
        }
        at.mismatch(&self.expected(), &quoted(value));
        None
    }
}

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

impl Reader for Of<Thresholds> {
    type Value = Thresholds;

    fn expected(&self) -> String {
        "a number, or one for each point".to_owned()
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<Thresholds> {
        Some(Thresholds::All(value.real()))
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Thresholds>, A::Error> {
        Ok(WeightList::reader().list(list, at)?.map(Thresholds::Each))
    }
}

/// The rows of a matrix.
#[derive(Clone, Debug)]
pub(in crate::api) struct Matrix(pub(in crate::api) Vec<Vec<f64>>);

impl Reader for Of<Matrix> {
    type Value = Matrix;

    fn expected(&self) -> String {
        "a matrix, [[a, b], [c, d]]".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Matrix>, A::Error> {
        let mut rows = Vec::new();
        let most = Most::of(LARGEST, "rows");
        let whole = at.elements(
            list,
            most,
            || MatrixRowReader,
            |row, _| {
                rows.push(row);
                Some(())
            },
        )?;
        Ok(whole.then_some(Matrix(rows)))
    }
}

/// Reads a row of a matrix.
struct MatrixRowReader;

impl Reader for MatrixRowReader {
    type Value = Vec<f64>;

    fn expected(&self) -> String {
        "a row of numbers".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Vec<f64>>, A::Error> {
        let mut row = Vec::new();
        let most = Most::of(LARGEST, "entries");
        let whole = at.elements(list, most, f64::reader, |entry, _| {
            row.push(entry);
            Some(())
        })?;
        Ok(whole.then_some(row))
    }
}

/// The index of a point: of a curve `i`, of a surface `[row, column]`.
#[derive(Clone, Copy, Debug)]
pub(in crate::api) enum Index {
    Single(usize),
    Pair(usize, usize),
}

impl Index {
    /// The index in the list of all points, row by row. Whether a point of a curve exists is
    /// checked with the problem.
    pub(super) fn of_point(self, grid: Grid, surface: bool) -> Result<usize, String> {
        match (self, surface && grid.is_rows()) {
            (Self::Single(i), false) => Ok(i),
            (Self::Pair(i, j), true) if i < grid.rows && j < grid.columns => {
                Ok(i * grid.columns + j)
            }
            (Self::Pair(i, j), true) => {
                let Grid { rows, columns } = grid;
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

impl Element for Index {
    const MANY: &'static str = "indices";

    fn most(limits: ListLimits) -> usize {
        limits.points
    }
}

impl Reader for Of<Index> {
    type Value = Index;

    fn expected(&self) -> String {
        "the index of a point, or [row, column]".to_owned()
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<Index> {
        let index = value.whole();
        if index.is_none() {
            at.mismatch(&self.expected(), &value.to_string());
        }
        // Too large for this machine is too large for any list of points.
        index.map(|index| Index::Single(usize::try_from(index).unwrap_or(usize::MAX)))
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Index>, A::Error> {
        let (mut row, mut column, mut more) = (None, None, false);
        let whole = at.elements(list, Most::any(), usize::reader, |k, _| {
            more = column.is_some();
            (row, column) = (row.or(Some(k)), row.and(column.or(Some(k))));
            Some(())
        })?;
        match (row, column) {
            (Some(row), Some(column)) if whole && !more => Ok(Some(Index::Pair(row, column))),
            _ => {
                if whole {
                    at.wrong("an index of a surface has two numbers, [row, column]");
                }
                Ok(None)
            }
        }
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
