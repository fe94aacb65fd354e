//! Numbers, lists of numbers and lists of such lists, as JSON has them: weights, vectors, thresholds and
//! parameters.

use std::fmt;
use std::sync::Arc;

use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::list_limits::{current, most_numbers, too_many};
use piad_files::json::ListLimits;
use piad_fit::data::{Grid, MAX_DIMENSION, Points};

/// A number, or numbers in lists within lists, all of a level of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lists {
    /// The numbers, in their order.
    pub values: Vec<f64>,
    /// The lengths of the lists, from the outermost to those of numbers; none of a number alone.
    pub lengths: Vec<usize>,
}

/// The most levels of lists: orders of derivatives, data points of a boundary, coordinates.
const DEEPEST: usize = 3;

/// The expected form of lists without numbers.
pub(crate) const LISTS: &str = "a list of numbers, or of lists of them";

impl Lists {
    /// Reads lists with at most `each` numbers for a data point, or a number where that is one of the things
    /// that are `expected`.
    pub(crate) fn read<'de, D: Deserializer<'de>>(
        deserializer: D,
        expected: &'static str,
        may_be_number: bool,
        each: usize,
    ) -> Result<Self, D::Error> {
        let mut lists = Self::default();
        let limits = current();
        deserializer.deserialize_any(Level {
            lists: &mut lists,
            level: 0,
            expected,
            may_be_number,
            limits,
            most: most_numbers(limits, each),
        })?;
        lists.values.shrink_to_fit();
        Ok(lists)
    }

    /// Notes the end of a list of a level, with its number of entries.
    fn end<E: Error>(&mut self, level: usize, length: usize, before: usize) -> Result<(), E> {
        let has_numbers = self.values.len() == before + length;
        if self.lengths.is_empty() && has_numbers && (length > 0 || level == 0) {
            self.lengths.resize(level + 1, 0);
        }
        let Some(own) = self.lengths.get_mut(level) else {
            let detail = "a list is empty, or stands where others have numbers";
            return Err(E::custom(detail));
        };
        if *own == 0 {
            *own = length;
        }
        if *own != length {
            return Err(E::custom(format_args!(
                "this list has {length} entries, the first of its kind has {own}: all must have the same length"
            )));
        }
        Ok(())
    }
}

/// Reads a list of a level, or a number in one; returns true if it was a list.
struct Level<'a> {
    lists: &'a mut Lists,
    level: usize,
    expected: &'static str,
    may_be_number: bool,
    limits: ListLimits,
    /// The most numbers in all lists.
    most: usize,
}

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = bool;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<bool, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = bool;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<bool, E> {
        self.visit_f64(x as f64)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<bool, E> {
        self.visit_f64(x as f64)
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<bool, E> {
        if !self.may_be_number {
            return Err(E::invalid_type(Unexpected::Float(x), &self));
        }
        // Numbers are in lists of one level, which is known once a list has ended.
        let known = self.lists.lengths.len();
        if known != 0 && known != self.level {
            return Err(E::custom("a number stands here where others have lists"));
        }
        let values = &mut self.lists.values;
        if values.len() == self.most {
            return Err(E::custom(too_many(self.most)));
        }
        self.limits.make_room(values, self.most);
        values.push(x);
        Ok(false)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        if self.level == DEEPEST {
            return Err(A::Error::custom(format_args!(
                "there are at most {DEEPEST} lists within each other"
            )));
        }
        let before = self.lists.values.len();
        let (mut length, mut of_lists) = (0, None);
        loop {
            let inner = Level {
                lists: &mut *self.lists,
                level: self.level + 1,
                expected: "a number or a list of numbers",
                may_be_number: true,
                limits: self.limits,
                most: self.most,
            };
            of_lists = match list.next_element_seed(Element(inner, of_lists))? {
                None => break,
                is_list => is_list,
            };
            length += 1;
        }
        self.lists.end(self.level, length, before)?;
        Ok(true)
    }
}

/// Reads an element of a list, which is a list if those before are lists.
struct Element<'a>(Level<'a>, Option<bool>);

impl<'de> DeserializeSeed<'de> for Element<'_> {
    type Value = bool;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<bool, D::Error> {
        let is_list = self.0.deserialize(deserializer)?;
        match self.1.is_none_or(|it| it == is_list) {
            true => Ok(is_list),
            false => Err(D::Error::custom(
                "numbers stand here beside lists of numbers",
            )),
        }
    }
}

impl Serialize for Lists {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Part(&self.values, &self.lengths).serialize(serializer)
    }
}

/// Numbers in lists of these lengths.
struct Part<'a>(&'a [f64], &'a [usize]);

impl Serialize for Part<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(values, lengths) = *self;
        match lengths {
            [] => values.first().serialize(serializer),
            [_] => values.serialize(serializer),
            [count, inner @ ..] => {
                let parts = values.chunks((values.len() / count.max(&1)).max(1));
                serializer.collect_seq(parts.map(|part| Part(part, inner)))
            }
        }
    }
}

/// Vectors: lists of numbers, none of which is empty.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct Vectors(Lists);

impl<'de> Deserialize<'de> for Vectors {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let lists = Lists::read(deserializer, LISTS, false, MAX_DIMENSION)?;
        match lists.values.is_empty() {
            true => Err(D::Error::custom("a list is empty")),
            false => Ok(Self(lists)),
        }
    }
}

impl Vectors {
    /// One vector.
    pub(crate) fn one(vector: &[f64]) -> Self {
        Self(Lists {
            values: vector.to_vec(),
            lengths: vec![vector.len()],
        })
    }

    /// Vectors of orders, of a boundary of one data point or of many; of a single order without a list
    /// of orders.
    pub(crate) fn of(orders: &[Arc<Points>], is_surface: bool, are_many: bool) -> Self {
        let points = || {
            orders
                .iter()
                .flat_map(|it| (0..it.len()).map(move |k| it.point(k)))
        };
        let first = orders
            .first()
            .map_or((0, 0), |it| (it.len(), it.dimension()));
        let lengths = [
            are_many.then_some(orders.len()),
            is_surface.then_some(first.0),
            Some(first.1),
        ];
        Self(Lists {
            values: points().flatten().collect(),
            lengths: lengths.into_iter().flatten().collect(),
        })
    }

    /// The number of lists, or numbers, in the outermost one.
    pub(crate) fn count(&self) -> usize {
        self.0.lengths.first().copied().unwrap_or(0)
    }

    /// The vectors of each order, of a boundary of one data point or of many; `None` for other lists.
    pub(crate) fn orders(self, is_surface: bool, are_many: bool) -> Option<Vec<Arc<Points>>> {
        let Self(Lists { values, lengths }) = self;
        let mut lengths = lengths.into_iter().rev();
        let dimension = lengths.next()?;
        let boundary = if is_surface { lengths.next()? } else { 1 };
        if are_many {
            lengths.next()?;
        }
        if lengths.next().is_some() || dimension == 0 || dimension > MAX_DIMENSION {
            return None;
        }
        let order = |flat| Arc::new(Points::from_flat(dimension, flat));
        let orders = values.chunks_exact(boundary * dimension);
        Some(orders.map(order).collect())
    }
}

/// Numbers of data points: a list, or rows of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PointNumbers {
    /// A list.
    Line(Vec<f64>),
    /// Rows of equal length.
    Grid {
        /// The numbers, row by row.
        values: Vec<f64>,
        /// The length of the rows.
        columns: usize,
    },
}

impl PointNumbers {
    /// Those of points, row by row, in rows if the points of a surface are.
    pub(crate) fn new(values: Vec<f64>, grid: Grid, is_surface: bool) -> Self {
        match is_surface && grid.is_rows() {
            true => Self::Grid {
                values,
                columns: grid.columns,
            },
            false => Self::Line(values),
        }
    }

    /// The numbers of a list; `None` for other lists.
    pub(super) fn of<E: Error>(lists: Lists, things: &str) -> Result<Self, E> {
        match lists.lengths[..] {
            [_] => Ok(Self::Line(lists.values)),
            [_, columns] => Ok(Self::Grid {
                values: lists.values,
                columns,
            }),
            _ => Err(E::custom(format_args!(
                "expected a list of {things}, or rows of them"
            ))),
        }
    }

    /// The numbers of points in a grid, row by row. The length of a list is checked with the problem.
    pub(super) fn of_points(
        self,
        grid: Grid,
        surface: bool,
        things: &str,
    ) -> Result<Vec<f64>, String> {
        let points = match surface {
            _ if surface && grid.is_rows() => "a surface are rows",
            true => "scattered points are a list",
            false => "a curve are a list",
        };
        match (self, surface && grid.is_rows()) {
            (Self::Line(values), false) => Ok(values),
            (Self::Grid { values, columns }, true) => {
                let rows = values.len() / columns.max(1);
                if (rows, columns) == (grid.rows, grid.columns) {
                    return Ok(values);
                }
                let Grid {
                    rows: needed,
                    columns: each,
                } = grid;
                Err(format!(
                    "{rows} rows of {columns} {things} for {needed} rows of {each} points: one for each is needed"
                ))
            }
            _ => Err(format!("the {things} of {points} of numbers")),
        }
    }
}

impl<'de> Deserialize<'de> for PointNumbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::of(Lists::read(deserializer, LISTS, false, 1)?, "weights")
    }
}

impl Serialize for PointNumbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Line(values) => values.serialize(serializer),
            Self::Grid { values, columns } => {
                serializer.collect_seq(values.chunks((*columns).max(1)))
            }
        }
    }
}
