//! The words of a text with their lines, and the numbers among them.

use super::super::byte_lines;
use super::super::line::line_end;

/// The words of a text with their lines.
#[derive(Clone, Debug)]
pub(super) struct Tokens<'a> {
    /// What follows the last word.
    pub(super) rest: &'a [u8],
    /// What lines end with.
    pub(super) end: u8,
    /// The line of the last word, from 1.
    pub(super) line: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            rest: text.as_bytes(),
            end: line_end(text) as u8,
            line: 1,
        }
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let mut start = 0;
        while let Some(byte) = self
            .rest
            .get(start)
            .filter(|byte| byte.is_ascii_whitespace())
        {
            self.line += usize::from(*byte == self.end);
            start += 1;
        }
        let rest = self.rest.get(start..)?;
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let (token, rest) = rest.split_at_checked(length.unwrap_or(rest.len()))?;
        self.rest = rest;
        (!token.is_empty()).then_some(token)
    }
}

/// A number, also with a decimal comma; `nan` is one.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let plain = byte_lines::number(word);
    plain.or_else(|| {
        let comma = word.iter().position(|byte| *byte == b',')?;
        let mut word = word.to_vec();
        *word.get_mut(comma)? = b'.';
        fast_float2::parse(&word).ok()
    })
}
