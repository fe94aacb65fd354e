//! Chooses the columns of a table that are coordinates and times, by their names and contents.

use super::imported::{Hints, Kind};
use super::names::{self, Meaning, meaning};
use super::sample::{Content, Sample};
use piad_fit::data::MAX_DIMENSION;

/// The most coordinates of a point, if names do not determine the columns.
const MOST_COORDINATES: usize = 3;

/// The roles of columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Choice {
    /// The columns of the coordinates.
    pub(super) coordinates: Vec<usize>,
    pub(super) time: Option<Time>,
    /// The places of longitude and latitude among the coordinates.
    pub(super) degrees: Option<(usize, usize)>,
    /// A column that is left out if it counts all points, and otherwise is the first one of the coordinates.
    pub(super) counter: Option<usize>,
}

/// The times of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Time {
    pub(super) column: usize,
    /// The unit in seconds.
    pub(super) seconds: f64,
    /// True if they are the parameters by default.
    pub(super) is_parameter: bool,
}

impl Choice {
    pub(super) fn of_coordinates(coordinates: Vec<usize>) -> Self {
        Self {
            coordinates,
            ..Self::default()
        }
    }

    /// Takes coordinates as longitude and latitude if their names say so.
    pub(super) fn with_degrees(mut self, names: &[String]) -> Self {
        let place = |wanted| {
            let mut names = self.coordinates.iter().map(|column| names.get(*column));
            names.position(|name| name.and_then(|it| meaning(it)) == Some(wanted))
        };
        self.degrees = place(Meaning::Longitude).zip(place(Meaning::Latitude));
        self
    }
}

/// Names of columns above their values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named<'a> {
    names: &'a [String],
    sample: &'a Sample<'a>,
}

impl<'a> Named<'a> {
    pub(super) fn new(names: &'a [String], sample: &'a Sample<'a>) -> Self {
        Self { names, sample }
    }

    /// Returns true if there is a column of coordinates with this meaning, even if that alone is not enough.
    pub(super) fn has(self, meaning: Meaning) -> bool {
        self.column(meaning).is_some()
    }

    /// The columns that names choose; `None` if the names are not meaningful.
    pub(super) fn choice(self) -> Option<Choice> {
        let time = self.time();
        let coordinates = self.coordinates();
        // Numbered columns are the axes of a machine, over their times.
        let is_parameter = coordinates.is_none();
        let choice = match coordinates {
            Some(coordinates) => Choice::of_coordinates(coordinates).with_degrees(self.names),
            None => Choice::of_coordinates(self.numbered(time?)?),
        };
        Some(Choice {
            time: time.map(|column| Time {
                is_parameter,
                ..timed(column, Some(self.names))
            }),
            ..choice
        })
    }

    /// The columns of coordinates by their meaning.
    fn coordinates(self) -> Option<Vec<usize>> {
        let of = |meaning| self.column(meaning);
        let z = of(Meaning::Z);
        let plane = |first, second| Some(vec![of(first)?, of(second)?]);
        let mut found = match (of(Meaning::X), of(Meaning::Y), z) {
            (Some(x), Some(y), _) => vec![x, y],
            (Some(x), None, Some(_)) => vec![x],
            (None, Some(y), Some(_)) => vec![y],
            _ => plane(Meaning::East, Meaning::North)
                .or_else(|| plane(Meaning::Longitude, Meaning::Latitude))
                .or_else(|| plane(Meaning::U, Meaning::V))?,
        };
        let is_uvw = of(Meaning::U) == found.first().copied();
        let third = z.or_else(|| of(Meaning::Weight).filter(|_| is_uvw));
        found.extend(third);
        Some(found)
    }

    /// The column of a meaning: the one whose name is no more than that, or else the first one.
    fn column(self, wanted: Meaning) -> Option<usize> {
        let names = self.names.iter().enumerate();
        let found = names.filter(|(column, name)| {
            meaning(name) == Some(wanted) && self.sample.is_readable(*column)
        });
        let found = found.min_by_key(|(column, name)| (name.chars().count() > 1, *column));
        found.map(|(column, _)| column)
    }

    fn time(self) -> Option<usize> {
        let is_time = |column: &usize| {
            let name = self.names.get(*column).and_then(|name| meaning(name));
            let content = self.sample.content(*column);
            name == Some(Meaning::Time) && matches!(content, Content::Numbers | Content::Times)
        };
        (0..self.names.len()).find(is_time)
    }

    /// The columns that one name counts, two or more of them: the axes of a robot.
    fn numbered(self, time: usize) -> Option<Vec<usize>> {
        let mut groups: Vec<(String, u32, Vec<usize>)> = Vec::new();
        for (column, name) in self.names.iter().enumerate() {
            let readable = column != time && self.sample.is_readable(column);
            let Some((words, number)) = names::numbered(name).filter(|_| readable) else {
                continue;
            };
            match groups.last_mut() {
                Some((last, next, columns)) if *last == words && *next == number => {
                    *next = number.saturating_add(1);
                    columns.push(column);
                }
                _ => groups.push((words, number.saturating_add(1), vec![column])),
            }
        }
        groups.retain(|(_, _, columns)| columns.len() > 1);
        match <[_; 1]>::try_from(groups) {
            Ok([(_, _, columns)]) if columns.len() <= MAX_DIMENSION => Some(columns),
            // The names do not distinguish positions from velocities.
            _ => None,
        }
    }
}

/// The columns as they stand: those of numbers, without what names and counts the points. `None` if fewer than two are
/// left of several.
pub(super) fn as_they_stand(
    names: Option<&[String]>,
    sample: &Sample<'_>,
    hints: &Hints,
) -> Option<Choice> {
    let mean = |column: usize| meaning(names?.get(column)?);
    let holds = |column: usize| sample.content(column);
    let mut columns: Vec<usize> = (0..sample.width)
        .filter(|it| matches!(holds(*it), Content::Numbers | Content::Times))
        .collect();
    let is_index = |column: usize| {
        let name = names.and_then(|names| names.get(column));
        name.is_some_and(String::is_empty) && sample.counts(column)
    };
    leave_out(&mut columns, 2, |it| {
        mean(it) == Some(Meaning::Id) || is_index(it)
    });
    leave_out(&mut columns, 2, |it| mean(it) == Some(Meaning::Weight));
    let time = columns
        .iter()
        .copied()
        .find(|it| mean(*it) == Some(Meaning::Time) || holds(*it) == Content::Times);
    // Beside one column of values the times are coordinates.
    let least = if hints.times { 1 } else { 2 };
    let is_time = leave_out(&mut columns, least, |it| Some(it) == time);
    // Of times there is one column.
    columns.retain(|it| Some(*it) == time || holds(*it) != Content::Times);
    if columns.is_empty() || (columns.len() < 2 && sample.width > 1 && !is_time) {
        return None;
    }
    let counter = counter(&columns, sample, hints).filter(|_| names.is_none());
    columns.retain(|column| Some(*column) != counter);
    columns.truncate(MOST_COORDINATES);
    Some(Choice {
        time: time.filter(|_| is_time).map(|column| timed(column, names)),
        counter,
        ..Choice::of_coordinates(columns)
    })
}

/// Removes such columns if at least `least` others remain.
fn leave_out(columns: &mut Vec<usize>, least: usize, is_out: impl Fn(usize) -> bool) -> bool {
    let others: Vec<usize> = columns.iter().copied().filter(|it| !is_out(*it)).collect();
    let found = others.len() < columns.len() && others.len() >= least;
    if found {
        *columns = others;
    }
    found
}

/// The first column without a name if it numbers the rows, beside two or three other columns.
fn counter(columns: &[usize], sample: &Sample<'_>, hints: &Hints) -> Option<usize> {
    let first = *columns.first()?;
    // A surface needs three coordinates, so the first of three columns is one.
    let surface = hints.kind == Some(Kind::Surface) || hints.size.is_some();
    let counts = sample.counts(first) && sample.rows.len() > 1;
    let fits = columns.len() == 4 || (columns.len() == 3 && !surface);
    (counts && fits).then_some(first)
}

/// The times of a column.
pub(super) fn timed(column: usize, names: Option<&[String]>) -> Time {
    let name = names.and_then(|names| names.get(column));
    Time {
        column,
        seconds: name.map_or(1.0, |name| names::seconds_of_unit(name)),
        is_parameter: false,
    }
}
