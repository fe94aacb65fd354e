//! The lines of DXF: a group code and its value, two lines each.

use crate::import::error::FileError;
use crate::import::line::line_end;
use crate::text::quoted;

/// A value and what it means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'a> {
    pub(super) code: i32,
    pub(super) value: &'a str,
    /// The line of the value, from 1.
    pub(super) line: u32,
}

/// The pairs of a text, without comments.
pub(super) struct Pairs<'a> {
    lines: std::str::Split<'a, char>,
    line: u32,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let end = line_end(text);
        let body = text.trim_start();
        let blank = text.get(..text.len() - body.len()).unwrap_or_default();
        let above = blank.matches(end).count();
        Self {
            lines: body.split(end),
            line: u32::try_from(above).unwrap_or(u32::MAX),
        }
    }

    fn line(&mut self) -> Option<&'a str> {
        self.line = self.line.saturating_add(1);
        Some(self.lines.next()?.trim())
    }

    /// The next pair; none at the end of the file.
    ///
    /// # Errors
    ///
    /// If there is no group code where one is expected, or it has no value.
    pub(super) fn next(&mut self) -> Result<Option<Pair<'a>>, FileError> {
        loop {
            let Some(text) = self.line() else {
                return Ok(None);
            };
            if text.is_empty() && self.lines.clone().all(|line| line.trim().is_empty()) {
                return Ok(None);
            }
            let line = self.line as usize;
            let code = text.parse().map_err(|_| {
                let detail = format!("{} is not a group code of DXF", quoted(text));
                FileError::at(line, detail)
            })?;
            let value = self.line().ok_or_else(|| {
                let detail = "the file ends without the value of this group: it is cut off";
                FileError::at(line, detail)
            })?;
            if code != COMMENT {
                let line = self.line;
                return Ok(Some(Pair { code, value, line }));
            }
        }
    }
}

/// The group code of comments.
const COMMENT: i32 = 999;
