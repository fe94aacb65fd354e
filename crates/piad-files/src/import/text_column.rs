//! Columns of text in a file without two columns of numbers.

use super::columns::MOST_COLUMNS;
use super::error::FileError;
use super::number_format::Notation;
use crate::text::quoted;

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

/// A field of a line that is not a line of numbers.
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
        let separator = Notation::of_names(line).separator;
        let notation = Notation::in_row(line, separator.filter(|it| *it != '\t'));
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
