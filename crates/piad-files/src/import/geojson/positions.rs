//! Coordinates of GeoJSON: lists of lists of positions, to any depth.

use std::fmt;

use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor,
};

use crate::import::curves::Point;
use crate::text::quoted;

/// The positions of one geometry, one after the other.
#[derive(Debug)]
pub(super) struct Positions {
    pub(super) points: Vec<Point>,
    /// Behind which positions a list of them ends.
    ends: Vec<usize>,
    /// The least and the largest number of numbers of a position.
    pub(super) least: usize,
    pub(super) largest: usize,
    /// The nesting depth of all positions.
    depth: Option<usize>,
    /// The nesting depth of the deepest empty list, including it.
    empty: usize,
    /// The error of the first invalid position.
    wrong: Option<String>,
}

impl Positions {
    /// Refuses invalid positions, or another nesting depth.
    ///
    /// # Errors
    ///
    /// The error.
    pub(super) fn check(&self, depth: usize) -> Result<(), String> {
        if let Some(wrong) = &self.wrong {
            return Err(wrong.clone());
        }
        match self.depth {
            Some(found) if found != depth => Err(format!(
                "its coordinates are nested {found} lists deep, and {depth} are expected"
            )),
            Some(found) if found == self.empty => Err("a position has no numbers".to_owned()),
            _ => Ok(()),
        }
    }

    /// The lists of positions.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[Point]> {
        let starts = [0].into_iter().chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .filter_map(|(start, end)| self.points.get(start..*end))
    }

    /// Notes the error of the next position.
    fn refuse(&mut self, detail: impl fmt::Display) {
        if self.wrong.is_none() {
            self.wrong = Some(format!("position {}: {detail}", self.points.len()));
        }
    }

    /// Adds a position at this nesting depth.
    fn push(&mut self, numbers: [f64; 3], count: usize, depth: usize) {
        if count < 2 {
            self.refuse(format!(
                "it has {count} numbers, and at least 2 are expected"
            ));
        } else if self.depth.is_some_and(|it| it != depth) {
            self.refuse("it is not in as many lists as those before it");
        }
        self.depth = Some(depth);
        let [x, y, z] = numbers;
        self.points
            .push([x, y, if count < 3 { f64::NAN } else { z }]);
        self.least = self.least.min(count);
        self.largest = self.largest.max(count);
    }
}

impl<'de> Deserialize<'de> for Positions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut positions = Self {
            points: Vec::new(),
            ends: Vec::new(),
            least: usize::MAX,
            largest: 0,
            depth: None,
            empty: 0,
            wrong: None,
        };
        let element = Element {
            positions: &mut positions,
            depth: 0,
        };
        match element.deserialize(deserializer)? {
            Found::Number(_) | Found::Other => positions.refuse("the coordinates are no list"),
            Found::Position => positions.ends.push(positions.points.len()),
            Found::List | Found::Empty => {}
        }
        positions.points.shrink_to_fit();
        Ok(positions)
    }
}

/// An element of a list, at this nesting depth.
struct Element<'a> {
    positions: &'a mut Positions,
    depth: usize,
}

/// The kind of an element.
#[derive(Clone, Copy, PartialEq)]
enum Found {
    Number(f64),
    /// A list of numbers.
    Position,
    /// A list of lists.
    List,
    Empty,
    Other,
}

impl<'de> DeserializeSeed<'de> for Element<'_> {
    type Value = Found;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Found, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Element<'_> {
    type Value = Found;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("numbers in lists")
    }

    fn visit_f64<E>(self, number: f64) -> Result<Found, E> {
        Ok(Found::Number(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Found, E> {
        Ok(Found::Number(number as f64))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Found, E> {
        Ok(Found::Number(number as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<Found, E> {
        self.positions
            .refuse(format!("{} is no number", quoted(text)));
        Ok(Found::Other)
    }

    fn visit_bool<E>(self, _: bool) -> Result<Found, E> {
        self.positions.refuse("a number is expected");
        Ok(Found::Other)
    }

    fn visit_unit<E>(self) -> Result<Found, E> {
        self.positions.refuse("null is no number");
        Ok(Found::Other)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Found, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        self.positions.refuse("a number is expected");
        Ok(Found::Other)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Found, A::Error> {
        let Self { positions, depth } = self;
        let depth = depth + 1;
        let (mut numbers, mut count) = ([0.0; 3], 0);
        let mut kind = Found::Empty;
        while let Some(found) = list.next_element_seed(Element {
            positions: &mut *positions,
            depth,
        })? {
            let next = match found {
                Found::Number(number) => {
                    if let Some(place) = numbers.get_mut(count) {
                        *place = number;
                    }
                    count += 1;
                    Found::Position
                }
                _ => Found::List,
            };
            if kind != Found::Empty && kind != next {
                positions.refuse("numbers and lists stand in one list");
            }
            // The list that positions stand in is a line.
            kind = next;
        }
        match kind {
            Found::Position => positions.push(numbers, count, depth),
            Found::List if positions.depth == Some(depth + 1) => {
                positions.ends.push(positions.points.len());
            }
            Found::Empty => positions.empty = positions.empty.max(depth),
            _ => {}
        }
        Ok(kind)
    }
}
