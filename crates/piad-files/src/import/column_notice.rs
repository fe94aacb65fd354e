//! Notices about the columns of a table: which are the coordinates, and which are skipped.

use super::choice::Choice;
use super::sample::Content;
use crate::text::cut;

/// The most characters of a name in a notice.
const LONGEST_NAME: usize = 40;

/// The most columns that are listed one by one.
const MOST_SAID: usize = 8;

/// The subject of a notice.
#[derive(Clone, Copy, Debug)]
pub(super) struct ColumnNotice<'a> {
    pub(super) choice: &'a Choice,
    pub(super) names: Option<&'a [String]>,
    pub(super) contents: &'a [Content],
    /// True if the times are the parameters.
    pub(super) times: bool,
    /// A column that counts the points.
    pub(super) counter: Option<usize>,
}

/// Why a column is not a coordinate.
#[derive(Clone, Copy, PartialEq)]
enum Why {
    Time,
    Counter,
    Text,
    Other,
}

impl ColumnNotice<'_> {
    /// The notice; `None` if all columns are coordinates.
    pub(super) fn text(&self) -> Option<String> {
        let coordinates = &self.choice.coordinates;
        if coordinates.len() == self.contents.len() {
            return None;
        }
        let others = |why| -> Vec<usize> {
            let columns = 0..self.contents.len();
            columns.filter(|it| self.why(*it) == Some(why)).collect()
        };
        let [times, counters, texts, rest] =
            [Why::Time, Why::Counter, Why::Text, Why::Other].map(others);
        let is_bare = self.names.is_none() && rest.len() + coordinates.len() == self.contents.len();
        if is_bare {
            let columns = coordinates.iter().map(|it| (it + 1).to_string());
            return Some(format!(
                "Columns {} of {} are the coordinates; the others are not read.",
                columns.collect::<Vec<_>>().join(", "),
                self.contents.len()
            ));
        }
        let what = match coordinates.len() {
            1 => "is the coordinate",
            _ => "are the coordinates",
        };
        let mut parts = vec![format!("{} {what}", self.said(coordinates))];
        let used = match self.times {
            true => "has the times",
            false => "has times, which are not used",
        };
        let are = match rest.len() {
            1 => "is",
            _ => "are",
        };
        let is_text = match texts.len() {
            1 => "is text, which is not read",
            _ => "are texts, which are not read",
        };
        let clauses = [
            (times, used.to_owned()),
            (counters, "counts the points and is not read".to_owned()),
            (texts, is_text.to_owned()),
            (rest, format!("{are} not read")),
        ];
        for (columns, what) in clauses {
            if !columns.is_empty() {
                let said = self.said(&columns);
                parts.push(format!("{} {what}", lower(&said)));
            }
        }
        let (first, others) = parts.split_first()?;
        Some(match others {
            [] => format!("{first}."),
            others => format!("{first}; {}.", others.join(", ")),
        })
    }

    fn why(&self, column: usize) -> Option<Why> {
        let content = self.contents.get(column);
        match self.choice.time {
            _ if self.choice.coordinates.contains(&column) => None,
            Some(time) if time.column == column => Some(Why::Time),
            _ if self.counter == Some(column) => Some(Why::Counter),
            _ if content == Some(&Content::Text) => Some(Why::Text),
            _ => Some(Why::Other),
        }
    }

    /// Columns with their numbers and names, such as `Columns 2 (x) and 3 (y)`.
    fn said(&self, columns: &[usize]) -> String {
        let one = |column: usize| {
            let name = self.names.and_then(|names| names.get(column));
            let name = name.filter(|name| !name.is_empty());
            match name {
                Some(name) => format!("{} ({})", column + 1, cut(name, LONGEST_NAME)),
                None => (column + 1).to_string(),
            }
        };
        let in_a_row = columns.windows(2).all(|pair| match pair {
            [before, after] => before + 1 == *after,
            _ => false,
        });
        match columns {
            [column] => format!("Column {}", one(*column)),
            [first, .., last] if in_a_row && columns.len() > 3 => {
                format!("Columns {} to {}", one(*first), one(*last))
            }
            [some @ .., last] if columns.len() <= MOST_SAID => {
                let some: Vec<String> = some.iter().map(|it| one(*it)).collect();
                format!("Columns {} and {}", some.join(", "), one(*last))
            }
            columns => {
                let some = columns.iter().take(MOST_SAID).map(|it| one(*it));
                let some: Vec<String> = some.collect();
                let more = columns.len() - some.len();
                format!("Columns {} and {more} others", some.join(", "))
            }
        }
    }
}

/// A text in lower case, to continue a sentence.
fn lower(text: &str) -> String {
    text.replacen('C', "c", 1)
}
