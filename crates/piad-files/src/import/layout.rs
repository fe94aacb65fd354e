//! What stands where in the lines of a file, and which lines are words instead of points.

use super::error::FileError;
use super::number_format::Notation;
use crate::short::quoted;

/// The most columns of a file, most of which are not read.
pub(super) const MOST_COLUMNS: usize = 1000;

/// The most coordinates of a point.
const MOST_COORDINATES: usize = 3;

/// Where in a line the coordinates stand.
#[derive(Debug)]
pub(super) struct Layout {
    notation: Notation,
    /// The number of columns.
    pub(super) width: usize,
    /// The columns of the coordinates.
    coordinates: Vec<usize>,
    /// The names of these, if there are any.
    pub(super) named: bool,
}

impl Layout {
    /// The layout of a file whose first line of numbers this is, after that line of words.
    pub(super) fn new(notation: Notation, line: &str, words: Option<&str>) -> Self {
        let width = notation.fields(line).count();
        let named = words.and_then(|words| named_columns(words, notation, width));
        Self {
            notation,
            width,
            named: named.is_some(),
            coordinates: named.unwrap_or_else(|| (0..width.min(MOST_COORDINATES)).collect()),
        }
    }

    /// What is said of columns that are not read.
    pub(super) fn notice(&self) -> Option<String> {
        if self.coordinates.len() == self.width {
            return None;
        }
        let columns = self.coordinates.iter().map(|it| (it + 1).to_string());
        Some(format!(
            "Columns {} of {} are the coordinates; the others are not read.",
            columns.collect::<Vec<_>>().join(", "),
            self.width
        ))
    }

    /// The numbers of a line.
    pub(super) fn numbers(&self, line: &str) -> Vec<f64> {
        let fields = self.notation.fields(line);
        fields
            .filter_map(|field| self.notation.number(field))
            .collect()
    }

    /// The point of a line.
    pub(super) fn point(&self, line: &str) -> Result<Vec<f64>, String> {
        let mut point = vec![0.0; self.coordinates.len()];
        let mut width = 0;
        for (column, field) in self.notation.fields(line).enumerate() {
            width += 1;
            let place = self.coordinates.iter().position(|it| *it == column);
            if let Some(coordinate) = place.and_then(|place| point.get_mut(place)) {
                let number = self.notation.number(field);
                let wrong = || format!("column {}: {} is no number", column + 1, quoted(field));
                *coordinate = number.ok_or_else(wrong)?;
            }
        }
        if width == self.width {
            return Ok(point);
        }
        let columns = match width {
            1 => "1 column".to_owned(),
            width => format!("{width} columns"),
        };
        Err(format!(
            "{columns} here, and {} in the first line of numbers",
            self.width
        ))
    }

    /// How many coordinates points have.
    pub(super) fn dimension(&self) -> usize {
        self.coordinates.len()
    }

    /// Reads the point of a line without blanks around it that has as many columns as the first one and
    /// whose coordinates are plain numbers; `None` for all others, which [`point`](Self::point) looks at.
    pub(super) fn plain_point(&self, line: &[u8], point: &mut [f64]) -> Option<()> {
        let mut rest = line;
        for column in 0..self.width {
            if column > 0 {
                rest = self.next_column(rest)?;
            }
            let place = self.coordinates.iter().position(|it| *it == column);
            let length = match place.and_then(|place| point.get_mut(place)) {
                Some(coordinate) => {
                    let (number, length) = plain_number(rest)?;
                    *coordinate = number;
                    length
                }
                None => self.skipped(rest),
            };
            rest = rest.get(length..)?;
        }
        rest.is_empty().then_some(())
    }

    /// What follows the separator that a text begins with, and the blanks around it.
    fn next_column<'a>(&self, text: &'a [u8]) -> Option<&'a [u8]> {
        let bare = text.trim_ascii_start();
        match self.notation.separator {
            None => (bare.len() < text.len()).then_some(bare),
            Some(separator) => match bare.split_first()? {
                (first, rest) if char::from(*first) == separator => Some(rest.trim_ascii_start()),
                _ => None,
            },
        }
    }

    /// The length of a column that is not read.
    fn skipped(&self, text: &[u8]) -> usize {
        let ends = |byte: &u8| match self.notation.separator {
            None => byte.is_ascii_whitespace(),
            Some(separator) => char::from(*byte) == separator,
        };
        text.iter().position(ends).unwrap_or(text.len())
    }

    /// Whether a line above the points that is none can be a title. It is no point with a coordinate
    /// that is not understood: those begin with a number and have as many columns as the points.
    pub(super) fn is_title(&self, line: &str) -> bool {
        let mut fields = self.notation.fields(line);
        let first = fields.next().unwrap_or("");
        self.notation.number(first).is_none() || fields.count() + 1 != self.width
    }

    /// Whether a line begins with a word.
    pub(super) fn begins_with_word(line: &str) -> bool {
        line.starts_with(|c: char| c.is_alphabetic() || c == '(' || c == '"')
    }

    /// Whether a line that is no point is one that was damaged, and no remark such as a date: it
    /// consists of what numbers consist of, or has a number and as many columns as the points, or
    /// begins with a whole point.
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

/// A column of text in the last of these lines, whose other columns are numbers, at the first line that has it.
pub(super) fn text_column(lines: &[(usize, String)]) -> Option<FileError> {
    let fields: Vec<Vec<Field<'_>>> = lines.iter().map(|(_, line)| Field::all(line)).collect();
    let pairs: Vec<&[Vec<Field<'_>>]> = fields.windows(2).collect();
    let column = Field::common_text(pairs.last()?)?;
    let alike = pairs.iter().rev();
    let alike = alike.take_while(|pair| Field::common_text(pair) == Some(column));
    let first = pairs.len() - alike.count();
    let (line, found) = (lines.get(first)?.0, fields.get(first)?);
    let above = first.checked_sub(1).and_then(|above| fields.get(above));
    let name = above.filter(|names| names.len() == found.len());
    let name = name.and_then(|names| names.get(column));
    let name = name.map_or_else(String::new, |name| format!(" ({})", quoted(name.text)));
    let detail = format!(
        "column {}{name} is text, {} here: points are columns of numbers, so remove it",
        column + 1,
        quoted(found.get(column)?.text)
    );
    Some(FileError::at(line, detail))
}

/// A field of a line that is no line of numbers.
struct Field<'a> {
    text: &'a str,
    kind: FieldKind,
}

#[derive(Clone, Copy, PartialEq)]
enum FieldKind {
    Number,
    Text,
    Empty,
}

impl<'a> Field<'a> {
    fn all(line: &'a str) -> Vec<Self> {
        let notation = Notation::of_fields(line);
        let field = |text| Self {
            text,
            kind: match notation.number(text) {
                Some(_) => FieldKind::Number,
                None if text.is_empty() => FieldKind::Empty,
                None => FieldKind::Text,
            },
        };
        notation
            .fields(line)
            .take(MOST_COLUMNS)
            .map(field)
            .collect()
    }

    /// The first column that is text in both of two lines, of which others are numbers in both.
    fn common_text(lines: &[Vec<Self>]) -> Option<usize> {
        let [first, next] = lines else { return None };
        let both = |kind| {
            let mut pairs = first.iter().zip(next);
            pairs.position(|(first, next)| first.kind == kind && next.kind == kind)
        };
        both(FieldKind::Number).filter(|_| first.len() == next.len())?;
        both(FieldKind::Text)
    }
}

/// The finite number that a text begins with, and its length.
fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
    let is_begun = matches!(text, [b'0'..=b'9' | b'+' | b'-' | b'.', ..]);
    let read = is_begun.then(|| fast_float2::parse_partial::<f64, _>(text).ok());
    read.flatten().filter(|(number, _)| number.is_finite())
}

/// The columns that are called x, y and z, of so many; those of them that there are, if they begin
/// with x.
fn named_columns(words: &str, notation: Notation, width: usize) -> Option<Vec<usize>> {
    let of_names = Notation::of_names(words);
    let names = of_names.fields(words).take(MOST_COLUMNS + 1);
    let names: Vec<String> = names.map(str::to_lowercase).collect();
    if names.len() != width {
        return None;
    }
    let found = ["x", "y", "z"].map(|name| names.iter().position(|it| it == name));
    let found: Vec<usize> = found.into_iter().map_while(|column| column).collect();
    if !found.is_empty() {
        return Some(found);
    }
    // Other names, such as t and value, are those of the columns as they stand, if they are separated
    // as the numbers are. Otherwise they are words, such as those of an airfoil.
    let separated = of_names.separates_as(notation) && names.len() > 1;
    separated.then(|| (0..width.min(MOST_COORDINATES)).collect())
}
