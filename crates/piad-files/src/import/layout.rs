//! The columns of the lines of a file, and the detection of lines of words.

use super::choice::Choice;
use super::error::FileError;
use super::head::{Chosen, Head};
use super::imported::Hints;
use super::number_format::{Notation, column_end, is_gap};
use super::sample::{Content, Sample, has_width};
use super::timestamps;
use crate::text::quoted;
use jiff::Timestamp;

use super::columns::MOST_COLUMNS;

/// The columns of a line.
#[derive(Debug)]
pub(super) struct Layout {
    notation: Notation,
    /// The number of columns.
    pub(super) width: usize,
    /// The content of each column.
    slots: Vec<Slot>,
    /// The number of values that are read of a line.
    lanes: usize,
    /// True if the line above names the columns.
    pub(super) named: bool,
    pub(super) choice: Choice,
    /// These names.
    pub(super) names: Option<Vec<String>>,
    /// What each column holds.
    pub(super) contents: Vec<Content>,
}

/// The content of a column.
#[derive(Clone, Copy, Debug)]
enum Slot {
    Nothing,
    /// A number, and its index among those that are read. Text is a gap where times are not used.
    Number {
        place: usize,
        optional: bool,
    },
    /// A time as seconds from this one.
    Time {
        place: usize,
        start: Timestamp,
        optional: bool,
    },
}

impl Layout {
    /// The layout of a file with this first row; `None` if it is not a row.
    ///
    /// # Errors
    ///
    /// If the file does not have the columns that the hints choose.
    pub(super) fn begin(head: Head<'_>, hints: &Hints) -> Result<Option<Self>, FileError> {
        let plain = Notation::of(head.line);
        let Some(notation) = head.notation(plain) else {
            return Ok(None);
        };
        // Words are no row, however many there are.
        let width = notation.fields(head.line).take(MOST_COLUMNS + 1).count();
        if width > MOST_COLUMNS && plain.is_none() {
            return Ok(None);
        }
        if width > MOST_COLUMNS {
            let detail = format!("there are more than {MOST_COLUMNS} columns");
            return Err(FileError::at(head.number, detail));
        }
        let sample = Sample::new(head.line, head.below, notation, head.wanted());
        if plain.is_none() && sample.width < 2 {
            return Ok(None);
        }
        let names = head.names(notation, sample.width);
        let chosen = head.chosen(names.as_ref(), &sample, hints, plain.is_some())?;
        Ok(chosen.and_then(|chosen| {
            let sure = chosen.sure;
            let names = names.map(|it| it.names);
            let layout = Self::new(chosen, names, &sample, hints);
            let is_row = plain.is_some() || layout.is_first_row(&sample, sure);
            is_row.then_some(layout)
        }))
    }

    fn new(chosen: Chosen, names: Option<Vec<String>>, sample: &Sample<'_>, hints: &Hints) -> Self {
        let Chosen { choice, named, .. } = chosen;
        let mut slots = vec![Slot::Nothing; sample.width];
        let columns = choice.counter.iter().chain(&choice.coordinates).copied();
        let columns = columns.chain(choice.time.map(|time| time.column));
        let mut lanes = 0;
        for (place, column) in columns.enumerate() {
            let time = choice.time.filter(|time| time.column == column);
            let optional = time.is_some_and(|time| !time.is_parameter && !hints.times);
            let start = sample.start(column);
            let start = start.filter(|_| sample.content(column) == Content::Times);
            if let Some(slot) = slots.get_mut(column) {
                *slot = match start {
                    Some(start) => Slot::Time {
                        place,
                        start,
                        optional,
                    },
                    None => Slot::Number { place, optional },
                };
            }
            lanes += 1;
        }
        Self {
            notation: sample.notation,
            width: sample.width,
            slots,
            lanes,
            named,
            choice,
            names: names.filter(|_| named),
            contents: (0..sample.width).map(|it| sample.content(it)).collect(),
        }
    }

    /// Returns true if the line of a sample with texts or gaps is its first row: the next one is similar, or the
    /// columns are known and it has a number there.
    fn is_first_row(&self, sample: &Sample<'_>, sure: bool) -> bool {
        let is_point = |row: &&str| self.point(row).is_ok();
        let [first, next] = [0, 1].map(|row| sample.rows.get(row));
        let goes_on = sample.goes_on && next.is_some_and(is_point);
        let is_point = first.is_some_and(is_point);
        (is_point && (sure || goes_on)) || (sure && first.is_some_and(|row| self.has_number(row)))
    }

    /// Returns true if a column that is read has a number in a line.
    fn has_number(&self, line: &str) -> bool {
        let mut read = self.slots.iter().zip(self.notation.all_fields(line));
        read.any(|(slot, field)| {
            !matches!(slot, Slot::Nothing) && self.notation.number(field).is_some()
        })
    }

    /// The numbers of a line.
    pub(super) fn numbers(&self, line: &str) -> Vec<f64> {
        let fields = self.notation.fields(line);
        fields
            .filter_map(|field| self.notation.number(field))
            .collect()
    }

    /// The values that are read of a line: coordinates and times. Missing ones are NaN.
    pub(super) fn point(&self, line: &str) -> Result<Vec<f64>, String> {
        let mut point = vec![0.0; self.lanes];
        let mut width = 0;
        for field in self.notation.all_fields(line) {
            if let Some(slot) = self.slots.get(width) {
                let wrong = |what| format!("column {}: {} is {what}", width + 1, quoted(field));
                let number = self.read(*slot, field).map_err(wrong)?;
                if let Some(lane) = slot.place().and_then(|place| point.get_mut(place)) {
                    *lane = number;
                }
            }
            width += 1;
        }
        if has_width(self.notation, line, self.width) {
            return Ok(point);
        }
        let columns = match width - usize::from(self.notation.ends_empty(line)) {
            1 => "1 column".to_owned(),
            width => format!("{width} columns"),
        };
        Err(format!(
            "{columns} here, and {} in the first line of numbers",
            self.width
        ))
    }

    /// The number of a field, or else its content.
    fn read(&self, slot: Slot, field: &str) -> Result<f64, &'static str> {
        match slot {
            Slot::Nothing => Ok(0.0),
            Slot::Number { optional, .. } => match self.notation.number(field) {
                Some(number) => Ok(number),
                None if optional || is_gap(field) => Ok(f64::NAN),
                None => Err("no number"),
            },
            Slot::Time {
                start, optional, ..
            } => match timestamps::timestamp(field) {
                Some(time) => Ok(timestamps::seconds(start, time)),
                None if optional || is_gap(field) => Ok(f64::NAN),
                None => Err("no time"),
            },
        }
    }

    /// The number of values that are read of each line.
    pub(super) fn lanes(&self) -> usize {
        self.lanes
    }

    /// A line without the blanks around it.
    pub(super) fn trimmed<'a>(&self, line: &'a str) -> &'a str {
        let line = self.trimmed_start(line);
        let blanks = line.bytes().rev();
        let blanks = blanks.take_while(|byte| self.notation.is_blank(*byte));
        line.get(..line.len() - blanks.count()).unwrap_or(line)
    }

    fn trimmed_start<'a>(&self, text: &'a str) -> &'a str {
        let blanks = text.bytes();
        let blanks = blanks.take_while(|byte| self.notation.is_blank(*byte));
        text.get(blanks.count()..).unwrap_or(text)
    }

    /// Returns true if tabs separate columns, so that one at an end of a line is no blank.
    pub(super) fn has_tabs(&self) -> bool {
        self.notation.separator == Some('\t')
    }

    /// Reads the numbers of a trimmed line with the columns of the first one and plain numbers or gaps where they are
    /// read; `None` for all other lines, which [`point`](Self::point) handles.
    pub(super) fn plain_point(&self, line: &str, point: &mut [f64]) -> Option<()> {
        let mut rest = line;
        for (column, slot) in self.slots.iter().enumerate() {
            if column > 0 {
                rest = self.next_column(rest)?;
            }
            let length = match slot {
                Slot::Nothing => column_end(rest, self.notation.separator),
                Slot::Number { .. } | Slot::Time { .. } => {
                    let (number, length) = self.plain_number(*slot, rest)?;
                    *point.get_mut(slot.place()?)? = number;
                    length
                }
            };
            rest = rest.get(length..)?;
        }
        let is_end = rest.is_empty() || self.next_column(rest) == Some("");
        is_end.then_some(())
    }

    /// The number of the column that a text begins with, and the length of the column.
    fn plain_number(&self, slot: Slot, text: &str) -> Option<(f64, usize)> {
        if let (Slot::Number { .. }, Some(found)) = (slot, plain_number(text.as_bytes())) {
            return Some(found);
        }
        let length = column_end(text, self.notation.separator);
        let field = text.get(..length)?.trim();
        if matches!(slot, Slot::Number { .. }) && !is_gap(field) {
            return None;
        }
        Some((self.read(slot, field).ok()?, length))
    }

    /// What follows the separator that a text begins with, and the blanks around it.
    fn next_column<'a>(&self, text: &'a str) -> Option<&'a str> {
        let bare = self.trimmed_start(text);
        match self.notation.separator {
            None => (bare.len() < text.len()).then_some(bare),
            Some(separator) => Some(self.trimmed_start(bare.strip_prefix(separator)?)),
        }
    }

    /// Returns true if a line above the points can be a title. It is not a damaged point: those begin with a number and
    /// have the columns of the points.
    pub(super) fn is_title(&self, line: &str) -> bool {
        let mut fields = self.notation.fields(line);
        let first = fields.next().unwrap_or("");
        self.notation.number(first).is_none() || fields.count() + 1 != self.width
    }

    /// Returns true if a line begins with a word.
    pub(super) fn begins_with_word(line: &str) -> bool {
        line.starts_with(|c: char| c.is_alphabetic() || c == '(' || c == '"')
    }

    /// Returns true if a line has as many columns as the points, of which the first is text.
    pub(super) fn is_row_with_text(&self, line: &str) -> bool {
        self.contents.first() == Some(&Content::Text) && has_width(self.notation, line, self.width)
    }

    /// Returns true if a line that is not a point is a damaged one, and not a remark such as a date: it consists of
    /// characters of numbers, or has a number and the columns of the points, or begins with a whole point.
    pub(super) fn is_damaged(&self, line: &str) -> bool {
        let is_digit = |c: char| c.is_ascii_digit() || "+-.,eEdD".contains(c);
        let is_number: Vec<bool> = self
            .notation
            .fields(line)
            .map(|field| self.notation.number(field).is_some())
            .collect();
        line.split_whitespace()
            .all(|field| field.chars().all(is_digit))
            || (is_number.len() == self.width && is_number.contains(&true))
            || (is_number.len() > self.width && is_number.iter().take(self.width).all(|it| *it))
    }
}

impl Slot {
    fn place(self) -> Option<usize> {
        match self {
            Self::Nothing => None,
            Self::Number { place, .. } | Self::Time { place, .. } => Some(place),
        }
    }
}

/// The finite number that a text begins with, and its length.
fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
    let is_begun = matches!(text, [b'0'..=b'9' | b'+' | b'-' | b'.', ..]);
    let read = is_begun.then(|| fast_float2::parse_partial::<f64, _>(text).ok());
    read.flatten().filter(|(number, _)| number.is_finite())
}
