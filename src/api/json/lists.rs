//! Reads weights, vectors and matrices from JSON: numbers in lists within lists.

use std::cell::RefCell;
use std::fmt;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};

use crate::fit::points::Points;
use crate::model::shape::MAX_DIMENSION;

/// Numbers in lists within lists, all of a level of the same length.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    values: Vec<f64>,
    /// The lengths of the lists, from the outermost to those of numbers.
    lengths: Vec<usize>,
}

/// The most levels of lists: orders of derivatives, data points of a boundary, coordinates.
const DEEPEST: usize = 3;

impl<'de> Deserialize<'de> for Lists {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let lists = RefCell::default();
        deserializer.deserialize_any(Level(&lists, 0))?;
        Ok(lists.into_inner())
    }
}

/// Vectors: lists of numbers, none of which is empty.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Lists")]
pub struct Vectors(Lists);

impl TryFrom<Lists> for Vectors {
    type Error = &'static str;

    fn try_from(lists: Lists) -> Result<Self, &'static str> {
        match lists.values.is_empty() {
            true => Err("a list is empty"),
            false => Ok(Self(lists)),
        }
    }
}

/// Weights: a list of numbers, or rows of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Lists")]
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

impl TryFrom<Lists> for WeightList {
    type Error = &'static str;

    fn try_from(lists: Lists) -> Result<Self, &'static str> {
        let Lists {
            mut values,
            lengths,
        } = lists;
        values.shrink_to_fit();
        match lengths[..] {
            [_] => Ok(Self::Line(values)),
            [_, columns] => Ok(Self::Grid { values, columns }),
            _ => Err("expected a list of weights, or rows of them"),
        }
    }
}

/// Reads a list of a level, or a number in one; gives whether it was a list.
#[derive(Clone, Copy)]
struct Level<'a>(&'a RefCell<Lists>, usize);

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = bool;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<bool, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = bool;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.1 {
            0 => "a list of numbers, or of lists of them",
            _ => "a number or a list of numbers",
        })
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<bool, E> {
        self.visit_f64(x as f64)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<bool, E> {
        self.visit_f64(x as f64)
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<bool, E> {
        let Self(lists, level) = self;
        if level == 0 {
            let found = serde::de::Unexpected::Float(x);
            return Err(E::invalid_type(found, &self));
        }
        let mut lists = lists.borrow_mut();
        // Numbers stand in lists of one level, which is known once a list has ended.
        if !lists.lengths.is_empty() && lists.lengths.len() != level {
            return Err(E::custom("a number stands here where others have lists"));
        }
        lists.values.push(x);
        Ok(false)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        let Self(lists, level) = self;
        if level == DEEPEST {
            return Err(A::Error::custom(format_args!(
                "there are at most {DEEPEST} lists within each other"
            )));
        }
        let before = lists.borrow().values.len();
        let (mut length, mut of_lists) = (0, None);
        while let Some(is_list) =
            list.next_element_seed(Element(Level(lists, level + 1), of_lists))?
        {
            length += 1;
            of_lists = Some(is_list);
        }
        lists.borrow_mut().end(level, length, before)?;
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

impl Lists {
    /// Notes that a list of a level has ended, which has so many entries.
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

impl Vectors {
    /// The vectors of each order, of a boundary of one data point or of many; none if these are other
    /// lists.
    pub fn orders(self, is_surface: bool, are_many: bool) -> Option<Vec<Arc<Points>>> {
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
