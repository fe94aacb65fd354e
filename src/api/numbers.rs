//! Reading points and numbers from JSON straight into the arrays that are computed with.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize};

use crate::fit::points::Points;

/// The most coordinates of a point.
pub const MAX_DIMENSION: usize = 3;

/// A list of points: `[[x, y, z], …]`, each with 1, 2 or 3 coordinates, all alike.
#[derive(Debug)]
pub struct PointList(pub Points);

/// Rows (u) of columns (v) of points; `null` stands for a missing one.
#[derive(Debug)]
pub struct PointGrid {
    /// The points, row by row; missing ones at the origin.
    pub points: Points,
    /// The indices of missing points.
    pub missing: Vec<usize>,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
}

impl<'de> Deserialize<'de> for PointList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut gathered = Gathered::default();
        deserializer.deserialize_seq(RowVisitor(&mut gathered))?;
        Ok(Self(gathered.points()))
    }
}

impl<'de> Deserialize<'de> for PointGrid {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(GridVisitor)
    }
}

struct GridVisitor;

impl<'de> Visitor<'de> for GridVisitor {
    type Value = PointGrid;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("rows of points")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<PointGrid, A::Error> {
        let mut gathered = Gathered {
            may_miss: true,
            ..Gathered::default()
        };
        let mut count = 0;
        let mut columns = None;
        while let Some(length) = rows.next_element_seed(Row {
            gathered: &mut gathered,
            columns,
        })? {
            columns = Some(length);
            count += 1;
        }
        Ok(PointGrid {
            missing: std::mem::take(&mut gathered.missing),
            points: gathered.points(),
            rows: count,
            columns: columns.unwrap_or(0),
        })
    }
}

/// A row of a grid, which must have as many points as the first; gives the number of its points.
struct Row<'a> {
    gathered: &'a mut Gathered,
    columns: Option<usize>,
}

impl<'de> DeserializeSeed<'de> for Row<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        let length = deserializer.deserialize_seq(RowVisitor(self.gathered))?;
        match self.columns {
            Some(columns) if columns != length => Err(D::Error::custom(format_args!(
                "this row has {length} points, the first row has {columns}: all rows must have the same number"
            ))),
            _ => Ok(length),
        }
    }
}

/// Points that were read so far.
#[derive(Default)]
struct Gathered {
    /// None before the first point, which says how many coordinates there are.
    points: Option<Points>,
    count: usize,
    may_miss: bool,
    missing: Vec<usize>,
}

impl Gathered {
    fn points(self) -> Points {
        let mut points = self.points.unwrap_or_else(|| Points::zeros(1, self.count));
        points.shrink_to_fit();
        points
    }
}

/// Appends points.
struct RowVisitor<'a>(&'a mut Gathered);

impl<'de> Visitor<'de> for RowVisitor<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of points")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<usize, A::Error> {
        let mut count = 0;
        while list.next_element_seed(PointSeed(self.0))?.is_some() {
            count += 1;
        }
        Ok(count)
    }
}

struct PointSeed<'a>(&'a mut Gathered);

impl<'de> DeserializeSeed<'de> for PointSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        if self.0.may_miss {
            deserializer.deserialize_any(self)
        } else {
            deserializer.deserialize_seq(self)
        }
    }
}

impl<'de> Visitor<'de> for PointSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a point: a list of 1, 2 or 3 numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let mut coordinates = [0.0; MAX_DIMENSION];
        let mut count = 0;
        while let Some(Number(x)) = list.next_element()? {
            if count < MAX_DIMENSION {
                coordinates[count] = x;
            }
            count += 1;
        }
        if !(1..=MAX_DIMENSION).contains(&count) {
            return Err(A::Error::invalid_length(count, &self));
        }
        let before = self.0.count;
        let points = self
            .0
            .points
            .get_or_insert_with(|| Points::zeros(count, before));
        let dimension = points.dimension();
        if dimension != count {
            return Err(A::Error::custom(format_args!(
                "this point has {count} coordinates, the first has {dimension}: all points must have the same number"
            )));
        }
        points.push(&coordinates[..count]);
        self.0.count += 1;
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        if let Some(points) = &mut self.0.points {
            points.push(&[0.0; MAX_DIMENSION]);
        }
        self.0.missing.push(self.0.count);
        self.0.count += 1;
        Ok(())
    }
}

/// A finite number.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Number(pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_f64(NumberVisitor).map(Self)
    }
}

struct NumberVisitor;

impl Visitor<'_> for NumberVisitor {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        Ok(value)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_unit<E: Error>(self) -> Result<f64, E> {
        Err(E::invalid_type(
            Unexpected::Other("null (what many writers make of NaN and Infinity)"),
            &self,
        ))
    }
}

/// A name, or explicit numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum NameOrNumbers {
    /// A name.
    Name(String),
    /// Numbers.
    Numbers(Vec<f64>),
}

impl<'de> Deserialize<'de> for NameOrNumbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NameOrNumbersVisitor)
    }
}

struct NameOrNumbersVisitor;

impl<'de> Visitor<'de> for NameOrNumbersVisitor {
    type Value = NameOrNumbers;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a name or a list of numbers")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<NameOrNumbers, E> {
        Ok(NameOrNumbers::Name(name.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<NameOrNumbers, A::Error> {
        let mut numbers = Vec::new();
        while let Some(Number(x)) = list.next_element()? {
            numbers.push(x);
        }
        numbers.shrink_to_fit();
        Ok(NameOrNumbers::Numbers(numbers))
    }
}

/// Weights: a list of numbers, or rows of them.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightList {
    /// A list.
    Line(Vec<f64>),
    /// Rows of equal length.
    Grid {
        /// The weights, row by row.
        values: Vec<f64>,
        /// The length of the rows.
        columns: usize,
    },
}

impl<'de> Deserialize<'de> for WeightList {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(WeightListVisitor)
    }
}

struct WeightListVisitor;

impl<'de> Visitor<'de> for WeightListVisitor {
    type Value = WeightList;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of weights, or rows of them")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<WeightList, A::Error> {
        let mut values = Vec::new();
        let mut columns = None;
        while let Some(length) = list.next_element_seed(WeightElement(&mut values))? {
            if *columns.get_or_insert(length) != length {
                return Err(A::Error::custom(
                    "all rows of weights must have the same length",
                ));
            }
        }
        Ok(match columns.flatten() {
            None => WeightList::Line(values),
            Some(columns) => WeightList::Grid { values, columns },
        })
    }
}

/// A weight, or a row of weights, of which the length is given.
struct WeightElement<'a>(&'a mut Vec<f64>);

impl<'de> DeserializeSeed<'de> for WeightElement<'_> {
    type Value = Option<usize>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for WeightElement<'_> {
    type Value = Option<usize>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a weight or a row of weights")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        self.0.push(value);
        Ok(None)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let before = self.0.len();
        while let Some(Number(x)) = list.next_element()? {
            self.0.push(x);
        }
        Ok(Some(self.0.len() - before))
    }
}
