//! Resolves the columns that a user chooses.

use super::{Column, Columns, Range, too_many};
use crate::import::choice::{Choice, Time, timed};
use crate::import::error::FileError;
use crate::import::names;
use crate::import::sample::{Content, Sample};
use crate::import::timestamps;
use crate::text::quoted;
use piad_fit::data::MAX_DIMENSION;

/// The most names that an error lists.
const MOST_NAMES: usize = 20;

/// Names of columns, and the line that has them.
#[derive(Clone, Debug)]
pub(in crate::import) struct Names {
    pub(in crate::import) line: usize,
    pub(in crate::import) names: Vec<String>,
}

impl Columns {
    /// The columns in a file with these names and rows, of which the first has this line.
    ///
    /// # Errors
    ///
    /// If the file has no such column, or one of them is chosen twice, or there are more coordinates than points have.
    pub(in crate::import) fn resolved(
        &self,
        names: Option<&Names>,
        sample: &Sample<'_>,
        line: usize,
    ) -> Result<Choice, FileError> {
        let file = File {
            names,
            width: sample.width,
            line: names.map_or(line, |names| names.line),
        };
        let mut coordinates = Vec::new();
        for range in &self.coordinates {
            coordinates.extend(file.columns(range)?);
        }
        let time = self.time.as_ref().map(|it| file.column(it)).transpose()?;
        let mut all: Vec<usize> = coordinates.iter().copied().chain(time).collect();
        all.sort_unstable();
        if let Some([twice, _]) = all.windows(2).find(|pair| pair.first() == pair.last()) {
            return Err(file.error(format!("column {} is chosen twice", twice + 1)));
        }
        if coordinates.len() > MAX_DIMENSION {
            return Err(file.error(too_many(coordinates.len())));
        }
        let names = names.map(|it| &it.names[..]);
        let choice = Choice {
            time: time.map(|column| Time {
                is_parameter: true,
                ..timed(column, names)
            }),
            ..Choice::of_coordinates(coordinates)
        };
        if let Some(column) = time.filter(|it| sample.content(*it) == Content::Text) {
            let detail = format!(
                "column {} has no times: {}",
                column + 1,
                timestamps::EXPECTED
            );
            return Err(file.error(detail));
        }
        Ok(choice.with_degrees(names.unwrap_or_default()))
    }
}

/// The columns that a file has.
struct File<'a> {
    names: Option<&'a Names>,
    width: usize,
    /// The line of the names, or else that of the first row.
    line: usize,
}

impl File<'_> {
    fn error(&self, detail: impl Into<String>) -> FileError {
        FileError::at(self.line, detail)
    }

    fn columns(&self, range: &Range) -> Result<Vec<usize>, FileError> {
        let (text, from, to) = match range {
            Range::One(column) => return Ok(vec![self.column(column)?]),
            Range::Many(text, from, to) => (text, from, to),
        };
        if let Some(column) = self.named(text) {
            return Ok(vec![column]);
        }
        let (from, to) = (self.column(from)?, self.column(to)?);
        match from <= to {
            true => Ok((from..=to).collect()),
            false => Err(self.error(format!(
                "columns {} are not a range: the second one is before the first",
                quoted(text)
            ))),
        }
    }

    fn column(&self, column: &Column) -> Result<usize, FileError> {
        match column {
            Column::Number(number) if *number <= self.width => Ok(number - 1),
            Column::Number(number) => Err(self.error(format!(
                "there is no column {number}: the file has {}",
                self.there_are()
            ))),
            Column::Name(name) => self.named(name).ok_or_else(|| {
                self.error(format!(
                    "no column is called {}: the file has {}",
                    quoted(name),
                    self.there_are()
                ))
            }),
        }
    }

    /// The column of a name in any case, also without the unit that the file has.
    fn named(&self, name: &str) -> Option<usize> {
        let names = &self.names?.names;
        let lower = name.to_lowercase();
        let same = names.iter().position(|it| it.to_lowercase() == lower);
        same.or_else(|| {
            let is_it = |it: &String| !it.is_empty() && names::bare(it) == lower;
            let found: Vec<usize> = (0..names.len())
                .filter(|column| names.get(*column).is_some_and(is_it))
                .collect();
            // Of several matches, such as x (m) and x (ft), none is taken.
            <[usize; 1]>::try_from(found).ok().map(|[column]| column)
        })
    }

    /// The columns of the file.
    fn there_are(&self) -> String {
        let count = match self.width {
            1 => "1 column".to_owned(),
            width => format!("{width} columns"),
        };
        let Some(names) = self.names else {
            return format!("{count} without names");
        };
        let names = names.names.iter().take(MOST_NAMES).map(|it| quoted(it));
        let names = names.collect::<Vec<_>>().join(", ");
        let more = if self.width > MOST_NAMES { ", …" } else { "" };
        format!("{count}, {names}{more}")
    }
}
