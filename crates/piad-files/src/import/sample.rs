//! Classifies the columns of a table by its first rows.

use super::line::without_comment;
use super::number_format::{Notation, is_gap};
use super::timestamps;
use jiff::Timestamp;

/// The most rows that are examined.
const MOST_ROWS: usize = 64;

/// The most lines in which they are searched.
const MOST_LINES: usize = 1000;

/// A column of text has this many times more texts than numbers: codes may be numbers, and a number may be damaged.
const TEXTS_OF_NUMBER: usize = 4;

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Numbers,
    /// Times in ISO 8601.
    Times,
    Text,
    /// Nothing in all of the rows.
    Nothing,
}

/// The lines below the first row of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Below<'a> {
    pub(super) text: &'a str,
    /// The line ends.
    pub(super) end: char,
}

/// The first rows of a table that have as many columns as its first one.
#[derive(Debug)]
pub(super) struct Sample<'a> {
    pub(super) notation: Notation,
    pub(super) width: usize,
    pub(super) rows: Vec<&'a str>,
    /// True if the line below the first row has as many columns.
    pub(super) goes_on: bool,
    columns: Vec<Tally>,
}

/// The numbers of fields of each kind in a column.
#[derive(Clone, Debug, Default)]
struct Tally {
    numbers: usize,
    texts: usize,
    times: usize,
    start: Option<Timestamp>,
    /// True if all rows count on from 0 or 1.
    counts: bool,
}

impl<'a> Sample<'a> {
    /// The rows from this line on.
    pub(super) fn new(
        line: &'a str,
        below: Below<'a>,
        notation: Notation,
        wanted: Option<usize>,
    ) -> Self {
        let width = notation.fields(line).count();
        let next = below.rows().find(|line| !line.is_empty());
        // The last field of the first row may be empty: the names show it, or the next row does.
        let is_wider = notation.ends_empty(line)
            && wanted.or_else(|| Some(notation.fields(next?).count())) == Some(width + 1);
        let width = width + usize::from(is_wider);
        let mut sample = Self {
            notation,
            width,
            rows: vec![line],
            goes_on: next.is_some_and(|next| has_width(notation, next, width)),
            columns: vec![
                Tally {
                    counts: true,
                    ..Tally::default()
                };
                width
            ],
        };
        sample.tally(line);
        for line in below.rows() {
            let enough = sample.rows.len() >= MOST_ROWS;
            // Below a blank line may be remarks.
            if enough || (line.is_empty() && sample.rows.len() > 1) {
                break;
            }
            if has_width(notation, line, width) {
                sample.rows.push(line);
                sample.tally(line);
            }
        }
        sample
    }

    fn tally(&mut self, line: &str) {
        let place = self.rows.len() - 1;
        let columns = self.columns.iter_mut();
        let fields = self.notation.all_fields(line);
        let Some(first) = self.rows.first() else {
            return;
        };
        let mut firsts = self.notation.all_fields(first);
        for (column, field) in columns.zip(fields) {
            let number = self.notation.number(field);
            let first = firsts.next().and_then(|it| self.notation.number(it));
            column.counts &= matches!(first, Some(first) if is_start(first)
                && number == Some(first + place as f64));
            match number {
                Some(_) => column.numbers += 1,
                None if is_gap(field) => {}
                None => match timestamps::timestamp(field) {
                    Some(time) => {
                        column.times += 1;
                        column.start.get_or_insert(time);
                    }
                    // Numbers beyond all bounds are no text.
                    None if field.parse::<f64>().is_ok() => {}
                    None => column.texts += 1,
                },
            }
        }
    }

    /// The content of a column; `Nothing` beyond the last one.
    pub(super) fn content(&self, column: usize) -> Content {
        match self.columns.get(column) {
            Some(it) if it.numbers + it.times + it.texts == 0 => Content::Nothing,
            Some(it) if it.times > 0 && it.numbers + it.texts == 0 => Content::Times,
            Some(it) if it.texts + it.times >= TEXTS_OF_NUMBER * it.numbers => Content::Text,
            Some(_) => Content::Numbers,
            None => Content::Nothing,
        }
    }

    /// Returns true if a column can be one of coordinates: with a number, or with nothing so far.
    pub(super) fn is_readable(&self, column: usize) -> bool {
        let has_number = |it: &Tally| it.numbers > 0 || it.texts + it.times == 0;
        self.columns.get(column).is_some_and(has_number)
    }

    /// The first time of a column.
    pub(super) fn start(&self, column: usize) -> Option<Timestamp> {
        self.columns.get(column)?.start
    }

    /// Returns true if the first row has a number, and the next line as many columns: it is no line of names.
    pub(super) fn is_table(&self) -> bool {
        let mut fields = self
            .rows
            .iter()
            .take(1)
            .flat_map(|row| self.notation.all_fields(row));
        self.goes_on && fields.any(|field| self.notation.number(field).is_some())
    }

    /// Returns true if a column counts the rows from 0 or 1 on.
    pub(super) fn counts(&self, column: usize) -> bool {
        self.columns.get(column).is_some_and(|it| it.counts)
    }
}

impl<'a> Below<'a> {
    /// The lines without comments.
    fn rows(self) -> impl Iterator<Item = &'a str> {
        let lines = self.text.split(self.end).take(MOST_LINES);
        let lines = lines.map(|line| (line.trim().is_empty(), without_comment(line)));
        // Comments are no blank lines.
        lines
            .filter(|(is_blank, line)| *is_blank || !line.is_empty())
            .map(|(_, line)| line)
    }

    /// Returns true if rows separated by tabs have as many columns as this only so: some of them have gaps.
    pub(super) fn needs_tabs(self, width: usize) -> bool {
        let tabs = Notation::in_row("", Some('\t'));
        let blanks = Notation::in_row("", None);
        let mut rows = self.rows().take(MOST_ROWS);
        rows.any(|line| {
            line.contains('\t')
                && blanks.fields(line).count() != width
                && has_width(tabs, line, width)
        })
    }
}

/// Returns true if a counter may begin with this.
pub(super) fn is_start(number: f64) -> bool {
    number == 0.0 || number == 1.0
}

/// Returns true if a line has this many columns, of which the last may be empty, or is followed by a separator.
pub(super) fn has_width(notation: Notation, line: &str, width: usize) -> bool {
    let all = notation.all_fields(line).take(width + 2).count();
    all == width || (all == width + 1 && notation.ends_empty(line))
}
