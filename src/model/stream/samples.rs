//! Numbers of samples.

use std::fmt;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::model::serde_helpers::Whole;
use piad_files::text::quoted;
use piad_fit::data::Grid;

/// The most points that are sampled.
pub(crate) const MOST_SAMPLES: usize = 1_000_000;

/// A requested number of samples: of a curve one number, of a surface one for each direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// This many points of a curve.
    Count(usize),
    /// This many rows and columns of points of a surface.
    Grid(usize, usize),
}

impl Samples {
    /// Reads `200` or `40x40`.
    pub fn of_text(text: &str) -> Option<Self> {
        match text.split_once('x') {
            None => text.parse().ok().map(Self::Count),
            Some((rows, columns)) => {
                let rows = rows.parse().ok()?;
                Some(Self::Grid(rows, columns.parse().ok()?))
            }
        }
    }

    /// The grid of samples of a curve or a surface, if this is a number of samples for it: at least 2 in
    /// each direction and [`MOST_SAMPLES`] in all.
    pub fn grid(self, surface: bool) -> Option<Grid> {
        let grid = match (self, surface) {
            (Self::Count(rows), false) => Grid { rows, columns: 1 },
            (Self::Grid(rows, columns), true) if columns >= 2 => Grid { rows, columns },
            _ => return None,
        };
        let count = grid.rows.saturating_mul(grid.columns);
        (grid.rows >= 2 && count <= MOST_SAMPLES).then_some(grid)
    }
}

/// Its text: `200` or `40x40`.
impl fmt::Display for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => write!(f, "{count}"),
            Self::Grid(rows, columns) => write!(f, "{rows}x{columns}"),
        }
    }
}

impl Serialize for Samples {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Count(count) => count.serialize(serializer),
            Self::Grid(..) => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for Samples {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SamplesVisitor;

        impl Visitor<'_> for SamplesVisitor {
            type Value = Samples;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number for a curve, or \"40x40\" for a surface")
            }

            fn visit_u64<E: Error>(self, count: u64) -> Result<Samples, E> {
                let count = usize::try_from(count).unwrap_or(usize::MAX);
                Ok(Samples::Count(count))
            }

            fn visit_f64<E: Error>(self, count: f64) -> Result<Samples, E> {
                Whole::of(count, &self).map(Samples::Count)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Samples, E> {
                if !text.contains('x') {
                    return Err(E::invalid_type(Unexpected::Str(text), &self));
                }
                Samples::of_text(text).ok_or_else(|| E::custom(not_samples(text, true)))
            }
        }

        deserializer.deserialize_any(SamplesVisitor)
    }
}

/// The error for an invalid number of samples of a curve or a surface.
pub(crate) fn not_samples(text: &str, surface: bool) -> String {
    let form = match surface {
        false => "200 for a curve",
        true => "40x40 for a surface",
    };
    format!(
        "{} is not a number of samples such as {form}, at least 2 in each direction and {MOST_SAMPLES} in all",
        quoted(text)
    )
}
