//! The lines above the heights of a grid: its size, place and steps.

use super::super::byte_lines::text as shown;
use super::super::error::FileError;
use super::tokens::{Tokens, number};
use crate::text::quoted;
use piad_fit::data::Grid;

/// The value of missing heights, unless the file gives another one.
const USUAL_NO_DATA: f64 = -9999.0;

/// Larger values mark missing heights and may be rounded in files; heights are never that large.
const HUGE: f64 = 1e30;

/// The contents of the lines above the heights.
const KEYWORDS: [&str; 11] = [
    "ncols",
    "nrows",
    "xllcorner",
    "xllcenter",
    "yllcorner",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
    "nodata",
];

/// The most words of a header.
const MOST_WORDS: usize = 2 * KEYWORDS.len();

/// Returns true if a text is such a grid.
pub(in super::super) fn is_grid(text: &str) -> bool {
    let mut words = text.split_ascii_whitespace().take(MOST_WORDS);
    let is_keyword = |word: &str| KEYWORDS.iter().any(|it| it.eq_ignore_ascii_case(word));
    let is_size = |word: &str| {
        ["ncols", "nrows"]
            .iter()
            .any(|it| it.eq_ignore_ascii_case(word))
    };
    let (first, second) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    is_keyword(first)
        && number(second.as_bytes()).is_some()
        && (is_size(first) || words.any(is_size))
}

/// A keyword and its number.
pub(super) struct Entry {
    keyword: &'static str,
    value: f64,
    line: usize,
}

/// The text above the heights, and the heights.
pub(super) fn entries(text: &str) -> Result<(Vec<Entry>, Tokens<'_>), FileError> {
    let mut tokens = Tokens::new(text);
    let mut entries = Vec::new();
    loop {
        let heights = tokens.clone();
        let Some(word) = tokens
            .next()
            .filter(|word| word.first().is_some_and(u8::is_ascii_alphabetic))
        else {
            return Ok((entries, heights));
        };
        let is_it = |keyword: &&&str| keyword.as_bytes().eq_ignore_ascii_case(word);
        let Some(keyword) = KEYWORDS.iter().find(is_it) else {
            // An invalid height, such as nan.
            if number(word).is_some() {
                return Ok((entries, heights));
            }
            let detail = format!(
                "{} is not a header line of a grid (ESRI)",
                quoted(&shown(word))
            );
            return Err(FileError::at(tokens.line, detail));
        };
        let value = tokens.next().unwrap_or_default();
        let value = number(value).ok_or_else(|| {
            let detail = format!("{keyword}: {} is no number", quoted(&shown(value)));
            FileError::at(tokens.line, detail)
        })?;
        entries.push(Entry {
            keyword,
            value,
            line: tokens.line,
        });
    }
}

/// The contents of the header.
pub(super) struct Head {
    pub(super) grid: Grid,
    /// The place of the south-western height.
    corner: [f64; 2],
    steps: [f64; 2],
    no_data: f64,
}

impl Head {
    pub(super) fn of(entries: &[Entry]) -> Result<Self, FileError> {
        let find = |keyword: &str| entries.iter().find(|entry| entry.keyword == keyword);
        let needed = |keyword: &str| {
            let detail = || format!("the header of the grid has no {keyword} (ESRI)");
            find(keyword).ok_or_else(|| FileError::of_file(detail()))
        };
        let size = |keyword: &str| {
            let entry = needed(keyword)?;
            let is_size = entry.value >= 1.0 && entry.value.fract() == 0.0;
            is_size
                .then_some(entry.value as usize)
                .ok_or_else(|| entry.wrong("a whole number above 0"))
        };
        let step = |keyword: &str| {
            let entry = find(keyword).map_or_else(|| needed("cellsize"), Ok)?;
            let is_step = entry.value > 0.0 && entry.value.is_finite();
            is_step
                .then_some(entry.value)
                .ok_or_else(|| entry.wrong("a number above 0"))
        };
        let steps = [step("dx")?, step("dy")?];
        let start = |center: &str, corner: &str, step: f64| {
            let (entry, inside) = match find(center) {
                Some(entry) => (entry, 0.0),
                None => (needed(corner)?, 0.5 * step),
            };
            let is_place = entry.value.is_finite();
            is_place
                .then_some(entry.value + inside)
                .ok_or_else(|| entry.wrong("a number"))
        };
        let [dx, dy] = steps;
        let no_data = find("nodata_value").or_else(|| find("nodata"));
        Ok(Self {
            grid: Grid {
                rows: size("nrows")?,
                columns: size("ncols")?,
            },
            corner: [
                start("xllcenter", "xllcorner", dx)?,
                start("yllcenter", "yllcorner", dy)?,
            ],
            steps,
            no_data: no_data.map_or(USUAL_NO_DATA, |entry| entry.value),
        })
    }

    /// Returns true if this is the value of a missing height.
    pub(super) fn is_missing(&self, value: f64) -> bool {
        value == self.no_data || value.is_nan() || (self.no_data.abs() > HUGE && value.abs() > HUGE)
    }

    pub(super) fn notice(&self, missing: usize) -> String {
        let Grid { rows, columns } = self.grid;
        let [dx, dy] = self.steps;
        let apart = match dx == dy {
            true => format!("{dx}"),
            false => format!("{dx} and {dy}"),
        };
        let missing = match missing {
            0 => "none of them is missing".to_owned(),
            1 => "1 of them is missing".to_owned(),
            count => format!("{count} of them are missing"),
        };
        format!(
            "The file is a grid of {rows} rows of {columns} heights, {apart} apart (ESRI); {missing}."
        )
    }

    /// The coordinates of the heights.
    pub(super) fn lanes(&self, heights: Vec<f64>) -> [Vec<f64>; 3] {
        let Grid { rows, columns } = self.grid;
        let ([west, south], [dx, dy]) = (self.corner, self.steps);
        let row: Vec<f64> = (0..columns)
            .map(|column| west + column as f64 * dx)
            .collect();
        let y = (0..rows).rev().map(|row| south + row as f64 * dy);
        let y = y.flat_map(|y| std::iter::repeat_n(y, columns));
        [row.repeat(rows), y.collect(), heights]
    }
}

impl Entry {
    fn wrong(&self, expected: &str) -> FileError {
        let detail = format!("{} is {}, and not {expected}", self.keyword, self.value);
        FileError::at(self.line, detail)
    }
}
