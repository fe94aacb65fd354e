//! ASCII grids of ESRI (`.asc`): heights at equal steps, in rows from north to south.
//!
//! - `tokens`: words with their lines, which may be wrapped in any way;
//! - `header`: the lines above the heights.

mod header;
mod tokens;

use super::byte_lines::{text as shown, words};
use super::cloud::too_many;
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::{Order, Part};
use crate::text::quoted;
use header::{Head, entries};
use piad_fit::data::{Grid, Points};
use tokens::{Tokens, number};

pub(super) use header::is_grid;

/// The heights as rows of points. From north to south, as they are in the file: then the normal of the surface points
/// up.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Part, FileErrors> {
    let (entries, tokens) = entries(text)?;
    let head = Head::of(&entries)?;
    let count = head.grid.rows.checked_mul(head.grid.columns);
    let count = count.filter(|count| *count <= hints.most);
    let count = count.ok_or_else(|| FileError::of_file(too_many(hints.most)))?;
    let heights = Heights::read(tokens.clone(), &head, count)?;
    if heights.values.len() != count || heights.beyond.is_some() {
        return Err(miscounted(tokens, &head, &heights).into());
    }
    let missing = heights.missing;
    if missing.len() == count {
        return Err(FileError::of_file("all heights of the grid are missing").into());
    }
    let notice = head.notice(missing.len());
    let points = Points::from_lanes(head.lanes(heights.values));
    Ok(Part {
        missing,
        notices: vec![notice],
        ..Part::ordered(points, heights.lines, Order::Rows(head.grid))?
    })
}

/// The heights of a file, in its order.
struct Heights {
    values: Vec<f64>,
    lines: Vec<u32>,
    /// The indices of missing ones, whose values mean nothing.
    missing: Vec<usize>,
    /// The line of the text below them.
    beyond: Option<usize>,
}

impl Heights {
    /// Reads the announced number of heights, or all of them if there are fewer.
    fn read(mut tokens: Tokens<'_>, head: &Head, count: usize) -> Result<Self, FileError> {
        // Each is a digit and a blank, at least.
        let room = count.min(tokens.rest.len() / 2 + 1);
        let mut heights = Self {
            values: Vec::with_capacity(room),
            lines: Vec::with_capacity(room),
            missing: Vec::new(),
            beyond: None,
        };
        while let Some(token) = tokens.next() {
            if heights.values.len() == count {
                heights.beyond = Some(tokens.line);
                break;
            }
            let value = number(token).ok_or_else(|| {
                let detail = format!("{} is no height", quoted(&shown(token)));
                FileError::at(tokens.line, detail)
            })?;
            let is_missing = head.is_missing(value);
            if is_missing {
                heights.missing.push(heights.values.len());
            } else if !value.is_finite() {
                let detail = format!("{} is out of range", quoted(&shown(token)));
                return Err(FileError::at(tokens.line, detail));
            }
            heights.values.push(if is_missing { 0.0 } else { value });
            heights
                .lines
                .push(u32::try_from(tokens.line).unwrap_or(u32::MAX));
        }
        Ok(heights)
    }
}

/// The error for a file whose number of heights differs from its header. If each row has a line, the error is at the
/// first row of another length.
fn miscounted(tokens: Tokens<'_>, head: &Head, heights: &Heights) -> FileError {
    let Grid { rows, columns } = head.grid;
    // The heights may begin below the end of the last line of the header.
    let lines = tokens.rest.split(|byte| *byte == tokens.end);
    let lines = lines.map(|line| words(line).count()).enumerate();
    let mut lines = lines.filter(|(_, count)| *count > 0).take(rows);
    let has_rows = lines.next().is_some_and(|(_, count)| count == columns);
    let other = lines.find(|(_, count)| has_rows && *count != columns);
    if let Some((index, count)) = other {
        let detail = format!("{count} heights here, and the grid has rows of {columns} (ESRI)");
        return FileError::at(tokens.line + index, detail);
    }
    if let Some(line) = heights.beyond {
        let detail =
            format!("here is more than the {rows} rows of {columns} heights of the grid (ESRI)");
        return FileError::at(line, detail);
    }
    let detail = format!(
        "the file ends after {} heights, and the grid has {rows} rows of {columns} (ESRI)",
        heights.values.len()
    );
    match heights.lines.last() {
        Some(line) => FileError::at(*line as usize, detail),
        None => FileError::of_file(detail),
    }
}

#[cfg(test)]
mod tests;
