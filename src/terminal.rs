//! Messages for people, on the standard error.
//!
//! A message that cannot be written is lost: a full disk or a closed pipe behind the standard error ends no command.
//! Names of files and other data cannot control the terminal: their control characters are escaped.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{Write, stderr};

/// Writes a line to the standard error.
pub fn say(line: impl Display) {
    let mut line = escaped(&line.to_string()).into_owned();
    line.push('\n');
    let _ = stderr().lock().write_all(line.as_bytes());
}

/// The text with escapes, such as `\u{1b}`, for control characters and for those that turn the direction of the text.
pub(crate) fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(controls) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match controls(c) {
            true => escaped.extend(c.escape_default()),
            false => escaped.push(c),
        }
    }
    Cow::Owned(escaped)
}

/// Returns true for characters that a terminal interprets instead of showing them.
fn controls(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        for (text, shown) in [
            ("wing λ.csv", "wing λ.csv"),
            ("\u{1b}[31mred", "\\u{1b}[31mred"),
            ("a\r\nb\tc", "a\\r\\nb\\tc"),
            ("\u{9b}2J\u{7f}", "\\u{9b}2J\\u{7f}"),
            ("fdp.\u{202e}exe", "fdp.\\u{202e}exe"),
        ] {
            assert_eq!(escaped(text), shown);
        }
    }
}
