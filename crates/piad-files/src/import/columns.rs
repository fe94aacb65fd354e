//! Columns as a user chooses them.

mod resolve;

use super::names::{Meaning, meaning};
use crate::text::quoted;
use piad_fit::data::MAX_DIMENSION;

/// The most columns of a file, most of which are not read.
pub(super) const MOST_COLUMNS: usize = 1000;

pub(super) use resolve::Names;

/// The refusal of weights.
const NO_WEIGHTS: &str = "weights of points are not read from tables (w=), as they may be those of a rational fit or of a least-squares one: give them in JSON, as curve.weights or method.data_weights";

/// The columns of coordinates, and that of times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    time: Option<Column>,
    coordinates: Vec<Range>,
}

/// One column of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Column {
    /// From 1.
    Number(usize),
    Name(String),
}

/// A column, or all from one to another.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Range {
    One(Column),
    /// The text too, as it may be a name with a colon.
    Many(String, Column, Column),
}

impl Columns {
    /// Columns by numbers from 1 or by names, as `x=2,y=3,t=1` or `t,q1:q7`: a name that means time is that of the times,
    /// and the other columns are coordinates in this order.
    ///
    /// # Errors
    ///
    /// The error in the text.
    pub fn of_text(text: &str) -> Result<Self, String> {
        let mut parsed = Parsed::default();
        for entry in text.split(',').map(str::trim) {
            parsed.add(entry)?;
        }
        parsed.columns()
    }

    /// The columns from the first one up to this number.
    pub(super) fn first(count: usize) -> Self {
        let one = |number| Range::One(Column::Number(number));
        Self {
            time: None,
            coordinates: (1..=count).map(one).collect(),
        }
    }

    /// Returns true if a column is chosen by its name.
    pub(super) fn has_names(&self) -> bool {
        let is_name = |column: &Column| matches!(column, Column::Name(_));
        let has_name = |range: &Range| match range {
            Range::One(column) => is_name(column),
            Range::Many(_, from, to) => is_name(from) || is_name(to),
        };
        self.time.as_ref().is_some_and(is_name) || self.coordinates.iter().any(has_name)
    }
}

/// The entries of a text so far.
#[derive(Default)]
struct Parsed {
    /// The columns of x, y and z.
    axes: [Option<Column>; 3],
    time: Option<Column>,
    /// Those without a role, and whether a name means time.
    plain: Vec<Range>,
}

impl Parsed {
    fn add(&mut self, entry: &str) -> Result<(), String> {
        if entry.is_empty() {
            let detail = "an entry of the columns is empty: they are as x=2,y=3,t=1, or t,q1:q7";
            return Err(detail.to_owned());
        }
        let Some((role, column)) = entry.split_once('=') else {
            let range = Range::of_text(entry)?;
            return match range.meaning() {
                Some(Meaning::Time) => self.set_time(range),
                _ => {
                    self.plain.push(range);
                    Ok(())
                }
            };
        };
        let range = Range::of_text(column.trim())?;
        let axis = match role.trim().to_lowercase().as_str() {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "t" | "time" => return self.set_time(range),
            "w" | "weight" => return Err(NO_WEIGHTS.to_owned()),
            role => {
                return Err(format!(
                    "unknown role {} of a column; expected one of x, y, z and t",
                    quoted(role)
                ));
            }
        };
        let slot = self.axes.get_mut(axis);
        let column = range.one()?;
        match slot.map(|slot| slot.replace(column)) {
            Some(None) => Ok(()),
            _ => Err(format!("two columns are given for {}", role.trim())),
        }
    }

    fn set_time(&mut self, range: Range) -> Result<(), String> {
        let column = range.one()?;
        match self.time.replace(column) {
            None => Ok(()),
            Some(_) => Err("two columns are given for the times".to_owned()),
        }
    }

    fn columns(self) -> Result<Columns, String> {
        let has_role = |axis: usize| matches!(self.axes.get(axis), Some(Some(_)));
        let missing = [("y", "x", 1, 0), ("z", "x", 2, 0), ("z", "y", 2, 1)];
        let missing = missing
            .into_iter()
            .find(|(_, _, given, wanted)| has_role(*given) && !has_role(*wanted));
        if let Some((given, wanted, ..)) = missing {
            return Err(format!(
                "there is a column for {given} and none for {wanted}"
            ));
        }
        if has_role(0) && !self.plain.is_empty() {
            let detail = "some columns have a role and others have none: give all coordinates as x=, y= and z=, or none of them";
            return Err(detail.to_owned());
        }
        let is_uvw = ["u", "v"].iter().all(|name| self.has_plain(name));
        let is_weight = |range: &Range| range.meaning() == Some(Meaning::Weight) && !is_uvw;
        if self.plain.iter().any(is_weight) {
            return Err(NO_WEIGHTS.to_owned());
        }
        let axes = self.axes.into_iter().flatten().map(Range::One);
        let coordinates: Vec<Range> = axes.chain(self.plain).collect();
        if coordinates.is_empty() {
            return Err("no column is one of coordinates".to_owned());
        }
        let least: usize = coordinates.iter().map(Range::least).sum();
        if least > MAX_DIMENSION {
            return Err(too_many(least));
        }
        let columns = Columns {
            time: self.time,
            coordinates,
        };
        columns.check_twice()?;
        Ok(columns)
    }

    fn has_plain(&self, name: &str) -> bool {
        let mut ranges = self.plain.iter();
        ranges.any(|it| matches!(it, Range::One(Column::Name(it)) if it.eq_ignore_ascii_case(name)))
    }
}

impl Columns {
    /// Refuses a column that the text chooses twice.
    fn check_twice(&self) -> Result<(), String> {
        let mut seen: Vec<String> = Vec::new();
        let time = self.time.iter().map(Column::text);
        for text in time.chain(self.coordinates.iter().flat_map(Range::texts)) {
            let text = text.to_lowercase();
            if seen.contains(&text) {
                return Err(format!("column {text} is chosen twice"));
            }
            seen.push(text);
        }
        Ok(())
    }
}

impl Range {
    fn of_text(text: &str) -> Result<Self, String> {
        let Some((from, to)) = text.split_once(':') else {
            return Ok(Self::One(Column::of_text(text)?));
        };
        let (from, to) = (Column::of_text(from)?, Column::of_text(to)?);
        if let (Column::Number(from), Column::Number(to)) = (&from, &to)
            && from > to
        {
            return Err(format!(
                "columns {text} are not a range: give the lower number first"
            ));
        }
        Ok(Self::Many(text.to_owned(), from, to))
    }

    /// The only column.
    fn one(self) -> Result<Column, String> {
        match self {
            Self::One(column) => Ok(column),
            Self::Many(text, ..) => Err(format!(
                "{} are several columns, and one is wanted",
                quoted(&text)
            )),
        }
    }

    /// What the name of a column means, if it is one.
    fn meaning(&self) -> Option<Meaning> {
        match self {
            Self::One(Column::Name(name)) => meaning(name),
            _ => None,
        }
    }

    /// The least number of columns that it can be.
    fn least(&self) -> usize {
        match self {
            Self::Many(_, Column::Number(from), Column::Number(to)) => to - from + 1,
            _ => 1,
        }
    }

    /// The columns as texts, if they are known without a file.
    fn texts(&self) -> Vec<String> {
        match self {
            Self::One(column) => vec![column.text()],
            Self::Many(_, Column::Number(from), Column::Number(to)) => {
                let numbers = (*from..=*to).take(MAX_DIMENSION);
                numbers.map(|number| number.to_string()).collect()
            }
            Self::Many(text, ..) => vec![text.clone()],
        }
    }
}

impl Column {
    fn of_text(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text.is_empty() {
            return Err("a column is missing before or behind a = or a colon".to_owned());
        }
        if !text.chars().all(|c| c.is_ascii_digit()) {
            return Ok(Self::Name(text.to_owned()));
        }
        match text.parse() {
            Ok(number) if (1..=MOST_COLUMNS).contains(&number) => Ok(Self::Number(number)),
            _ => Err(format!(
                "column {} does not exist: they are numbered from 1 to at most {MOST_COLUMNS}",
                quoted(text)
            )),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Name(name) => name.clone(),
        }
    }
}

/// The refusal of too many coordinates.
fn too_many(count: usize) -> String {
    format!("{count} columns are coordinates, and points have at most {MAX_DIMENSION}")
}

#[cfg(test)]
mod tests;
